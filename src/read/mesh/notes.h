/* What a reader leaves out of a file or reads differently: one warning for each kind, with its count and its
 * first place. */
#ifndef READ_NOTES_H
#define READ_NOTES_H

#include "read/mesh/text.h"

#define NOTES_MAX 32 /* kinds; the others are counted together */

typedef struct note {
    char text[320];   /* identifies the kind */
    char place[128];  /* of the first, as it follows the file's name: ":12", ": meshes[0]", or "" */
    char example[48]; /* the word at that place, or "" */
    size_t count;
} note;

/* Zero it to start with; it owns no memory. */
typedef struct note_list {
    note items[NOTES_MAX];
    size_t count, beyond;
} note_list;

/* Adds `times` to the kind that the text names. The first call for a kind gives its place. */
void notes_add(note_list *notes, size_t times, const char *place, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* The place is the line of `at`; `quoted`: the word there is an example. */
void notes_add_at(note_list *notes, size_t times, const text_file *file, const char *at, bool quoted,
                  const char *format, ...) __attribute__((format(printf, 6, 7)));
/* Warns of all kinds, in the order they were added. */
void notes_tell(const note_list *notes, fathom_context *context, const char *path);

#endif
