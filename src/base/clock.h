/* Clocks, in seconds. */
#pragma once

#include <time.h>

static inline double clock_read(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Monotonic time since an arbitrary start. */
static inline double clock_seconds(void) { return clock_read(CLOCK_MONOTONIC); }
/* Processor time of the calling thread, and of all threads of the process. */
static inline double clock_thread_seconds(void) { return clock_read(CLOCK_THREAD_CPUTIME_ID); }
static inline double clock_process_seconds(void) { return clock_read(CLOCK_PROCESS_CPUTIME_ID); }
