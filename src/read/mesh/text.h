/* Lines and words of mapped text files. Zeros follow the last byte, so no word runs past the end. */
#pragma once

#include "base/file.h"
#include "base/status.h"

/* A text file, for messages that name the line. */
typedef struct text_file {
    fathom_context *context;
    const char *path;
    const char *begin, *end;
    char *copy;         /* owned copy of the text; NULL if the file's own bytes are used */
    const char *binary; /* where bytes begin that are not text; NULL: all bytes are text */
    size_t size;        /* of the file */
} text_file;

/* Opens the text of a mapped file, and skips a byte order mark. If the first line ends in a lone carriage
 * return, as on old Macs, the text is a copy with line feeds as line ends. */
fathom_status text_open(fathom_context *context, const char *path, const file_map *map, text_file *out);
void text_close(text_file *file);

/* The parts of text_open(), for files that are only partly text. text_copy() does not change line ends; zeros
 * follow the copy. */
/* The text after a byte order mark, which some editors write. */
const char *text_after_mark(const char *begin, const char *end);
bool text_ends_lines_in_cr(const char *begin, const char *end);
fathom_status text_copy(text_file *file);
/* Replaces carriage returns without a following line feed by line feeds. */
void text_mend_line_ends(char *begin, const char *end);

/* A fault that any thread records, and that the calling thread reports later: out of memory, else the fault
 * that comes first in the file. Zero it before use. */
typedef struct text_fault {
    bool no_memory;
    const char *at; /* NULL: none */
    char field[52]; /* name of the statement or property; "": none */
    char what[200];
} text_fault;

/* These record a fault and return false. field: may be NULL. */
bool text_wrong(text_fault *fault, const void *at, const char *field, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
bool text_no_memory(text_fault *fault);
/* Adds ", found" and the word at `at` to the text. */
#define text_found(fault, at, field, format, ...)                                                            \
    text_wrong(fault, at, field, format ", found %s", ##__VA_ARGS__, text_quote(at, (char[48]){""}))
/* If there is a zero byte, records a fault at the first one and returns false. */
bool text_has_no_zeros(text_fault *fault, const char *begin, const char *end);
/* FATHOM_OK if there is no fault, FATHOM_OUT_OF_RESOURCES, or FATHOM_BAD_INPUT at the fault's line or
 * byte. */
fathom_status text_status(const text_file *file, const text_fault *fault);

/* The word at `at` in quotes, or "the end of the line", truncated to fit a message. Returns `out`. */
const char *text_quote(const char *at, char out[48]);

/* Where the pieces of a text begin, and where the last one ends. Each has about `grain` bytes and ends with a
 * line; a backslash at the end of a line continues it. NULL when out of memory; release with free(). */
const char **text_pieces(const text_file *file, size_t grain, size_t *count);

static inline bool text_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
static inline bool text_is_end(char c) { return c == '\n' || c == '\0'; }
/* True if this character ends a word. */
static inline bool text_is_break(char c) { return text_is_blank(c) || text_is_end(c) || c == '\\'; }

/* Skips a backslash at a line end; returns the start of the next line, or p. */
static inline const char *text_joined(const char *p) {
    if (*p != '\\') return p;
    if (p[1] == '\n') return p + 2;
    return p[1] == '\r' && p[2] == '\n' ? p + 3 : p;
}

/* Skips blanks and joined line ends. */
static inline const char *text_skip(const char *p) {
    for (;;) {
        while (text_is_blank(*p)) ++p;
        const char *joined = text_joined(p);
        if (joined == p) return p;
        p = joined;
    }
}

/* The start of the next line, or `end`; joined lines count as one. */
const char *text_next(const char *p, const char *end);

/* The remaining part of the line without blanks or quotes around it; returns its length. A # between blanks
 * begins a comment. Others are kept, because names may contain them: "Material #25". */
size_t text_rest(const char **p, const char *end);

/* ---- notes: parts of a file that a reader skips or reads differently. One warning for each kind, with its
 * count and its first place. ---- */

#define NOTES_MAX 32 /* kinds; further kinds share one count */

typedef struct note {
    char text[320];   /* identifies the kind */
    char place[128];  /* of the first occurrence, in the form that follows the file's name: ":12", ":
                         meshes[0]", or "" */
    char example[48]; /* the word at that place, or "" */
    size_t count;
} note;

/* Zero it before use; it owns no memory. */
typedef struct note_list {
    note items[NOTES_MAX];
    size_t count, beyond;
} note_list;

/* Adds `times` to the count of the kind that the text identifies. The first call for a kind sets its
 * place. */
void notes_add(note_list *notes, size_t times, const char *place, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* The place is the line of `at`; `quoted`: stores the word there as an example. */
void notes_add_at(note_list *notes, size_t times, const text_file *file, const char *at, bool quoted,
                  const char *format, ...) __attribute__((format(printf, 6, 7)));
/* Warns about all kinds, in the order in which they were added. */
void notes_tell(const note_list *notes, fathom_context *context, const char *path);
