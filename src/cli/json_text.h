/* Values for JSON that jansson has no call for. */
#ifndef CLI_JSON_TEXT_H
#define CLI_JSON_TEXT_H

#include <fathom/base.h>
#include <jansson.h>
#include <stdint.h>

/* File names and messages need not be UTF-8, JSON must be: in what is not, each byte beyond ASCII becomes
 * '?'. */
json_t *json_text(const char *string);
json_t *json_count(uint64_t number);

/* All of it, indented; real numbers with `digits` digits, 0: with all they need. To be released with free().
 * NULL where memory ran out, also while it was put together: then something is left out in it. */
char *json_dump_text(const json_t *root, unsigned digits);

/* Writes the text of json_dump_text() with 9 digits, and a line end. The file is whole or not there at all.
 */
fathom_status json_write_file(fathom_context *context, const char *path, const json_t *root);

#endif
