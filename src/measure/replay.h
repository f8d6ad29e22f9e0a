/* The rays of a record asked again and timed: the ceiling of the render that they come from.
 *
 * Rays are brought to the processor's second-level cache piece by piece, and into the form that is asked for,
 * outside of what is timed. A render's rays are in its cache too when they are traced. */
#ifndef BENCH_REPLAY_H
#define BENCH_REPLAY_H

#include "measure/record.h"

typedef struct replay_result {
    double seconds, cpu_seconds; /* by the clock; of one thread's processor */
    uint64_t rays[2], met[2];    /* by bare_query */
} replay_result;

/* By Embree's calls alone; embree_bare_possible() must hold. All are false when out of memory. */
bool replay_bare(const record *r, const trace_tracer *tracer, replay_result *out);
/* The same by several threads at once, each of which asks all rays: the mean of their seconds, and the
 * first one's counts. Were they no hindrance to each other, they took as long as one alone. */
bool replay_bare_together(const record *r, const trace_tracer *tracer, unsigned threads, replay_result *out);
/* The same in packets of `width`, 1, 4, 8 or 16, by the kernels for coherent packets or the others. */
bool replay_bare_as(const record *r, const trace_tracer *tracer, unsigned width, bool coherent,
                    replay_result *out);
/* By trace_closest() and trace_any(). */
bool replay_traced(const record *r, const trace_tracer *tracer, replay_result *out);

#endif
