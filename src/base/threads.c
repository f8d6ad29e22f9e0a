#include "base/threads.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

#define MAX_THREADS 1024

unsigned processor_count(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0) return (unsigned)CPU_COUNT(&set);
    return 1;
}

typedef struct loop {
    atomic_size_t next;
    size_t count, grain;
    loop_body body;
    void *user;
} loop;

typedef struct worker {
    loop *loop;
    unsigned index;
} worker;

static void *work(void *argument) {
    worker *self = argument;
    loop *l = self->loop;
    for (;;) {
        size_t begin = atomic_fetch_add(&l->next, l->grain);
        if (begin >= l->count) return NULL;
        size_t end = l->count - begin > l->grain ? begin + l->grain : l->count;
        l->body(l->user, begin, end, self->index);
    }
}

void loop_parallel(unsigned threads, size_t count, size_t grain, loop_body body, void *user) {
    if (!count) return;
    loop l = {0, count, grain ? grain : 1, body, user};
    size_t pieces = (count + l.grain - 1) / l.grain;
    if (threads > MAX_THREADS) threads = MAX_THREADS;
    if (threads > pieces) threads = (unsigned)pieces;
    pthread_t handles[MAX_THREADS];
    worker workers[MAX_THREADS];
    unsigned started = 0;
    for (unsigned i = 1; i < threads; ++i) {
        workers[i] = (worker){&l, i};
        if (pthread_create(&handles[started], NULL, work, &workers[i]) != 0) break;
        ++started;
    }
    workers[0] = (worker){&l, 0};
    work(&workers[0]);
    for (unsigned i = 0; i < started; ++i) pthread_join(handles[i], NULL);
}
