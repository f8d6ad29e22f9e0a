/* Pixel filters by importance sampling: a sample lies where the filter would weigh it, and counts in its own
 * pixel alone (Ernst, Stamminger, Greiner 2006). So pixels stay independent. */
#ifndef CAMERA_FILTER_H
#define CAMERA_FILTER_H

#include <fathom/render.h>

enum { FILTER_STEPS = 256 };

/* Where a filter's integral reaches i / FILTER_STEPS, in pixels from the pixel's centre. */
typedef struct pixel_filter {
    bool box; /* of one pixel: samples stay where they are */
    double at[FILTER_STEPS + 1];
} pixel_filter;

void filter_prepare(const fathom_settings *settings, pixel_filter *out);

/* From a place in the pixel, [0,1), to one by the filter, from the pixel's first edge. */
double filter_place(const pixel_filter *f, double u);

#endif
