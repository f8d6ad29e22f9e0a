/* Threads that wait for work, shared by the whole process. Creating a thread waits for the dynamic loader's
 * lock, which loading a large module holds for a fifth of a second; existing threads do not wait. There are
 * as many as were ever busy at once, and they end with the process. */
#ifndef BASE_POOL_H
#define BASE_POOL_H

#include <stdbool.h>

/* A piece of work. The caller keeps it until pool_wait() has returned. */
typedef struct pool_task {
    void (*run)(void *user);
    void *user;
    bool done; /* under the pool's lock */
    struct pool_task *next;
} pool_task;

/* Starts task->run(task->user) on another thread at once. False: there is no thread, and nothing starts. */
bool pool_run(pool_task *task);
/* Waits until the task has ended, for at most `seconds` unless negative; returns whether it has. */
bool pool_wait(pool_task *task, double seconds);

#endif
