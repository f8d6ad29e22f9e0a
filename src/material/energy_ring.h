/* Visible GGX facets with two alphas in rings around a viewer: what the tables of albedos sum. */
#pragma once

#include <math.h>

/* v: the unit vector to the viewer, v[2] > 0. s: v in the space where the facets are a hemisphere, made unit;
 * smith: its length there. */
typedef struct ring_viewer {
    float ax, ay, v[3], s[3], smith;
} ring_viewer;

static inline ring_viewer ring_viewer_at(float ax, float ay, const float v[3]) {
    const float sx = ax * v[0], sy = ay * v[1], smith = sqrtf(sx * sx + sy * sy + v[2] * v[2]);
    return (ring_viewer){ax, ay, {v[0], v[1], v[2]}, {sx / smith, sy / smith, v[2] / smith}, smith};
}

/* A facet's unit normal h; along: v·h. */
typedef struct ring_facet {
    float h[3], along;
} ring_facet;

/* Facets are parametrised as by Dupuy & Benyoub (2023), but uniformly in q = sqrt(1 - u'), because G2/G1
 * changes fast if q is small: a facet represents 2 q of the unit square. (cosine, sine): its azimuth. */
static inline ring_facet ring_facet_at(const ring_viewer *m, float q, float cosine, float sine) {
    const float up = q * q * (1 + m->s[2]), below = (m->s[0] * m->s[0] + m->s[1] * m->s[1]) / (1 + m->s[2]);
    const float square = (1 - q * q) * (1 + m->s[2]) * (below + up), r = sqrtf(square > 0 ? square : 0);
    const float hx = m->ax * (m->s[0] + r * cosine), hy = m->ay * (m->s[1] + r * sine);
    const float unit = 1 / sqrtf(hx * hx + hy * hy + up * up);
    const float x = hx * unit, y = hy * unit, z = up * unit;
    return (ring_facet){{x, y, z}, m->v[0] * x + m->v[1] * y + m->v[2] * z};
}

/* G2/G1 of a direction with the cosine z; 0 on the wrong side. */
static inline float ring_seen(const ring_viewer *m, float x, float y, float z) {
    const float cosine = z > 0 ? z : 0;
    const float smith = sqrtf(m->ax * m->ax * x * x + m->ay * m->ay * y * y + cosine * cosine);
    return cosine * (m->v[2] + m->smith) / (m->v[2] * smith + cosine * m->smith);
}

/* The same of the direction in which the facet mirrors the viewer. */
static inline float ring_mirrored(const ring_viewer *m, const ring_facet *f) {
    return ring_seen(m, 2 * f->along * f->h[0] - m->v[0], 2 * f->along * f->h[1] - m->v[1],
                     2 * f->along * f->h[2] - m->v[2]);
}
