/* What jansson does where memory runs out, made safe. Reading, jansson 2.14 drops bytes of strings and of
 * numbers then, and goes on with what is no JSON any more: it gives wrong values, or writes where it must
 * not. Writing, it leaves keys out. Its requests therefore pass through here, once and for the whole process:
 * to whom they went before, but for those of a reading that is under way on the same thread. */
#ifndef JSON_MEMORY_H
#define JSON_MEMORY_H

#include <jansson.h>
#include <stdbool.h>

/* ---- reading ---- */

/* All that a text's values take, released at once. Begins as zeroes. */
typedef struct json_arena {
    struct json_chunk *last;
    bool lacked; /* memory ran out: there are no values */
} json_arena;

/* json_loadb(), but for memory: the values are the arena's, whole or NULL, and must not be given to
 * json_decref(). `error` says nothing where arena->lacked. */
json_t *json_arena_read(json_arena *arena, const char *text, size_t size, size_t flags, json_error_t *error);
void json_arena_release(json_arena *arena);

/* ---- writing ---- */

/* From here on… */
void json_memory_watch(void);
/* …whether a request that this thread made outside of json_arena_read() was refused. */
bool json_memory_lacked(void);

#endif
