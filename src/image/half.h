/* 16-bit floats as OpenEXR stores them. */
#ifndef IMAGE_HALF_H
#define IMAGE_HALF_H

#include <stdint.h>
#include <string.h>

/* The nearest half, ties to even, denormals kept. Finite values beyond the range become the largest finite
 * half, ±65504; infinities and NaN stay what they are. */
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
        /* The last bit of 0.5f is 2^-24, as is that of a denormal half: the addition rounds. */
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

#endif
