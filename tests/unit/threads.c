/* Loops over threads and the pool under them: every item once, however loops nest, meet or are forked. */
#include "base/threads.h"
#include "base/pool.h"
#include "unit.h"

#include <errno.h>
#include <fathom/base.h>
#include <limits.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

#define ITEMS 1000

/* ---- threads that the system refuses: the program is linked with --wrap ---- */

static atomic_int threads_left = INT_MAX;

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user) {
    if (atomic_fetch_sub(&threads_left, 1) <= 0) return EAGAIN;
    return __real_pthread_create(thread, attributes, run, user);
}

static bool affinity_fails;

int __real_sched_getaffinity(pid_t process, size_t size, cpu_set_t *set);
int __wrap_sched_getaffinity(pid_t process, size_t size, cpu_set_t *set);

int __wrap_sched_getaffinity(pid_t process, size_t size, cpu_set_t *set) {
    if (affinity_fails) return -1;
    return __real_sched_getaffinity(process, size, set);
}

/* ---- loops ---- */

typedef struct tally {
    _Atomic unsigned char seen[ITEMS];
    atomic_uint inner;
    bool nested;
} tally;

static void count_inner(void *user, size_t begin, size_t end) {
    atomic_fetch_add(&((tally *)user)->inner, (unsigned)(end - begin));
}

static void count_items(void *user, size_t begin, size_t end, unsigned worker) {
    tally *t = user;
    assert_true(worker < 4);
    for (size_t i = begin; i < end; ++i) atomic_fetch_add(&t->seen[i], 1);
    if (t->nested) loop_parallel(3, 10, 1, count_inner, t);
}

static void check_loop(bool nested) {
    tally *t = calloc(1, sizeof *t);
    assert_non_null(t);
    t->nested = nested;
    loop_workers(4, ITEMS, 7, count_items, t);
    for (size_t i = 0; i < ITEMS; ++i) assert_int_equal(t->seen[i], 1);
    assert_int_equal(t->inner, nested ? 10 * ((ITEMS + 6) / 7) : 0);
    free(t);
}

/* The first of all: no thread waits in the pool yet. */
UNIT_TEST(refused_threads_only_cost_time) {
    for (int granted = 0; granted < 3; ++granted) {
        atomic_store(&threads_left, granted);
        assert_int_equal(threads_granted(5), granted);
        atomic_store(&threads_left, granted);
        check_loop(false);
        check_loop(true);
    }
    atomic_store(&threads_left, 3);
    assert_int_equal(threads_granted(UINT_MAX), 3); /* more than are ever started */
    atomic_store(&threads_left, INT_MAX);
    assert_int_equal(threads_granted(5), 5);
    atomic_store(&threads_left, 0); /* once granted, always granted */
    assert_int_equal(threads_granted(4), 4);
    atomic_store(&threads_left, INT_MAX);
}

/* Those that this process may use; one, where the system does not say. */
UNIT_TEST(the_affinity_counts_processors) {
    cpu_set_t all, one;
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    assert_int_equal(processor_count(), CPU_COUNT(&all));
    size_t first = 0;
    while (!CPU_ISSET(first, &all)) ++first;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    assert_int_equal(processor_count(), 1);
    assert_int_equal(sched_setaffinity(0, sizeof all, &all), 0);
    affinity_fails = true;
    assert_int_equal(processor_count(), 1);
    affinity_fails = false;
}

static void count_any(void *user, size_t begin, size_t end, unsigned worker) {
    tally *t = user;
    assert_true(begin < end && worker < 1024);
    for (size_t i = begin; i < end; ++i) atomic_fetch_add(&t->seen[i], 1);
}

/* Nothing to do, pieces of nothing, more threads than there are. */
UNIT_TEST(loops_of_odd_sizes_run) {
    const struct {
        unsigned threads;
        size_t count, grain;
    } cases[] = {{3, 0, 1},    {3, 5, 0}, {0, 5, 1}, {5000, ITEMS, 200}, {2, ITEMS, SIZE_MAX / 4},
                 {1, ITEMS, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        tally *t = calloc(1, sizeof *t);
        assert_non_null(t);
        loop_workers(cases[k].threads, cases[k].count, cases[k].grain, count_any, t);
        for (size_t i = 0; i < ITEMS; ++i) assert_int_equal(t->seen[i], i < cases[k].count);
        free(t);
    }
}

UNIT_TEST(every_item_runs_once) {
    for (int i = 0; i < 100; ++i) check_loop(false);
}

UNIT_TEST(loops_can_nest) {
    for (int i = 0; i < 20; ++i) check_loop(true);
}

static void *loop_of_its_own(void *unused) {
    (void)unused;
    for (int i = 0; i < 20; ++i) check_loop(true);
    return NULL;
}

UNIT_TEST(loops_can_run_in_parallel) {
    pthread_t threads[4];
    for (int i = 0; i < 4; ++i) assert_int_equal(pthread_create(&threads[i], NULL, loop_of_its_own, NULL), 0);
    for (int i = 0; i < 4; ++i) pthread_join(threads[i], NULL);
}

static void wait_for_flag(void *user) {
    while (!atomic_load((atomic_bool *)user)) usleep(1000);
}

/* Waiting with a limit says that the work goes on, and when it has ended. */
UNIT_TEST(waiting_ends_in_time) {
    atomic_bool flag = false;
    pool_task task = {.run = wait_for_flag, .user = &flag};
    assert_true(pool_run(&task));
    assert_false(pool_wait(&task, 0.01));
    atomic_store(&flag, true);
    assert_true(pool_wait(&task, -1));
}

UNIT_TEST(a_context_uses_at_most_1024_threads) {
    fathom_context *context;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    fathom_context_set_threads(context, 1024);
    assert_int_equal(fathom_context_threads(context), 1024);
    fathom_context_set_threads(context, UINT32_MAX);
    assert_int_equal(fathom_context_threads(context), 1024);
    fathom_context_set_threads(context, 0);
    assert_int_equal(fathom_context_threads(context), processor_count());
    fathom_context_destroy(context);
}

/* A forked child has none of the threads, and makes its own. */
UNIT_TEST(a_forked_child_runs_loops) {
#ifdef __SANITIZE_THREAD__
    skip(); /* it does not support threads in a forked child */
#endif
    check_loop(false);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        alarm(60);
        check_loop(true);
        _exit(0);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

int main(void) { return unit_main(NULL, NULL); }
