/* Makes jansson safe when memory runs out. Without memory, jansson 2.14 drops bytes of strings and numbers
 * while it parses, then gives wrong values or writes where it must not; while it writes, it leaves keys out.
 * So its requests pass through here, for the whole process. Only those of a parse on the same thread are
 * served here; the others go on to the previous functions. */
#ifndef JSON_MEMORY_H
#define JSON_MEMORY_H

#include <jansson.h>
#include <stdbool.h>

/* ---- reading ---- */

/* The memory of all values of a text, released at once. Zero it to start with. */
typedef struct json_arena {
    struct json_chunk *last;
    bool lacked; /* memory ran out: there are no values */
} json_arena;

/* json_loadb() with memory from the arena: the values are complete or NULL, and must not be given to
 * json_decref(). `error` is not set if arena->lacked. */
json_t *json_arena_read(json_arena *arena, const char *text, size_t size, size_t flags, json_error_t *error);
void json_arena_release(json_arena *arena);

/* ---- writing ---- */

/* json_memory_lacked(): whether a request of this thread outside of json_arena_read() was refused since
 * json_memory_watch(). */
void json_memory_watch(void);
bool json_memory_lacked(void);

#endif
