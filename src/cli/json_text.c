#include "cli/json_text.h"

#include "base/status.h"
#include "cli/render/outputs.h"
#include "json/memory.h"

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

char *json_dump_text(const json_t *root, unsigned digits) {
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(digits)) : NULL;
    if (!json_memory_lacked()) return text;
    free(text);
    return NULL;
}

fathom_status json_write_file(fathom_context *context, const char *path, const json_t *root) {
    char *text = json_dump_text(root, 9);
    if (!text) return fail_memory(context, 4096);
    const size_t length = strlen(text);
    text[length] = '\n'; /* in place of the end */
    fathom_status status = outputs_write(context, path, text, length + 1);
    free(text);
    return status;
}
