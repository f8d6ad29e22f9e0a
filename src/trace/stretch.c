#include "trace/stretch.h"

#include <float.h>

/* Scales one component of a direction; tiny ones become zero. */
static float scaled(float part, int e) {
    part = ldexpf(part, -e);
    return fabsf(part) < STRETCH_ZERO ? copysignf(0, part) : part;
}

void stretch_rays(trace_rays *r, unsigned lanes, float high, stretch *out) {
    for (unsigned i = 0; i < lanes; ++i) {
        float x = fabsf(r->dir_x[i]), y = fabsf(r->dir_y[i]), z = fabsf(r->dir_z[i]),
              m = fmaxf(x, fmaxf(y, z));
        bool tiny = stretch_tiny(x) | stretch_tiny(y) | stretch_tiny(z);
        bool fits = m >= STRETCH_LOW && m <= high && !tiny, usable = m >= FLT_MIN && m <= FLT_MAX;
        int e = out->exponent[i] = fits || !usable ? 0 : ilogbf(m);
        if (fits || !usable) continue;
        r->dir_x[i] = scaled(r->dir_x[i], e);
        r->dir_y[i] = scaled(r->dir_y[i], e);
        r->dir_z[i] = scaled(r->dir_z[i], e);
        r->t_near[i] = ldexpf(r->t_near[i], e), r->t_far[i] = ldexpf(r->t_far[i], e);
    }
}

float stretch_back(const stretch *s, unsigned lane, float t, float t_near, float t_far) {
    if (s->exponent[lane] == 0) return t;
    t = ldexpf(t, -s->exponent[lane]);
    /* Tracing threads treat denormals as zero. */
    float least = t_near < FLT_MIN ? FLT_MIN : nextafterf(t_near, INFINITY), most = nextafterf(t_far, 0);
    return t < least ? least : t > most ? most : t;
}
