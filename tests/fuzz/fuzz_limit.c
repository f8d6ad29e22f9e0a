#include "fuzz.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#ifndef __has_feature
#define __has_feature(x) 0
#endif

static struct {
    bool on;
    size_t size, factor;
    long long live, peak; /* bytes */
    double begun;
    /* Over all executions, for the report at the end. */
    size_t worst_size;
    long long worst_peak;
    double worst_factor, worst_seconds;
} watch;

static double seconds_used(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void fuzz_wrong(const char *format, ...) {
    watch.on = false;
    va_list args;
    va_start(args, format);
    fputs("fuzz: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    abort();
}

#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)
/* Of clang's <sanitizer/allocator_interface.h>: gcc has the functions, but not the header. */
size_t __sanitizer_get_allocated_size(const volatile void *pointer);
int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void *, size_t),
                                              void (*on_free)(const volatile void *));

static void on_malloc(const volatile void *pointer, size_t bytes) {
    if (!watch.on || !pointer) return;
    watch.live += (long long)bytes;
    if (watch.live > watch.peak) watch.peak = watch.live;
    if (watch.peak > (long long)(FUZZ_MEMORY_FREE + watch.factor * watch.size))
        fuzz_wrong(
            "%lld bytes of memory in use, with an allocation of %zu, for an input of %zu bytes: beyond "
            "%zu + %zu times that",
            watch.peak, bytes, watch.size, FUZZ_MEMORY_FREE, watch.factor);
}

static void on_free(const volatile void *pointer) {
    if (watch.on && pointer)
        watch.live -= (long long)__sanitizer_get_allocated_size((const void *)(uintptr_t)pointer);
}

static const double seconds_most = FUZZ_SECONDS_SANITIZED;
static void watch_memory(void) { __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free); }
#else
static const double seconds_most = FUZZ_SECONDS;
static void watch_memory(void) {}
#endif

/* How far from the limits all that ran was; tests/fuzz.sh puts it into its table. */
static void report(void) {
    fprintf(stderr, "fuzz: most memory %lld bytes for %zu (limit %zu + %zu times), most time %.3f s\n",
            watch.worst_peak, watch.worst_size, FUZZ_MEMORY_FREE, watch.factor, watch.worst_seconds);
}

void fuzz_begin(size_t size, size_t factor) {
    static bool begun;
    if (!begun) {
        watch_memory();
        atexit(report);
    }
    begun = true;
    watch.size = size;
    watch.factor = factor;
    watch.live = watch.peak = 0;
    watch.begun = seconds_used();
    watch.on = true;
}

void fuzz_add_size(size_t bytes) { watch.size += bytes; }

void fuzz_end(void) {
    watch.on = false;
    double seconds = seconds_used() - watch.begun;
    if (seconds > watch.worst_seconds) watch.worst_seconds = seconds;
    /* Small inputs live off what is free. */
    double of_limit = (double)watch.peak / (double)(FUZZ_MEMORY_FREE + watch.factor * watch.size);
    if (of_limit > watch.worst_factor) {
        watch.worst_factor = of_limit;
        watch.worst_peak = watch.peak;
        watch.worst_size = watch.size;
    }
    if (seconds > seconds_most) fuzz_wrong("%.1f s for an input of %zu bytes", seconds, watch.size);
}
