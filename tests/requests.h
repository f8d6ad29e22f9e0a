/* Memory that runs out at every one of the library's own requests in turn: each call then fails with its
 * status, a message and no result, and gives back all it took; or does without, and its result is the same.
 * The program is linked with --wrap, so that the requests pass through here: see tests/CMakeLists.txt. */
#pragma once

#include "unit.h"

#include <fathom/fathom.h>

#include <errno.h>
#include <jansson.h>
#include <limits.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

/* ---- requests ---- */

#define BLOCKS (1u << 18)
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct {
    const void *block;
    unsigned long request;
} blocks[BLOCKS]; /* what was given and not come back; open addressing, under the lock */
static unsigned long requests, failing, block_count;

static size_t slot_of(const void *block) { return (uintptr_t)block / 16 * 2654435761u % BLOCKS; }

static bool refuse(void) {
    pthread_mutex_lock(&lock);
    bool refused = ++requests == failing;
    pthread_mutex_unlock(&lock);
    if (refused) errno = ENOMEM;
    return refused;
}

static void *given(void *block) {
    if (!block) return NULL;
    pthread_mutex_lock(&lock);
    size_t i = slot_of(block);
    while (blocks[i].block) i = (i + 1) % BLOCKS;
    blocks[i].block = block, blocks[i].request = requests;
    ++block_count;
    pthread_mutex_unlock(&lock);
    return block;
}

/* What follows in the same run of slots moves up, where it still is found. */
static void close_gap(size_t gap) {
    for (size_t i = (gap + 1) % BLOCKS; blocks[i].block; i = (i + 1) % BLOCKS) {
        size_t home = slot_of(blocks[i].block);
        bool stays = gap <= i ? gap < home && home <= i : gap < home || home <= i;
        if (stays) continue;
        blocks[gap] = blocks[i];
        gap = i;
    }
    blocks[gap].block = NULL;
}

static void came_back(const void *block) {
    if (!block) return;
    pthread_mutex_lock(&lock);
    size_t i = slot_of(block);
    while (blocks[i].block && blocks[i].block != block) i = (i + 1) % BLOCKS;
    if (blocks[i].block) {
        close_gap(i);
        --block_count;
    }
    pthread_mutex_unlock(&lock);
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_strdup(const char *text);
void __real_free(void *block);
FILE *__real_fopen(const char *path, const char *mode);
FILE *__real_fdopen(int descriptor, const char *mode);
void *__real_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);

void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_strdup(const char *text);
void __wrap_free(void *block);
FILE *__wrap_fopen(const char *path, const char *mode);
FILE *__wrap_fdopen(int descriptor, const char *mode);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);

void *__wrap_malloc(size_t size) { return refuse() ? NULL : given(__real_malloc(size)); }
void *__wrap_calloc(size_t count, size_t size) { return refuse() ? NULL : given(__real_calloc(count, size)); }
void *__wrap_realloc(void *old, size_t size) {
    if (refuse()) return NULL;
    came_back(old);
    return given(__real_realloc(old, size));
}
void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    return refuse() ? NULL : given(__real_aligned_alloc(alignment, size));
}
char *__wrap_strdup(const char *text) { return refuse() ? NULL : given(__real_strdup(text)); }
void __wrap_free(void *block) {
    came_back(block);
    __real_free(block);
}
FILE *__wrap_fopen(const char *path, const char *mode) { return refuse() ? NULL : __real_fopen(path, mode); }
FILE *__wrap_fdopen(int descriptor, const char *mode) {
    return refuse() ? NULL : __real_fdopen(descriptor, mode);
}
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset) {
    return refuse() ? MAP_FAILED : __real_mmap(at, size, protection, flags, descriptor, offset);
}
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user) {
    return refuse() ? EAGAIN : __real_pthread_create(thread, attributes, run, user);
}

static void *json_take(size_t size) { return __wrap_malloc(size); }
static void json_return(void *block) { __wrap_free(block); }

/* ---- work ---- */

static char folder[64];

static const char *in_folder(const char *name) {
    static char paths[4][128];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static void put(const char *name, const char *text) { unit_write_file(in_folder(name), text, strlen(text)); }

/* What a piece of work gives, to be compared: bytes added up. */
typedef struct outcome {
    uint64_t sum;
    size_t bytes;
} outcome;

static void add(outcome *o, const void *data, size_t bytes) {
    const unsigned char *from = data;
    for (size_t i = 0; i < bytes; ++i) o->sum = (o->sum ^ from[i]) * UINT64_C(1099511628211);
    o->bytes += bytes;
}

typedef fathom_status work_fn(fathom_context *context, const char *file, outcome *out);

/* ---- every request in turn ---- */

static char said[256]; /* by the last attempt */
/* The first so many requests are refused each, then one of a step: for work that repeats itself. Sanitizers
 * take several times as long. They look at fewer places; the other builds refuse all that a test asks for. */
#ifdef FATHOM_SANITIZED
#define REFUSED_EACH 64
#define REFUSED_STEP 211
#else
#define REFUSED_EACH ULONG_MAX
#define REFUSED_STEP 31
#endif
static unsigned long refused_each = REFUSED_EACH;

static fathom_status attempt(work_fn *work, const char *file, outcome *out, bool *told) {
    fathom_context *context;
    *out = (outcome){0, 0};
    *told = true;
    if (fathom_context_create(&context) != FATHOM_OK) return FATHOM_OUT_OF_RESOURCES;
    fathom_context_set_threads(context, 1);
    fathom_status status = work(context, file, out);
    snprintf(said, sizeof said, "%s", fathom_context_message(context));
    *told = status == FATHOM_OK || fathom_context_message(context)[0];
    if (status != FATHOM_OK && status != FATHOM_OUT_OF_RESOURCES)
        add(out, fathom_context_message(context), strlen(fathom_context_message(context)));
    fathom_context_destroy(context);
    return status;
}

static unsigned long leaked_request(unsigned long since) {
    for (size_t i = 0; i < BLOCKS; ++i) {
        if (blocks[i].block && blocks[i].request > since) return blocks[i].request - since;
    }
    return 0;
}

/* The first runs bring what stays: threads, tables. wanted: what the work comes to with all the memory it
 * asks for; a failure, with the same message, where its input is bad. */
static void exhaust_to(work_fn *work, const char *file, fathom_status wanted) {
    outcome good, now;
    bool told;
    failing = 0;
    for (int i = 0; i < 2; ++i) {
        fathom_status status = attempt(work, file, &good, &told);
        if (status != wanted) fail_msg("%s: status %d without a fault: %s", file, status, said);
    }
    unsigned long begin = requests, refused = 0, harmless = 0;
    assert_int_equal(attempt(work, file, &good, &told), wanted);
    unsigned long count = requests - begin;
    assert_true(good.bytes > 0 && count > 0);
    for (unsigned long n = 1; n <= count; n += n < refused_each ? 1 : REFUSED_STEP) {
        unsigned long held = block_count, before = requests;
        failing = before + n;
        fathom_status status = attempt(work, file, &now, &told);
        failing = 0;
        if (status != wanted && status != FATHOM_OUT_OF_RESOURCES)
            fail_msg("%s, request %lu: status %d", file, n, status);
        if (!told) fail_msg("%s, request %lu: no message", file, n);
        if (status == wanted && (now.sum != good.sum || now.bytes != good.bytes))
            fail_msg("%s, request %lu: another result", file, n);
        if (block_count > held)
            fail_msg("%s, request %lu: %lu blocks leaked, one of them request %lu", file, n,
                     block_count - held, leaked_request(before));
        refused += status != wanted;
        harmless += status == wanted;
    }
    assert_true(refused > 0);
    print_message("%s: %lu requests, %lu refused, %lu done without\n", file, count, refused, harmless);
}

static inline void exhaust(work_fn *work, const char *file) { exhaust_to(work, file, FATHOM_OK); }

/* A folder of the test's own, for its set-up and tear-down. */
static inline void requests_begin(void) {
    json_set_alloc_funcs(json_take, json_return);
    snprintf(folder, sizeof folder, "/tmp/fathom-oom-XXXXXX");
    assert_non_null(mkdtemp(folder));
}
