/* Threads that wait for ever, and those that only take their time. */
#include "base/stall.h"

#include "unit.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <time.h>
#include <unistd.h>

static const struct timespec tenth = {0, 110000000};

typedef struct subject {
    sem_t begun, go_on;
    atomic_bool stop;
    pid_t thread;
} subject;

static void *waits(void *user) {
    subject *s = user;
    s->thread = gettid();
    sem_post(&s->begun);
    sem_wait(&s->go_on);
    return NULL;
}

static void *polls(void *user) {
    subject *s = user;
    s->thread = gettid();
    sem_post(&s->begun);
    while (!atomic_load(&s->stop)) nanosleep(&(struct timespec){0, 1000000}, NULL);
    return NULL;
}

static void *computes(void *user) {
    subject *s = user;
    s->thread = gettid();
    sem_post(&s->begun);
    while (!atomic_load(&s->stop)) continue;
    return NULL;
}

static void *(*const ways[])(void *) = {waits, polls, computes};

/* All side by side, for as long as it takes to be sure of the first. */
static void only_who_waits_for_ever(void **state) {
    (void)state;
    subject subjects[3];
    pthread_t threads[3];
    stall looks[3];
    for (int i = 0; i < 3; ++i) {
        sem_init(&subjects[i].begun, 0, 0), sem_init(&subjects[i].go_on, 0, 0);
        atomic_init(&subjects[i].stop, false);
        assert_int_equal(pthread_create(&threads[i], NULL, ways[i], &subjects[i]), 0);
        sem_wait(&subjects[i].begun);
        looks[i] = (stall){.thread = subjects[i].thread};
    }
    unsigned count = 0;
    while (!stall_look(&looks[0])) {
        assert_false(stall_look(&looks[1]));
        assert_false(stall_look(&looks[2]));
        nanosleep(&tenth, NULL);
        assert_true(++count < 100 * STALL_SECONDS); /* it may sleep a little at first */
    }
    assert_true(count >= 10 * STALL_SECONDS - 10); /* no sooner than it says */
    assert_false(stall_look(&looks[1]));
    assert_false(stall_look(&looks[2]));
    /* Looking again at once changes nothing. */
    assert_true(stall_look(&looks[0]));
    for (int i = 0; i < 3; ++i) {
        atomic_store(&subjects[i].stop, true);
        sem_post(&subjects[i].go_on);
        pthread_join(threads[i], NULL);
    }
}

/* One sign of life, and it begins anew. */
static void waking_once_is_enough(void **state) {
    (void)state;
    subject s;
    pthread_t thread;
    sem_init(&s.begun, 0, 0), sem_init(&s.go_on, 0, 0);
    assert_int_equal(pthread_create(&thread, NULL, waits, &s), 0);
    sem_wait(&s.begun);
    stall looks = {.thread = s.thread};
    while (looks.idle < 3) {
        assert_false(stall_look(&looks));
        nanosleep(&tenth, NULL);
    }
    looks.switches -= 1; /* as if it had woken since */
    assert_false(stall_look(&looks));
    assert_int_equal(looks.idle, 0);
    sem_post(&s.go_on);
    pthread_join(thread, NULL);
    /* It is gone, and nothing can be said of it. */
    for (int i = 0; i < 3; ++i) {
        nanosleep(&tenth, NULL);
        assert_false(stall_look(&looks));
        assert_int_equal(looks.idle, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(only_who_waits_for_ever),
                                       cmocka_unit_test(waking_once_is_enough)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
