#include "cli/json_text.h"

#include "cli/fail.h"
#include "cli/outputs.h"
#include "json/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

json_t *json_text(const char *string) {
    if (!string) return json_null();
    json_t *value = json_string(string);
    if (value) return value;
    char *plain = strdup(string);
    if (!plain) return NULL;
    for (char *c = plain; *c; ++c)
        if ((unsigned char)*c >= 128) *c = '?';
    value = json_string(plain);
    free(plain);
    return value;
}

json_t *json_count(uint64_t number) { return json_integer((json_int_t)number); }
json_t *json_number(double number) { return isfinite(number) ? json_real(number) : json_null(); }
json_t *json_int(int number) { return json_integer(number); }
json_t *json_float(float number) { return json_number((double)number); }
json_t *json_flag(bool flag) { return json_boolean(flag); }
json_t *json_vector(double x, double y, double z) { return json_pack("[f, f, f]", x, y, z); }
json_t *json_value(json_t *value) { return value; }

json_t *json_add_members(json_t *object, const json_member *members, size_t count) {
    for (size_t i = 0; i < count; ++i) json_object_set_new(object, members[i].key, members[i].value);
    return object;
}

const json_t *json_at(const json_t *object, const char *path) {
    for (;;) {
        char key[64];
        const size_t length = strcspn(path, ".");
        if (length >= sizeof key) return NULL;
        memcpy(key, path, length);
        key[length] = '\0';
        object = json_object_get(object, key);
        if (!object || !path[length]) return object;
        path += length + 1;
    }
}

double json_number_at(const json_t *object, const char *path) {
    const json_t *value = json_at(object, path);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

const char *json_text_at(const json_t *object, const char *path) {
    const char *text = json_string_value(json_at(object, path));
    return text ? text : "";
}

/* format: "-8s", "9.4g", ".1f%", "+es". */
static void print_value(const json_t *value, const char *format) {
    char *kind;
    if (*format == '+') {
        if (json_number_value(value) != 1) fputs(format + 1, stdout);
        return;
    }
    const int width = (int)strtol(format, &kind, 10);
    const int digits = *kind == '.' ? (int)strtol(kind + 1, &kind, 10) : 0;
    double x = json_number_value(value);
    x *= kind[1] == 'M' ? 1e-6 : kind[1] == '%' ? 100 : 1;
    if (json_is_string(value))
        printf("%*s", width, json_string_value(value));
    else if (!json_is_number(value))
        printf("%*s", width, "-");
    else if (*kind == 'g')
        printf("%*.*g", width, digits, x);
    else
        printf("%*.*f", width, digits, x);
}

void json_print(const json_t *object, const char *form) {
    char path[64], format[16];
    while (*form) {
        int used = 0;
        if (*form == '{' && sscanf(form, "{%63[^:]:%15[^}]}%n", path, format, &used) == 2 && used) {
            print_value(json_at(object, path), format);
            form += used;
        } else {
            putchar(*form++);
        }
    }
}

char *json_dump_text(const json_t *root, unsigned digits) {
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(digits)) : NULL;
    if (!json_memory_lacked()) return text;
    free(text);
    return NULL;
}

fathom_status json_write_file(fathom_context *context, const char *path, const json_t *root) {
    char *text = json_dump_text(root, 9);
    if (!text) return cli_fail_memory(context);
    const size_t length = strlen(text);
    text[length] = '\n'; /* replaces the terminator */
    fathom_status status = outputs_write(context, path, text, length + 1);
    free(text);
    return status;
}
