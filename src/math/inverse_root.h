/* 1 / sqrt(x): the same bits on every processor, and inside loops a quarter of what dividing by the root
 * takes. */
#ifndef MATH_INVERSE_ROOT_H
#define MATH_INVERSE_ROOT_H

#include <stdint.h>
#include <string.h>

/* For normal x > 0; a few units of double's roundoff off. Halving the bits as a number halves the logarithm,
 * but for e = 3.5 % (Lomont, "Fast Inverse Square Root", 2003, with his constant for double); each step of
 * Newton's makes 3/2 e^2 of it: 1.8e-3, 4.7e-6, 3.3e-11, 1.6e-21. 4x gives half of x's bits, exactly, so
 * scenes of another size get the same directions. */
static inline double inverse_root(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = UINT64_C(0x5fe6eb50c7b537a9) - (bits >> 1);
    double half = 0.5 * x, r;
    memcpy(&r, &bits, sizeof r);
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    return r * (1.5 - half * r * r);
}

/* The same for float x that is normal. */
static inline float inverse_root_f32(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = UINT32_C(0x5f375a86) - (bits >> 1);
    float half = 0.5f * x, r;
    memcpy(&r, &bits, sizeof r);
    r = r * (1.5f - half * r * r);
    r = r * (1.5f - half * r * r);
    return r * (1.5f - half * r * r);
}

#endif
