/* Extreme cases of shading: small scenes rendered by the real renderer, each compared with a formula
 * evaluated in double. Comments at each case derive its error bound by counting roundings. */
#pragma once

#include "base/array.h"

#include <fathom/fathom.h>

/* One case. If it has many pixels, the row shows the pixel with the largest ratio of error to bound. */
typedef struct shading_row {
    const char *group; /* "mirrors", "ior"…: one plot per group */
    double parameter;  /* x coordinate in the plot */
    char what[120];    /* description of the case for the user */
    const char *spec;  /* the tracer's specification; points to the caller's text */
    double measured, expected, error, bound;
    bool ok; /* error <= bound, and every channel of every pixel is finite */
} shading_row;

typedef ARRAY(shading_row) shading_rows;

typedef struct shading_options {
    const char *spec;            /* the tracer, for trace_spec_parse(); must outlive the rows */
    double twist;                /* for tests: relative error put into the formulas' parameters; default 0 */
    fathom_progress_fn progress; /* progress of each small image, as in fathom_render(); may be NULL */
    void *user;
} shading_options;

/* Appends a row for each case. Returns FATHOM_OK even when rows are not ok. */
fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out);

/* Renders a demonstration scene at the origin, and moved by the Earth's radius and other distances. Appends a
 * row that compares the images for each distance. Appends none for linear search in quadruple precision,
 * which would take minutes. */
fathom_status shading_earth(fathom_context *context, const shading_options *options, shading_rows *rows);
