/* A thread pool, shared by the whole process. Creating a thread takes the dynamic loader's lock, which
 * loading a large module holds for 0.2 s; existing threads do not need it. The pool has as many threads as
 * were ever busy at once. They end with the process. */
#pragma once

#include <stdbool.h>

/* A task. The caller owns it and keeps it until pool_wait() has returned true. */
typedef struct pool_task {
    void (*run)(void *user);
    void *user;
    bool done; /* guarded by the pool's lock */
    struct pool_task *next;
} pool_task;

/* Starts task->run(task->user) on another thread at once. False: no thread could be created, and nothing was
 * started. */
bool pool_run(pool_task *task);
/* Waits until the task has ended, for at most `seconds`; without limit if that is negative, NaN, or 1e9 and
 * more. Returns whether the task has ended. */
bool pool_wait(pool_task *task, double seconds);
