/* Makes jansson safe when memory runs out. If an allocation fails, jansson 2.14 drops bytes of strings and
 * numbers while parsing, and then returns wrong values or writes out of bounds; while writing, it leaves keys
 * out. Therefore this module replaces its allocation functions, for the whole process. Requests of
 * json_arena_read() on the same thread get memory from the arena; all others go to the previous functions. */
#pragma once

#include <jansson.h>
#include <stdbool.h>

/* ---- reading ---- */

/* The memory of all values of one JSON text, released at once. Set it to zero before use. */
typedef struct json_arena {
    struct json_chunk *last;
    bool lacked; /* memory ran out: there are no values */
} json_arena;

/* json_loadb() with memory from the arena. The values are complete, or the result is NULL; do not pass them
 * to json_decref(). `error` is not set if arena->lacked. */
json_t *json_arena_read(json_arena *arena, const char *text, size_t size, size_t flags, json_error_t *error);
/* Sets member `key` of an object of the arena: to one number, or to an array of several. count 0: to true or
 * false, as numbers[0] is 0 or not. The numbers must be finite. False: memory ran out. */
bool json_arena_set(json_arena *arena, json_t *object, const char *key, const double *numbers, size_t count);
void json_arena_release(json_arena *arena);

/* ---- writing ---- */

/* json_memory_lacked() tells whether an allocation on this thread, outside json_arena_read(), has failed
 * since json_memory_watch(). */
void json_memory_watch(void);
bool json_memory_lacked(void);
