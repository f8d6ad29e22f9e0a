/* Lines and words of mapped text files.
 *
 * Text is a file_map's bytes: zeros follow the last one, so that no word runs past the end. */
#ifndef READ_TEXT_H
#define READ_TEXT_H

#include "base/file.h"
#include "base/status.h"

/* A file of text, for messages that name the line. */
typedef struct text_file {
    fathom_context *context;
    const char *path;
    const char *begin, *end;
    char *copy; /* where the text lies when it is not the file's own bytes; else NULL */
} text_file;

/* The text of a mapped file, without a byte order mark. Where its first line ends in a carriage return alone,
 * as on old Macs, it is a copy in which all such ends are line feeds. FATHOM_BAD_INPUT when the file has a
 * hole, zeros that the disk does not store: told at once, though it be terabytes. */
fathom_status text_open(fathom_context *context, const char *path, const file_map *map, text_file *out);
void text_close(text_file *file);

/* The parts of text_open(), for files that are text only in part. text_copy() leaves the line ends to the
 * caller; zeros follow the copy as they do the file. */
const char *text_after_mark(const char *begin, const char *end);
bool text_ends_lines_in_cr(const char *begin, const char *end);
fathom_status text_copy(text_file *file);
/* Turns the carriage returns that no line feed follows into line feeds. */
void text_mend_line_ends(char *begin, const char *end);

/* What is wrong, found on any thread, told later on the calling one. at == NULL: nothing. */
typedef struct text_fault {
    const char *at;
    char field[52]; /* the statement or property; "": none */
    char what[200];
} text_fault;

/* Keeps the first fault of its thread's piece; always returns false. field: may be NULL. */
bool text_wrong(text_fault *fault, const char *at, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* FATHOM_BAD_INPUT, at the fault's line. */
fathom_status text_fail(const text_file *file, const text_fault *fault);
/* Text has no zero bytes: keeps a fault at the first one, if there is one, and returns false. */
bool text_has_no_zeros(text_fault *fault, const char *begin, const char *end);
/* FATHOM_BAD_INPUT when the file has a hole. */
fathom_status text_check_hole(const text_file *file, const file_map *map);
/* From 1. */
size_t text_line(const text_file *file, const char *at);

/* The word at `at` in quotes, or "the end of the line", cut to fit a message. Returns `out`. */
const char *text_quote(const char *at, char out[48]);

/* Pieces of about `grain` bytes that end with a line (a line that ends in a backslash goes on). `starts` gets
 * their count + 1 offsets. NULL when out of memory; release with free(). */
size_t *text_pieces(const text_file *file, size_t grain, size_t *count);

static inline bool text_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
static inline bool text_is_end(char c) { return c == '\n' || c == '\0'; }
/* Whether a word ends here. */
static inline bool text_is_break(char c) { return text_is_blank(c) || text_is_end(c) || c == '\\'; }

/* A backslash at the end of a line; returns what follows the line end, or p. */
static inline const char *text_joined(const char *p) {
    if (*p != '\\') return p;
    if (p[1] == '\n') return p + 2;
    return p[1] == '\r' && p[2] == '\n' ? p + 3 : p;
}

/* Past blanks and joined line ends. */
static inline const char *text_skip(const char *p) {
    for (;;) {
        while (text_is_blank(*p)) ++p;
        const char *joined = text_joined(p);
        if (joined == p) return p;
        p = joined;
    }
}

/* The start of the next line, at most `end`; joined lines count as one. */
const char *text_next(const char *p, const char *end);

/* What is left of the line, without blanks at either end. Returns its length. Names may hold a #, so this
 * knows no comments. */
size_t text_rest(const char **p, const char *end);

#endif
