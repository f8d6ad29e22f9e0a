/* Parallel loops. */
#pragma once

#include <stddef.h>

/* Threads that a context uses at most. */
#define THREADS_MAX 1024u

unsigned processor_count(void);

/* Returns how many of `wanted` further threads the system grants, by creating them for a moment. For
 * schedulers that end the process if they get fewer threads than they were told to use. */
unsigned threads_granted(unsigned wanted);

/* Body of a parallel loop: handles items [begin, end). */
typedef void (*loop_body)(void *user, size_t begin, size_t end);

/* Runs body over [0, count) in pieces of `grain` items, on `threads` threads including the calling one.
 * Pieces are started in ascending order. The result of a piece must not depend on the worker. Uses fewer
 * threads if the system refuses more. */
void loop_parallel(unsigned threads, size_t count, size_t grain, loop_body body, void *user);

/* The same for a body with memory for each worker, which is in [0, threads). */
typedef void (*loop_worker_body)(void *user, size_t begin, size_t end, unsigned worker);
void loop_workers(unsigned threads, size_t count, size_t grain, loop_worker_body body, void *user);
