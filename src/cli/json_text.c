#include "cli/json_text.h"

#include <stdlib.h>
#include <string.h>

json_t *json_text(const char *string) {
    json_t *value = json_string(string);
    if (value) return value;
    char *plain = strdup(string);
    if (!plain) return NULL;
    for (char *c = plain; *c; ++c) {
        if ((unsigned char)*c >= 128) *c = '?';
    }
    value = json_string(plain);
    free(plain);
    return value;
}

json_t *json_count(uint64_t number) { return json_integer((json_int_t)number); }
