#include "render/watch.h"

#include <pthread.h>
#include <stdbool.h>
#include <time.h>

typedef struct watched {
    const watch_calls *calls;
    void *user;
    pthread_mutex_t lock;
    pthread_cond_t ended;
    bool has_ended; /* under lock */
} watched;

static void *work(void *argument) {
    watched *w = argument;
    w->calls->work(w->user);
    pthread_mutex_lock(&w->lock);
    w->has_ended = true;
    pthread_cond_signal(&w->ended);
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

/* Waits a tenth of a second, or until the work ends; says whether it has. */
static bool wait_a_tick(watched *w) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += 100000000;
    if (until.tv_nsec >= 1000000000) ++until.tv_sec, until.tv_nsec -= 1000000000;
    pthread_mutex_lock(&w->lock);
    while (!w->has_ended && pthread_cond_timedwait(&w->ended, &w->lock, &until) == 0) {
    }
    bool ended = w->has_ended;
    pthread_mutex_unlock(&w->lock);
    return ended;
}

static void init_lock(watched *w) {
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->ended, &attributes);
    pthread_condattr_destroy(&attributes);
}

void watch_run(const watch_calls *calls, void *user) {
    watched w = {.calls = calls, .user = user};
    init_lock(&w);
    pthread_t thread;
    if (pthread_create(&thread, NULL, work, &w) == 0) {
        while (!wait_a_tick(&w)) calls->tick(user);
        pthread_join(thread, NULL);
    } else {
        work(&w);
    }
    calls->tick(user);
    pthread_cond_destroy(&w.ended);
    pthread_mutex_destroy(&w.lock);
}
