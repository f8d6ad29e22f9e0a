/* Loops over threads. */
#ifndef BASE_THREADS_H
#define BASE_THREADS_H

#include <stddef.h>

unsigned processor_count(void);

/* Body of a parallel loop: handles items [begin, end). `worker` is in [0, threads). */
typedef void (*loop_body)(void *user, size_t begin, size_t end, unsigned worker);

/* Runs body over [0, count) in pieces of `grain` items, handed out in order, on `threads` threads of which
 * the caller is one. What a piece does must not depend on which worker does it. Falls back to fewer threads
 * where the system refuses more. */
void loop_parallel(unsigned threads, size_t count, size_t grain, loop_body body, void *user);

#endif
