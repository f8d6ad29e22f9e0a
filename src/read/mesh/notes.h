/* What a reader leaves out of a file, or takes otherwise than the file says: one warning for each kind, with
 * how often it was met and where first. All readers say such things here. */
#ifndef READ_NOTES_H
#define READ_NOTES_H

#include "read/mesh/text.h"

#define NOTES_MAX 32 /* kinds; what is beyond is counted together */

typedef struct note {
    char text[320];   /* tells the kinds apart */
    char place[128];  /* of the first, as it follows the file's name: ":12", ": meshes[0]", or "" */
    char example[48]; /* what stands there, or "" */
    size_t count;
} note;

/* Zero it to start with; it owns no memory. */
typedef struct note_list {
    note items[NOTES_MAX];
    size_t count, beyond;
} note_list;

/* Adds `times` of the kind that the text names; 0 adds nothing. The first call of a kind gives its place. */
void notes_add(note_list *notes, size_t times, const char *place, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* The same for a place in a text: its line. */
void notes_add_line(note_list *notes, size_t times, const text_file *file, const char *at, const char *format,
                    ...) __attribute__((format(printf, 5, 6)));
/* And with the word that stands there as an example. */
void notes_add_at(note_list *notes, size_t times, const text_file *file, const char *at, const char *format,
                  ...) __attribute__((format(printf, 5, 6)));
/* Warns of all kinds, in the order in which they were added. */
void notes_tell(const note_list *notes, fathom_context *context, const char *path);

#endif
