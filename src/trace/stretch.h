/* Scales ray directions of any length by a power of two, for tracers that need lengths around 1. Only the
 * unit of t changes.
 *
 * In box tests, Embree clamps direction components to at least 1e-18 in magnitude, which changes short
 * directions. It takes no coordinate above 1.84e18, and the square of a direction leaves float's range beyond
 * 1e±19. */
#pragma once

#include "trace/trace.h"

#define STRETCH_LOW 0x1p-30f
#define STRETCH_HIGH 0x1p30f /* at most; Embree's limit in the space of an instance may be lower */
/* Embree's kernels for coherent packets lose rays, or abort, if a component of a direction is smaller than
 * 1e-18 and not zero (3.13.5), in any space. Such directions are scaled. A component below about STRETCH_ZERO
 * times the largest becomes zero: that rotates the ray by a millionth of float's roundoff. */
#define STRETCH_TINY 1e-13f
#define STRETCH_ZERO 0x1p-45f

static inline int stretch_tiny(float size) { return (size < STRETCH_TINY) & (size > 0); }

/* True if the largest component of any direction is outside [STRETCH_LOW, high], or any component is tiny. It
 * runs for every block, so the loop has no branches. */
static inline bool stretch_needed(const trace_rays *rays, unsigned lanes, float high) {
    int odd = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float x = fabsf(rays->dir_x[i]), y = fabsf(rays->dir_y[i]), z = fabsf(rays->dir_z[i]);
        float m = x > y ? x : y;
        m = m > z ? m : z;
        odd |= stretch_tiny(x) | stretch_tiny(y) | stretch_tiny(z);
        odd |= !((m >= STRETCH_LOW) & (m <= high));
    }
    return odd;
}

/* Scale of each lane: the direction is multiplied by 2^-exponent, t by 2^exponent. */
typedef struct stretch {
    int exponent[LANES];
} stretch;

/* Scales the directions outside the limits so that their largest component is in [1, 2), and their intervals
 * to match. Zero directions and numbers that are not finite stay unchanged. high: at least 2. */
void stretch_rays(trace_rays *rays, unsigned lanes, float high, stretch *out);

/* Returns a lane's t in the units of the original ray. A t outside float's range becomes the nearest float
 * inside (t_near, t_far), the original interval. */
float stretch_back(const stretch *s, unsigned lane, float t, float t_near, float t_far);
