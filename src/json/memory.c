#include "json/memory.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static json_malloc_t give;
static json_free_t take_back;

static _Thread_local bool lacked;
static _Thread_local json_arena *reading; /* set while json_arena_read() runs on this thread; else NULL */
static _Thread_local jmp_buf refused;

/* ---- the arena ---- */

#define CHUNK_LEAST ((size_t)16 << 10)
#define CHUNK_MOST ((size_t)1 << 20)
#define ALIGNMENT ((size_t)16)

struct json_chunk {
    struct json_chunk *before;
    size_t used, room;
    _Alignas(ALIGNMENT) unsigned char bytes[];
};

/* Chunks grow by half up to CHUNK_MOST, so that they are few, and at most a third of them is unused. */
static struct json_chunk *add_chunk(json_arena *arena, size_t bytes) {
    size_t room = arena->last ? arena->last->room / 2 * 3 : CHUNK_LEAST;
    if (room > CHUNK_MOST) room = CHUNK_MOST;
    if (room < bytes) room = bytes;
    struct json_chunk *chunk = room < SIZE_MAX / 2 ? malloc(sizeof *chunk + room) : NULL;
    if (!chunk) return NULL;
    *chunk = (struct json_chunk){.before = arena->last, .room = room};
    return arena->last = chunk;
}

/* Leaves jansson's calls by longjmp() when out of memory. Nothing leaks, because the arena owns all their
 * memory. */
static void *take(size_t bytes) {
    bytes = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    struct json_chunk *chunk = reading->last;
    if (!chunk || chunk->room - chunk->used < bytes) chunk = add_chunk(reading, bytes);
    if (!chunk) {
        reading->lacked = true;
        longjmp(refused, 1);
    }
    void *data = chunk->bytes + chunk->used;
    chunk->used += bytes;
    return data;
}

void json_arena_release(json_arena *arena) {
    while (arena->last) {
        struct json_chunk *before = arena->last->before;
        free(arena->last);
        arena->last = before;
    }
}

/* ---- jansson's allocation functions ---- */

static void *watched_give(size_t bytes) {
    if (reading) return take(bytes);
    void *data = give(bytes);
    if (!data) lacked = true;
    return data;
}

static void watched_take_back(void *data) {
    if (!reading) take_back(data);
}

static void install(void) {
    json_get_alloc_funcs(&give, &take_back);
    json_set_alloc_funcs(watched_give, watched_take_back);
}

/* No variable of this function changes between setjmp() and longjmp(), so none becomes indeterminate. */
static json_t *read_or_leave(const char *text, size_t size, size_t flags, json_error_t *error) {
    return setjmp(refused) ? NULL : json_loadb(text, size, flags, error);
}

json_t *json_arena_read(json_arena *arena, const char *text, size_t size, size_t flags, json_error_t *error) {
    pthread_once(&once, install);
    reading = arena;
    json_t *root = read_or_leave(text, size, flags, error);
    reading = NULL;
    return root;
}

static json_t *make_value(const double *numbers, size_t count) {
    if (count == 0) return json_boolean(numbers[0] != 0);
    if (count == 1) return json_real(numbers[0]);
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) json_array_append_new(list, json_real(numbers[i]));
    return list;
}

static bool set_or_leave(json_t *object, const char *key, const double *numbers, size_t count) {
    return !setjmp(refused) && json_object_set_new(object, key, make_value(numbers, count)) == 0;
}

bool json_arena_set(json_arena *arena, json_t *object, const char *key, const double *numbers, size_t count) {
    reading = arena;
    const bool done = set_or_leave(object, key, numbers, count);
    reading = NULL;
    return done;
}

void json_memory_watch(void) {
    pthread_once(&once, install);
    lacked = false;
}

bool json_memory_lacked(void) { return lacked; }
