/* Converts an image's channels to rows of interleaved pixels in a file's types. */
#pragma once

#include "image/helper/module.h"

#include <math.h>

/* round(255 v), clamped to [0,255]; NaN is 0. */
static inline unsigned char byte_from_float(float value) {
    if (!(value > 0.0f)) return 0;
    return value < 1.0f ? (unsigned char)(value * 255.0f + 0.5f) : 255;
}

/* The nearest 16-bit float, ties to even, denormals kept. Finite values beyond the range become the largest
 * finite half, ±65504; infinities and NaN are kept. */
static inline uint16_t half_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu, half;
    if (magnitude > 0x7f800000u) {
        half = 0x7e00u | (magnitude >> 13 & 0x1ffu);
    } else if (magnitude == 0x7f800000u) {
        half = 0x7c00u;
    } else if (magnitude > 0x477fe000u) { /* 65504 */
        half = 0x7bffu;
    } else if (magnitude < 0x38800000u) { /* 2^-14 */
        /* The last bit of 0.5f is worth 2^-24, like that of a denormal half, so the addition rounds to it. */
        float aligned;
        memcpy(&aligned, &magnitude, sizeof aligned);
        aligned += 0.5f;
        memcpy(&half, &aligned, sizeof half);
        half -= 0x3f000000u;
    } else {
        uint32_t odd = magnitude >> 13 & 1u;
        half = (magnitude - (112u << 23) + 0xfffu + odd) >> 13;
    }
    return (uint16_t)(sign | half);
}

/* The built-in view: linear values to 8-bit sRGB, with exactly the codes of the view "sRGB" of
 * helper/ocio.cpp. Comparisons find the code: floats are divided into buckets, so narrow that at most one
 * step between codes lies in each. The floats of a bucket have the same exponent and first 7 bits of the
 * mantissa. Buckets cover 2^-13, below which all codes are 0, to 1. */
#define SRGB_LEAST 0x1p-13f
#define SRGB_FIRST_BUCKET ((127u - 13u) << 7)
#define SRGB_BUCKETS ((13u << 7) + 1u)

typedef struct srgb_codes {
    float next[256];                   /* the smallest value with a higher code; infinity for 255 */
    unsigned char first[SRGB_BUCKETS]; /* the code of each bucket's smallest value */
} srgb_codes;

/* Takes about 0.1 ms. */
void srgb_codes_fill(srgb_codes *out);

/* Negative values and NaN give 0, values above 1 give 255. */
static inline unsigned char srgb_code(const srgb_codes *codes, float value) {
    float inside = value > SRGB_LEAST ? value : SRGB_LEAST;
    inside = inside < 1.0f ? inside : 1.0f;
    uint32_t bits;
    memcpy(&bits, &inside, sizeof bits);
    unsigned code = codes->first[(bits >> 16) - SRGB_FIRST_BUCKET];
    return (unsigned char)(code + (inside >= codes->next[code]));
}

/* For 8-bit files. */
typedef struct image_packing {
    const image *img;
    float gain;             /* 2^exposure */
    const srgb_codes *srgb; /* for the built-in view */
} image_packing;

/* Row y of R, G, B and optionally A, in sRGB, as bytes. */
void pack_row_srgb(const image_packing *packing, uint32_t y, unsigned char *out);

/* Input of a view for row y: 4 · width finite floats. */
void pack_row_for_view(const image_packing *packing, uint32_t y, float *rgba);
/* Row y of the file from the view's result, as bytes. */
void pack_row_from_view(const image_packing *packing, uint32_t y, const float *rgba, unsigned char *out);
