/* Values for JSON that jansson has no call for. */
#ifndef CLI_JSON_TEXT_H
#define CLI_JSON_TEXT_H

#include <jansson.h>
#include <stdint.h>

/* File names and messages need not be UTF-8, JSON must be: in what is not, each byte beyond ASCII becomes
 * '?'. */
json_t *json_text(const char *string);
json_t *json_count(uint64_t number);

/* All of it, indented; real numbers with `digits` digits, 0: with all they need. To be released with free().
 * NULL where memory ran out, also while it was put together: then something is left out in it. */
char *json_dump_text(const json_t *root, unsigned digits);

#endif
