/* Directions of any length for tracers that take lengths around 1: scaled by a power of two, which changes
 * nothing but the unit of t.
 *
 * Embree takes no component of a direction for less than 1e-18 where it tests boxes, which turns short ones
 * aside, and no coordinate above 1.84e18; the square of a direction leaves float's range beyond 1e±19. */
#ifndef TRACE_STRETCH_H
#define TRACE_STRETCH_H

#include "trace/trace.h"

#define STRETCH_LOW 0x1p-30f
#define STRETCH_HIGH 0x1p30f
/* Embree's kernels for coherent packets lose rays, or abort, where a component of a direction is smaller than
 * 1e-18 and not zero (3.13.5), in any space. Such directions are scaled, and a component below STRETCH_ZERO
 * of about the largest becomes zero: that turns the ray by a millionth of float's roundoff. */
#define STRETCH_TINY 1e-13f
#define STRETCH_ZERO 0x1p-45f

static inline int stretch_tiny(float size) { return (size < STRETCH_TINY) & (size > 0); }

/* True if the largest component of some direction is not within [STRETCH_LOW, STRETCH_HIGH], or one is tiny.
 * A loop without branches, for every block. */
static inline bool stretch_needed(const trace_rays *rays, unsigned lanes) {
    int odd = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float x = fabsf(rays->dir_x[i]), y = fabsf(rays->dir_y[i]), z = fabsf(rays->dir_z[i]);
        float m = x > y ? x : y;
        m = m > z ? m : z;
        odd |= stretch_tiny(x) | stretch_tiny(y) | stretch_tiny(z);
        odd |= !((m >= STRETCH_LOW) & (m <= STRETCH_HIGH));
    }
    return odd;
}

/* The scale of each lane: its direction was multiplied by 2^-exponent, its t by 2^exponent. */
typedef struct stretch {
    int exponent[LANES];
} stretch;

/* Scales the directions outside of the limits, so that their largest component is in [1, 2), and the
 * intervals with them. Zero directions and numbers that are not finite stay. */
void stretch_rays(trace_rays *rays, unsigned lanes, stretch *out);

/* Returns a lane's t in the units of the original ray. A t outside float's range becomes the nearest float
 * inside (t_near, t_far), the original interval. */
float stretch_back(const stretch *s, unsigned lane, float t, float t_near, float t_far);

#endif
