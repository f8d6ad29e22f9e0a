/* Memory that runs out, for programs as they are: to be loaded with LD_PRELOAD. Counts the process's requests
 * for memory, those of all its libraries included, and lets one of them fail, or all from one on.
 *
 * Counted are malloc, calloc, realloc, reallocarray, aligned_alloc, memalign, posix_memalign, mmap, and
 * pthread_create, which needs a stack. The C library's own requests by mmap are not seen; those by malloc
 * are, as in strdup() and fopen().
 *
 * $FATHOM_OOM says which:
 *   count     none fails
 *   once:N    the N-th, from 1
 *   from:N    the N-th and all that come after it
 *   at:SITE   the first from this site (a hash of the calls that led there, as the report has it)
 *   after:SITE     that one and all that come after it
 *   threads   every pthread_create, and nothing else
 * $FATHOM_OOM_REPORT names a file to which lines are appended:
 *   site HASH N KIND LIBRARY+OFFSET…   a site met for the first time, where sites are counted
 *   failed N KIND                      the first request that was refused
 *   total N                            when the process ends by itself
 * Requests made while the program starts, before main(), are not counted: the loader ends the process then,
 * and nothing of ours has run. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <unwind.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void *reallocarray(void *old, size_t count, size_t size);
void *memalign(size_t alignment, size_t size);

enum mode { OFF, COUNT, ONCE, FROM, AT, AFTER, THREADS };
static enum mode mode;
static uint64_t wanted;
static int report = -1;
static atomic_uint_fast64_t requests;
static atomic_bool fired, announced;
static __thread bool busy __attribute__((tls_model("initial-exec")));

/* ---- sites ---- */

#define FRAMES 40
#define SITES (1u << 18)
static atomic_uint_fast64_t known[SITES];

typedef struct trail {
    uintptr_t frames[FRAMES];
    unsigned count, skip;
} trail;

static _Unwind_Reason_Code step(struct _Unwind_Context *context, void *user) {
    trail *t = user;
    if (t->skip) {
        --t->skip;
        return _URC_NO_REASON;
    }
    t->frames[t->count++] = (uintptr_t)_Unwind_GetIP(context);
    return t->count < FRAMES ? _URC_NO_REASON : _URC_END_OF_STACK;
}

static const char *place(uintptr_t address, uintptr_t *offset) {
    struct dl_find_object object;
    *offset = address;
    if (_dl_find_object((void *)address, &object) != 0) return "?";
    *offset = address - object.dlfo_link_map->l_addr;
    const char *name = object.dlfo_link_map->l_name, *slash = strrchr(name, '/');
    return slash ? slash + 1 : *name ? name : "program";
}

/* The same in every run, wherever the libraries lie. */
static uint64_t hash(const trail *t) {
    uint64_t h = UINT64_C(14695981039346656037);
    for (unsigned i = 0; i < t->count; ++i) {
        uintptr_t offset;
        for (const char *c = place(t->frames[i], &offset); *c; ++c)
            h = (h ^ (unsigned char)*c) * UINT64_C(1099511628211);
        for (int k = 0; k < 32; k += 8) h = (h ^ (offset >> k & 255)) * UINT64_C(1099511628211);
    }
    return h ? h : 1;
}

static bool met_first(uint64_t h) {
    for (uint64_t i = h;; ++i) {
        uint_fast64_t none = 0;
        if (atomic_compare_exchange_strong(&known[i % SITES], &none, h)) return true;
        if (none == h) return false;
    }
}

static void line(const char *text, size_t length) {
    ssize_t ignored = report < 0 ? 0 : write(report, text, length);
    (void)ignored;
}

static void tell_site(uint64_t h, uint64_t n, const char *kind, const trail *t) {
    char text[4096];
    int used = snprintf(text, sizeof text, "site %016llx %llu %s", (unsigned long long)h,
                        (unsigned long long)n, kind);
    for (unsigned i = 0; i < t->count && used < (int)sizeof text - 128; ++i) {
        uintptr_t offset;
        const char *name = place(t->frames[i], &offset);
        used += snprintf(text + used, sizeof text - (size_t)used, " %.80s+%lx", name, (unsigned long)offset);
    }
    text[used++] = '\n';
    line(text, (size_t)used);
}

static void tell_failed(uint64_t n, const char *kind) {
    char text[64];
    if (atomic_exchange(&announced, true)) return;
    int used = snprintf(text, sizeof text, "failed %llu %s\n", (unsigned long long)n, kind);
    line(text, (size_t)used);
}

/* ---- which requests fail ---- */

/* Both are kept out of line, so that the frames to leave out are always three: these and the request. */
static __attribute__((noinline)) bool decide(const char *kind, uintptr_t caller) {
    uint64_t n = atomic_fetch_add(&requests, 1) + 1;
    if (mode == THREADS) return kind[0] == 't';
    if (mode == ONCE) return n == wanted;
    if (mode == FROM) return n >= wanted;
    if (atomic_load(&fired)) return mode == AFTER;
    /* The upper half of a site is the caller's place alone: looking that up is cheap, following calls is not.
     */
    uint64_t near = hash(&(trail){{caller}, 1, 0}) >> 32;
    if (mode != COUNT && near != wanted >> 32) return false;
    trail t = {.skip = 3};
    _Unwind_Backtrace(step, &t);
    uint64_t h = near << 32 | (hash(&t) & UINT32_MAX);
    if (mode == COUNT) {
        if (met_first(h)) tell_site(h, n, kind, &t);
        return false;
    }
    return h == wanted && !atomic_exchange(&fired, true);
}

static __attribute__((noinline)) bool is_refused(const char *kind, const void *caller) {
    if (mode == OFF || busy) return false;
    busy = true;
    int error = errno;
    bool fails = decide(kind, (uintptr_t)caller);
    if (fails) tell_failed(atomic_load(&requests), kind);
    busy = false;
    errno = fails ? ENOMEM : error;
    return fails;
}

/* ---- the requests ---- */

#define refused(kind) is_refused(kind, __builtin_return_address(0))

void *malloc(size_t size) { return refused("malloc") ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return refused("calloc") ? NULL : __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return refused("realloc") ? NULL : __libc_realloc(old, size); }
void *memalign(size_t alignment, size_t size) {
    return refused("memalign") ? NULL : __libc_memalign(alignment, size);
}
void *aligned_alloc(size_t alignment, size_t size) {
    return refused("memalign") ? NULL : __libc_memalign(alignment, size);
}

void *reallocarray(void *old, size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes)) {
        errno = ENOMEM;
        return NULL;
    }
    return refused("realloc") ? NULL : __libc_realloc(old, bytes);
}

int posix_memalign(void **out, size_t alignment, size_t size) {
    void *data = refused("memalign") ? NULL : __libc_memalign(alignment, size);
    if (!data) return ENOMEM;
    *out = data;
    return 0;
}

static void *map(void *address, size_t size, int protection, int flags, int descriptor, off_t offset) {
    return (void *)syscall(SYS_mmap, address, size, protection, flags, descriptor, offset);
}

void *mmap(void *address, size_t size, int protection, int flags, int descriptor, off_t offset) {
    return refused("mmap") ? MAP_FAILED : map(address, size, protection, flags, descriptor, offset);
}
void *mmap64(void *address, size_t size, int protection, int flags, int descriptor, off_t offset) {
    return refused("mmap") ? MAP_FAILED : map(address, size, protection, flags, descriptor, offset);
}

typedef int create_fn(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *user);
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *user) {
    if (refused("thread")) return EAGAIN;
    return ((create_fn *)dlsym(RTLD_NEXT, "pthread_create"))(thread, attributes, run, user);
}

/* ---- begin and end ---- */

static void choose(const char *words) {
    static const struct {
        const char *word;
        enum mode mode;
        int base;
    } modes[] = {{"count", COUNT, 0}, {"once:", ONCE, 10},   {"from:", FROM, 10},
                 {"at:", AT, 16},     {"after:", AFTER, 16}, {"threads", THREADS, 0}};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; ++i) {
        size_t length = strlen(modes[i].word);
        if (strncmp(words, modes[i].word, length) != 0) continue;
        if (modes[i].base) wanted = strtoull(words + length, NULL, modes[i].base);
        mode = modes[i].mode;
    }
}

typedef int main_fn(int argc, char **argv, char **environment);
static main_fn *program;

static int counted_main(int argc, char **argv, char **environment) {
    const char *path = getenv("FATHOM_OOM_REPORT"), *words = getenv("FATHOM_OOM");
    /* The image helper is another program: what it lacks ends in a message of the one that started it. */
    if (strcmp(program_invocation_short_name, "fathom-image") == 0) words = path = NULL;
    if (path) report = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (words) choose(words);
    return program(argc, argv, environment);
}

int __libc_start_main(main_fn *entry, int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void *stack_end);
typedef int start_fn(main_fn *entry, int argc, char **argv, void (*init)(void), void (*fini)(void),
                     void (*rtld_fini)(void), void *stack_end);
int __libc_start_main(main_fn *entry, int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void *stack_end) {
    program = entry;
    return ((start_fn *)dlsym(RTLD_NEXT, "__libc_start_main"))(counted_main, argc, argv, init, fini,
                                                               rtld_fini, stack_end);
}

/* By exit(), or by _exit() alone. */
static __attribute__((destructor)) void tell_total(void) {
    static atomic_bool told;
    char text[64];
    if (mode == OFF || atomic_exchange(&told, true)) return;
    int used = snprintf(text, sizeof text, "total %llu\n", (unsigned long long)atomic_load(&requests));
    line(text, (size_t)used);
}

void _exit(int status) {
    tell_total();
    syscall(SYS_exit_group, status);
    __builtin_unreachable();
}
