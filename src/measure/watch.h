/* How far a measurement is, for whoever waits. Told between the things that are timed, never during them. */
#ifndef BENCH_WATCH_H
#define BENCH_WATCH_H

typedef struct bench_watch {
    void (*tell)(void *user, double fraction); /* NULL: nobody waits */
    void *user;
    double from, to; /* the measurement's part of all that is told of, within [0,1] */
} bench_watch;

/* `done` of `total`, in any unit that is in proportion to time; watch may be NULL. */
void bench_watch_tell(const bench_watch *watch, double done, double total);
/* The part between two shares of the measurement; of NULL a watch that tells nobody. */
bench_watch bench_watch_part(const bench_watch *watch, double from, double to);

#endif
