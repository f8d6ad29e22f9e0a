/* The smaller and the larger of two numbers; limits of radiance and of the weights of paths, so that each
 * pixel is a finite number in any scene. */
#ifndef MATH_LIMIT_H
#define MATH_LIMIT_H

/* Without the calls of fminf() and fmaxf(), which mind NaN. */
static inline float least(float a, float b) { return a < b ? a : b; }
static inline float most(float a, float b) { return a > b ? a : b; }

/* At most 2^100. A product of two such numbers may be infinite, but never infinity times zero if each is
 * limited before the next; and 2^27 of them, more than a sample has paths times lights, add up to a float. */
static inline float limited(float x) { return x < 0x1p100f ? x : 0x1p100f; }

#endif
