/* Stiff and extreme cases of shading: small scenes through the real renderer, each compared with a formula
 * evaluated in double. The bound follows from roundings counted at the case. */
#ifndef VERIFY_SHADING_H
#define VERIFY_SHADING_H

#include "base/array.h"

#include <fathom/fathom.h>

/* One case. A case of many pixels is told by the one whose error is the largest share of its bound. */
typedef struct shading_row {
    const char *group; /* "mirrors", "ior"…: what one plot shows */
    double parameter;  /* its x axis */
    char what[120];    /* the case in words for a person */
    const char *spec;  /* the tracer, as asked for: the caller's text */
    double measured, expected, error, bound;
    bool ok; /* error <= bound, and every channel of every pixel is finite */
} shading_row;

typedef ARRAY(shading_row) shading_rows;

typedef struct shading_image {
    char title[64], caption[400];
    double difference; /* the most that a pixel differs by from the first image */
    unsigned char *png;
    size_t png_bytes;
} shading_image;

typedef ARRAY(shading_image) shading_images;

typedef struct shading_options {
    const char *spec;            /* what traces, as trace_spec_parse() reads it; outlives the rows */
    double twist;                /* for tests: the formulas' parameters are taken wrong by this share; 0 */
    fathom_progress_fn progress; /* of each small image, as fathom_render() tells; may be NULL */
    void *user;
} shading_options;

/* Appends a row for each case. Returns FATHOM_OK even when rows are not ok. */
fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out);

/* A demonstration scene at the origin of coordinates, moved by the Earth's radius and by other distances: a
 * row for each that compares the images. By linear search in quadruple precision it would take minutes: none
 * then. */
fathom_status shading_earth(fathom_context *context, const shading_options *options, shading_rows *rows);
/* The scene at the origin and moved, and what plain float makes of it; by Embree, whatever is named. */
fathom_status shading_earth_images(fathom_context *context, const shading_options *options,
                                   shading_images *images);

void shading_images_free(shading_images *images);

#endif
