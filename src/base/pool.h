/* Threads that wait for work, shared by all of the process.
 *
 * Making a thread waits for the dynamic loader's lock, which loading a large module holds for a fifth of a
 * second: threads that exist already do not wait. There are as many as were ever busy at once; they sleep in
 * between and end with the process. */
#ifndef BASE_POOL_H
#define BASE_POOL_H

#include <stdbool.h>

/* One piece of work; the caller's, and in its hands until pool_wait() has returned. */
typedef struct pool_task {
    void (*run)(void *user);
    void *user;
    bool done; /* under the pool's lock */
    struct pool_task *next;
} pool_task;

/* Starts task->run(task->user) on another thread at once; false when no thread can be had: then nothing has
 * begun. */
bool pool_run(pool_task *task);
/* Returns when the task has ended, true; or after `seconds`, false (negative: however long it takes). */
bool pool_wait(pool_task *task, double seconds);

#endif
