/* Clocks that leap, for programs as they are: to be loaded with LD_PRELOAD. $FATHOM_CLOCK says which and by
 * how many seconds, "realtime:-86400" or "monotonic:3600"; $FATHOM_CLOCK_AFTER after how many readings of it
 * (20). */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long leap_of(clockid_t clock) {
    static atomic_long readings[2];
    const char *words = getenv("FATHOM_CLOCK"), *after = getenv("FATHOM_CLOCK_AFTER");
    const char *name = clock == CLOCK_REALTIME ? "realtime:" : clock == CLOCK_MONOTONIC ? "monotonic:" : NULL;
    if (!words || !name || strncmp(words, name, strlen(name)) != 0) return 0;
    long count = atomic_fetch_add(&readings[clock == CLOCK_MONOTONIC], 1);
    return count < (after ? atol(after) : 20) ? 0 : atol(words + strlen(name));
}

int clock_gettime(clockid_t clock, struct timespec *out) {
    int result = (int)syscall(SYS_clock_gettime, clock, out);
    if (result == 0) out->tv_sec += leap_of(clock);
    return result;
}

time_t time(time_t *out) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) *out = now.tv_sec;
    return now.tv_sec;
}

int gettimeofday(struct timeval *restrict out, void *restrict zone) {
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    *out = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    return 0;
}
