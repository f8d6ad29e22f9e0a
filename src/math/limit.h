/* The minimum and the maximum of two numbers; limits of radiance and of path throughput, so that each pixel
 * is finite in any scene. */
#pragma once

/* Used in place of fminf() and fmaxf(), which handle NaN and therefore are function calls. */
static inline float least(float a, float b) { return a < b ? a : b; }
static inline float most(float a, float b) { return a > b ? a : b; }

/* Limits x to 2^100. A product of two such numbers may be infinite. But if each product is limited before the
 * next one, infinity is never multiplied by zero. The sum of 2^27 such numbers is finite as float; no sample
 * has that many paths times lights. */
static inline float limited(float x) { return x < 0x1p100f ? x : 0x1p100f; }
