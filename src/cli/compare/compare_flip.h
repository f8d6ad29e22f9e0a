/* FLIP between two images of files. */
#ifndef CLI_COMPARE_FLIP_H
#define CLI_COMPARE_FLIP_H

#include "image/image.h"

/* One channel by its name, or NULL; and its value at (x, y). */
const image_channel *compare_channel(const image *img, const char *name);
double compare_value(const image_channel *c, uint32_t width, uint32_t x, uint32_t y);

typedef struct compare_side {
    const image *img;
    const char *path; /* EXR holds linear values, all else is taken to hold sRGB's */
} compare_side;

typedef struct compare_flip {
    double mean;
    uint64_t nonfinite; /* pixels, each of which counts as the largest error */
} compare_flip;

/* The images are of one size. FATHOM_BAD_INPUT when one of them has no R, G and B of numbers. */
fathom_status compare_flip_of(fathom_context *context, const compare_side *a, const compare_side *b,
                              double ppd, compare_flip *out);

#endif
