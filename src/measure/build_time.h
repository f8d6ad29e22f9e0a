/* Quality of Embree's build against time: what each costs to build and saves in rendering. */
#ifndef BENCH_BUILD_TIME_H
#define BENCH_BUILD_TIME_H

#include "measure/stage.h"
#include "measure/statistics.h"

#define BUILD_QUALITIES 3
#define BUILD_REPEATS_MAX 100
#define BUILD_TOTALS 6 /* 1, 4, 16, 64, 256, 1024 samples a pixel */

typedef struct quality_time {
    const char *name; /* "low" */
    quartiles build[BENCH_CLOCKS];
    quartiles sample[BENCH_CLOCKS]; /* rendering by one sample a pixel */
    uint64_t rays, bvh_bytes;       /* rays of one sample a pixel, rounded */
    uint64_t peak_bytes;            /* the most that was held while it was built */
    /* Samples a pixel from where to where no other is as fast, by build + samples · sample of the medians;
     * from >= to: always another one is. */
    double from[BENCH_CLOCKS], to[BENCH_CLOCKS];
} quality_time;

typedef struct build_total {
    uint32_t spp;
    double seconds[BUILD_QUALITIES][BENCH_CLOCKS]; /* build and render */
    unsigned best[BENCH_CLOCKS], automatic;        /* by place */
    double behind[BENCH_CLOCKS]; /* the automatic choice's seconds over the best's, less 1 */
} build_total;

typedef struct build_time {
    quality_time qualities[BUILD_QUALITIES];
    build_total totals[BUILD_TOTALS];
} build_time;

/* Qualities take turns. words: a tracer of Embree's, without a quality, such as "embree:default". spp: of
 * each render, by sobol. watch may be NULL. */
fathom_status build_time_measure(fathom_context *context, bench_stage *stage, const char *words,
                                 unsigned repeats, uint32_t spp, const bench_watch *watch, build_time *out);

/* Ranges and totals from the medians. */
void build_time_summarise(const bench_stage *stage, build_time *result);

#endif
