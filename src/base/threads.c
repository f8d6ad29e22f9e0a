#include "base/threads.h"

#include "base/pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

unsigned processor_count(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0) return (unsigned)CPU_COUNT(&set);
    return 1;
}

static void *wait_for(void *user) {
    pthread_mutex_t *gate = user;
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

unsigned threads_granted(unsigned wanted) {
    static atomic_uint most;
    if (wanted > THREADS_MAX) wanted = THREADS_MAX;
    if (wanted <= atomic_load(&most)) return wanted;
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER; /* held until all threads exist */
    pthread_t threads[THREADS_MAX];                   /* 8 KiB */
    unsigned count = 0;
    pthread_mutex_lock(&gate);
    while (count < wanted && pthread_create(&threads[count], NULL, wait_for, &gate) == 0) ++count;
    pthread_mutex_unlock(&gate);
    for (unsigned i = 0; i < count; ++i) pthread_join(threads[i], NULL);
    if (count == wanted) atomic_store(&most, count);
    return count;
}

typedef struct loop {
    atomic_size_t next;
    size_t count, grain;
    loop_worker_body body;
    void *user;
} loop;

typedef struct worker {
    loop *loop;
    unsigned index;
    pool_task task;
} worker;

static void work(void *user) {
    worker *self = user;
    loop *l = self->loop;
    for (;;) {
        size_t begin = atomic_fetch_add(&l->next, l->grain);
        if (begin >= l->count) return;
        size_t end = l->count - begin > l->grain ? begin + l->grain : l->count;
        l->body(l->user, begin, end, self->index);
    }
}

/* This many workers fit on a small stack. */
#define FEW_THREADS 64

static void run_workers(worker *workers, unsigned count, loop *l) {
    unsigned started = 1;
    for (; started < count; ++started) {
        worker *w = &workers[started];
        *w = (worker){l, started, {.run = work, .user = w}};
        if (!pool_run(&w->task)) break;
    }
    workers[0] = (worker){.loop = l, .index = 0};
    work(&workers[0]);
    for (unsigned i = 1; i < started; ++i) pool_wait(&workers[i].task, -1);
}

void loop_workers(unsigned threads, size_t count, size_t grain, loop_worker_body body, void *user) {
    if (!count) return;
    loop l = {0, count, grain ? grain : 1, body, user};
    size_t pieces = (count + l.grain - 1) / l.grain;
    if (threads > pieces) threads = (unsigned)pieces;
    worker few[FEW_THREADS], *many = threads > FEW_THREADS ? malloc(threads * sizeof *many) : NULL;
    if (threads > FEW_THREADS && !many) threads = FEW_THREADS;
    run_workers(many ? many : few, threads, &l);
    free(many);
}

typedef struct plain_loop {
    loop_body body;
    void *user;
} plain_loop;

static void run_plain(void *user, size_t begin, size_t end, unsigned index) {
    (void)index;
    const plain_loop *plain = user;
    plain->body(plain->user, begin, end);
}

void loop_parallel(unsigned threads, size_t count, size_t grain, loop_body body, void *user) {
    loop_workers(threads, count, grain, run_plain, &(plain_loop){body, user});
}
