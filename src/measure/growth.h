/* How reading, building and tracing grow with the number of triangles. */
#ifndef BENCH_GROWTH_H
#define BENCH_GROWTH_H

#include "measure/render_time.h"
#include "measure/stage.h"

#define GROWTH_REPEATS_MAX 100

typedef struct growth_options {
    unsigned repeats; /* [1, GROWTH_REPEATS_MAX]; fewer where those of one phase take longer than `seconds` */
    double seconds;
    uint32_t width, height;
    uint64_t record_bytes;    /* as of render_time_options */
    const bench_watch *watch; /* may be NULL */
} growth_options;

/* One mesh. Phases run once more than they are counted: the first time warms up. Reading is of a file in the
 * system's cache; building is all that stands between the scene and the first ray. */
typedef struct growth_point {
    uint64_t triangles, file_bytes, bvh_bytes, peak_bytes; /* peak: of the tracer while it is built */
    quartiles read[BENCH_CLOCKS], build[BENCH_CLOCKS];
    render_time time; /* by one thread */
    char tracer[64];
} growth_point;

/* Measures the model in the file, or returns FATHOM_BAD_INPUT. Leaves the context with one thread. */
fathom_status growth_measure(fathom_context *context, const char *path, const growth_options *options,
                             growth_point *out);

/* seconds ∝ triangles^exponent, by least squares in the logarithms: exponent ± half holds 95 %. */
typedef struct growth_fit {
    double exponent, half, scale; /* seconds = scale · triangles^exponent */
    size_t count;
} growth_fit;

/* Fits the pairs that are positive; NAN where there are fewer than two different ones. */
growth_fit growth_fit_of(const double *triangles, const double *seconds, size_t count);

#endif
