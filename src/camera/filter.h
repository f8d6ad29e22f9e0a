/* Pixel filters by importance sampling: sample positions are distributed like the filter, and each sample
 * counts only in its own pixel (Ernst, Stamminger, Greiner 2006). Pixels therefore stay independent. */
#pragma once

#include <fathom/render.h>

/* A step of the Blackman-Harris filter's tail is long, and within a step samples are even: 256 steps put 0.17
 * % of the weight into the wrong place. */
enum { FILTER_STEPS = 1024 };

/* Positions at which a filter's integral reaches i / FILTER_STEPS, in pixels from the pixel's centre. */
typedef struct pixel_filter {
    bool box; /* a box one pixel wide: samples keep their positions */
    double at[FILTER_STEPS + 1];
} pixel_filter;

void filter_prepare(const fathom_settings *settings, pixel_filter *out);

/* Maps a position in the pixel, [0,1), to one distributed like the filter, relative to the pixel's first
 * edge. */
double filter_place(const pixel_filter *f, double u);
/* The density of these positions at x. */
double filter_density(const pixel_filter *f, double x);
