#include "base/pool.h"

#include <errno.h>
#include <pthread.h>
#include <time.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t has_work, has_ended;
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* All are guarded by the lock. */
static pool_task *first, **last = &first; /* tasks that no thread has taken */
static unsigned waiting;                  /* tasks in that list */
static unsigned idle;                     /* threads without a task */

static void take_lock(void) { pthread_mutex_lock(&lock); }
static void give_lock(void) { pthread_mutex_unlock(&lock); }

static void make_conditions(void) {
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&has_work, NULL);
    pthread_cond_init(&has_ended, &attributes);
    pthread_condattr_destroy(&attributes);
}

/* A forked child has none of its parent's threads, so it starts with an empty pool and new conditions. */
static void forget_threads(void) {
    first = NULL, last = &first;
    waiting = idle = 0;
    make_conditions();
    pthread_mutex_unlock(&lock);
}

static void prepare(void) {
    make_conditions();
    pthread_atfork(take_lock, give_lock, forget_threads);
}

static void *serve(void *unused) {
    (void)unused;
    pthread_mutex_lock(&lock);
    for (;;) {
        while (!first) pthread_cond_wait(&has_work, &lock);
        pool_task *task = first;
        first = task->next;
        if (!first) last = &first;
        --waiting, --idle;
        pthread_mutex_unlock(&lock);
        task->run(task->user);
        pthread_mutex_lock(&lock);
        task->done = true;
        ++idle;
        pthread_cond_broadcast(&has_ended);
    }
    return NULL;
}

/* Call with the lock held. Ensures an idle thread for every waiting task, and one more for a new task. */
static bool enough_threads(void) {
    while (idle < waiting + 1) {
        pthread_t thread;
        if (pthread_create(&thread, NULL, serve, NULL) != 0) return false;
        pthread_detach(thread);
        ++idle;
    }
    return true;
}

bool pool_run(pool_task *task) {
    pthread_once(&once, prepare);
    task->done = false;
    task->next = NULL;
    pthread_mutex_lock(&lock);
    bool served = enough_threads();
    if (served) {
        *last = task;
        last = &task->next;
        ++waiting;
        pthread_cond_signal(&has_work);
    }
    pthread_mutex_unlock(&lock);
    return served;
}

/* 31 years, in seconds: longer times would overflow, and are no limit. */
#define SECONDS_MOST 1e9

bool pool_wait(pool_task *task, double seconds) {
    const bool limited = seconds >= 0 && seconds < SECONDS_MOST;
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    long nanoseconds = until.tv_nsec + (limited ? (long)(seconds * 1e9) : 0);
    until.tv_sec += nanoseconds / 1000000000;
    until.tv_nsec = nanoseconds % 1000000000;
    pthread_mutex_lock(&lock);
    int result = 0;
    while (!task->done && result != ETIMEDOUT) {
        result = limited ? pthread_cond_timedwait(&has_ended, &lock, &until)
                         : pthread_cond_wait(&has_ended, &lock);
    }
    bool done = task->done;
    pthread_mutex_unlock(&lock);
    return done;
}
