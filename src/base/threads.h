/* Loops over threads. */
#ifndef BASE_THREADS_H
#define BASE_THREADS_H

#include <signal.h>
#include <stddef.h>

unsigned processor_count(void);

/* How many of `wanted` threads beside the caller's the system grants, found out by making them: for
 * schedulers that end the process where it grants fewer than they were told to use. Once it has granted so
 * many, it is taken to go on doing so. */
unsigned threads_granted(unsigned wanted);

/* Body of a parallel loop: handles items [begin, end). `worker` is in [0, threads). */
typedef void (*loop_body)(void *user, size_t begin, size_t end, unsigned worker);

/* Runs body over [0, count) in pieces of `grain` items, handed out in order, on `threads` threads of which
 * the caller is one. What a piece does must not depend on which worker does it. Falls back to fewer threads
 * where the system refuses more. */
void loop_parallel(unsigned threads, size_t count, size_t grain, loop_body body, void *user);

/* Signals are for the threads that know of them: those that the caller makes from now on get none, until it
 * gives `old` to pthread_sigmask(). Faults are left: one that is blocked ends the process past its handler.
 */
void threads_without_signals(sigset_t *old);

#endif
