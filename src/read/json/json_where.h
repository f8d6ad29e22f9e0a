/* The place of a value in the text of a JSON document. */
#pragma once

#include "base/status.h"

#include <jansson.h>
#include <stdbool.h>

/* One step of a path from the document's root to a value: a key, or an index if key is NULL. The steps are
 * local variables of the functions that walk the document. */
typedef struct where {
    const struct where *parent; /* NULL: the document itself is the parent */
    const char *key;
    size_t index;
} where;

typedef struct where_place {
    unsigned line;     /* from 1; for a member, the line of its key */
    const char *value; /* the value's text */
    size_t length;
    bool whole; /* all steps of the path were found */
} where_place;

/* A place for messages, with a buffer for its path. */
typedef struct where_spot {
    fathom_place place;
    char path[512];
} where_spot;

/* Follows the path through the text, which must be JSON and end with a zero byte. If a step is missing,
 * returns the place of the last value found. */
where_place where_find(const char *text, const where *at);

/* Writes the path as objects[3].radius or materials["dark red"]; "" for the document. */
void where_path(const where *at, char *out, size_t room);

/* jansson's error text. Two texts that mention jansson's parser or flags are replaced by texts about the
 * file. */
static inline const char *json_syntax_text(const json_error_t *error) {
    enum json_error_code code = json_error_code(error);
    if (code == json_error_stack_overflow)
        return "brackets are nested too deep; expected at most 2048 levels";
    if (code == json_error_null_character || code == json_error_null_byte_in_key)
        return "\\u0000 in a string; expected text without zero bytes";
    return error->text;
}

/* FATHOM_BAD_INPUT, at the line and column. */
static inline fathom_status json_syntax_fail(fathom_context *context, const char *path,
                                             const json_error_t *error) {
    const fathom_place place = {.file = path, .line = (size_t)error->line, .column = (size_t)error->column};
    return fail_at(context, FATHOM_BAD_INPUT, &place, "%s", json_syntax_text(error));
}
