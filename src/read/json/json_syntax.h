/* What jansson says of text that is no JSON. */
#ifndef READ_JSON_SYNTAX_H
#define READ_JSON_SYNTAX_H

#include "base/status.h"

#include <jansson.h>

/* Where its own words are of its parser and its flags rather than of the text, better ones. */
static inline const char *json_syntax_text(const json_error_t *error) {
    enum json_error_code code = json_error_code(error);
    if (code == json_error_stack_overflow)
        return "brackets stand within brackets too deep; expected at most 2048 levels";
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

#endif
