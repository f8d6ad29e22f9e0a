/* What a measurement tells of how far it is: never less than before, and in the end all of its part. */
#pragma once

#include "measure/statistics.h"
#include "unit.h"

typedef struct told {
    double last;
    unsigned calls;
} told;

static inline void told_note(void *user, double fraction) {
    told *t = user;
    assert_true(fraction >= t->last);
    t->last = fraction;
    ++t->calls;
}

/* A quarter to three quarters of all. */
static inline bench_watch told_watch(told *t) {
    *t = (told){.last = 0.25};
    return (bench_watch){told_note, t, 0.25, 0.75};
}

/* Sums of at most some hundred shares below 1, each rounded: within 1000 · 2^-53. */
static inline void told_all(const told *t, unsigned least) {
    assert_true(t->calls >= least);
    assert_true(t->last > 0.75 - 1e-12 && t->last < 0.75 + 1e-12);
}
