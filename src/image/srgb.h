/* The built-in view without OpenColorIO: linear light straight to 8-bit sRGB, to the last bit what the view
 * "sRGB" of module/ocio.cpp makes of it.
 *
 * A code is found by comparing, not by a power: floats fall into buckets so narrow that in none of them there
 * is more than one step from a code to the next. */
#ifndef IMAGE_SRGB_H
#define IMAGE_SRGB_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* A bucket is what shares the exponent and 7 bits behind the point, from 2^-13, below which all is 0, to 1.
 */
#define SRGB_LEAST 0x1p-13f
#define SRGB_FIRST_BUCKET ((127u - 13u) << 7)
#define SRGB_BUCKETS ((13u << 7) + 1u)

typedef struct srgb_codes {
    float next[256];                   /* the least value whose code is above this one; infinity above 255 */
    unsigned char first[SRGB_BUCKETS]; /* the code of each bucket's least value */
} srgb_codes;

/* Takes some 0.1 ms. */
void srgb_codes_fill(srgb_codes *out);

/* Below 0, and NaN, is 0; above 1 is 255. */
static inline unsigned char srgb_code(const srgb_codes *codes, float value) {
    float inside = value > SRGB_LEAST ? value : SRGB_LEAST;
    inside = inside < 1.0f ? inside : 1.0f;
    uint32_t bits;
    memcpy(&bits, &inside, sizeof bits);
    unsigned code = codes->first[(bits >> 16) - SRGB_FIRST_BUCKET];
    return (unsigned char)(code + (inside >= codes->next[code]));
}

#endif
