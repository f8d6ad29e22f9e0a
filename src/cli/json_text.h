/* Writing JSON, and looking up values in it. */
#pragma once

#include <fathom/base.h>
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

/* ---- values ---- */

/* If the text is not UTF-8, each byte beyond ASCII becomes '?'. NULL becomes null. */
json_t *json_text(const char *string);
json_t *json_count(uint64_t number);
/* null if the number is not finite. */
json_t *json_number(double number);
json_t *json_int(int number);
json_t *json_float(float number);
json_t *json_flag(bool flag);
json_t *json_vector(double x, double y, double z);
json_t *json_value(json_t *value);

typedef struct json_member {
    const char *key;
    json_t *value;
} json_member;

/* A member of an object: a number, text, a bool or a json_t, whose reference it takes over. Comparisons are
 * ints in C: write (bool)(a < b). */
#define JSON(name, x)                                                                                        \
    ((json_member){name, _Generic((x),                                                                       \
         bool: json_flag,                                                                                    \
         int: json_int,                                                                                    \
         unsigned: json_count,                                                                               \
         unsigned long: json_count,                                                                          \
         unsigned long long: json_count,                                                                     \
         float: json_float,                                                                                 \
         double: json_number,                                                                                \
         char *: json_text,                                                                                  \
         const char *: json_text,                                                                            \
         json_t *: json_value)(x)})

json_t *json_add_members(json_t *object, const json_member *members, size_t count);
/* sizeof does not evaluate its operand, so the values are created once. */
#define JSON_MEMBERS(...)                                                                                    \
    (const json_member[]){__VA_ARGS__}, sizeof((const json_member[]){__VA_ARGS__}) / sizeof(json_member)
/* json_add(object, JSON("a", 1), JSON("b", "text")) adds to an object and returns it; json_of() creates
 * one. */
#define json_add(object, ...) json_add_members(object, JSON_MEMBERS(__VA_ARGS__))
#define json_of(...) json_add(json_object(), __VA_ARGS__)

/* ---- looking up ---- */

/* "renderToBare.median" is the member median of the member renderToBare. NULL: not found. */
const json_t *json_at(const json_t *object, const char *path);
/* NAN if there is no number. */
double json_number_at(const json_t *object, const char *path);
/* "" if there is no text. */
const char *json_text_at(const json_t *object, const char *path);

/* ---- printing ---- */

/* Prints `form`, in which "{path:9.4g}" stands for a number of the object and "{path:-8s}" for a text; "-" if
 * it is missing. Formats that end in M divide by a million; those that end in % multiply by 100. "{path:+es}"
 * is the ending "es", unless the number is 1. */
void json_print(const json_t *object, const char *form);

/* ---- writing ---- */

/* The whole text, indented. Real numbers have `digits` digits; 0: as many as needed to be exact. Release with
 * free(). NULL: out of memory, now or when a value was created. */
char *json_dump_text(const json_t *root, unsigned digits);

/* Writes the text with 9 digits and a line end, as a whole file or none. */
fathom_status json_write_file(fathom_context *context, const char *path, const json_t *root);
