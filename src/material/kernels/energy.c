/* Midpoint rules over visible GGX facets in rings around a viewer. The integrand goes to 0 at the horizon, so
 * it has no steps. Sums are kept by place in the ring: separate sums let the loops vectorise. */
#include "material/energy_kernels.h"

#include "base/kernel.h"
#include "math/power.h"
#include "math/turn.h"

#include <math.h>

enum { ALONG = 32, GLASS_ALONG = 96 };

/* v: the unit vector to the viewer. s: v in the space where the facets are a hemisphere, made unit; smith:
 * its length there. */
typedef struct viewer {
    float ax, ay, v[3], s[3], smith;
} viewer;

static viewer viewer_of(const energy_view *view) {
    const float *v = view->v, sx = view->ax * v[0], sy = view->ay * v[1],
                smith = sqrtf(sx * sx + sy * sy + v[2] * v[2]);
    return (viewer){view->ax, view->ay, {v[0], v[1], v[2]}, {sx / smith, sy / smith, v[2] / smith}, smith};
}

/* Azimuth j as a fraction of a turn. */
static float turn_of(const energy_view *view, int j) {
    return (view->v[1] == 0 ? 0.5f : 1) * ((float)j + 0.5f) / (float)view->around;
}

/* A facet's unit normal h; along: v·h. */
typedef struct facet {
    float h[3], along;
} facet;

/* Facets are parametrised as by Dupuy & Benyoub (2023), but uniformly in q = sqrt(1 - u'), because G2/G1
 * changes fast if q is small: a facet represents 2 q of the unit square. (cosine, sine): its azimuth. */
static inline facet facet_at(const viewer *m, float q, float cosine, float sine) {
    const float up = q * q * (1 + m->s[2]), below = (m->s[0] * m->s[0] + m->s[1] * m->s[1]) / (1 + m->s[2]);
    const float square = (1 - q * q) * (1 + m->s[2]) * (below + up), r = sqrtf(square > 0 ? square : 0);
    const float hx = m->ax * (m->s[0] + r * cosine), hy = m->ay * (m->s[1] + r * sine);
    const float unit = 1 / sqrtf(hx * hx + hy * hy + up * up);
    const float x = hx * unit, y = hy * unit, z = up * unit;
    return (facet){{x, y, z}, m->v[0] * x + m->v[1] * y + m->v[2] * z};
}

/* G2/G1 of a direction with the cosine z; 0 on the wrong side. */
static inline float seen(const viewer *m, float x, float y, float z) {
    const float cosine = z > 0 ? z : 0;
    const float smith = sqrtf(m->ax * m->ax * x * x + m->ay * m->ay * y * y + cosine * cosine);
    return cosine * (m->v[2] + m->smith) / (m->v[2] * smith + cosine * m->smith);
}

/* The same of the direction in which the facet mirrors the viewer. */
static inline float mirrored(const viewer *m, const facet *f) {
    return seen(m, 2 * f->along * f->h[0] - m->v[0], 2 * f->along * f->h[1] - m->v[1],
                2 * f->along * f->h[2] - m->v[2]);
}

/* ---- mirrors ---- */

static void add_mirrors(const viewer *m, float turn, float all[restrict ALONG], float edge[restrict ALONG]) {
    float cosine, sine;
    turn_by(turn, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        const float q = ((float)k + 0.5f) / ALONG;
        const facet f = facet_at(m, q, cosine, sine);
        const float part = 2 * q * mirrored(m, &f);
        all[k] += part, edge[k] += part * power5(f.along < 1 ? 1 - f.along : 0);
    }
}

static void mirror(const energy_view *view, float out[2]) {
    const viewer m = viewer_of(view);
    float all[ALONG] = {0}, edge[ALONG] = {0};
    for (int j = 0; j < view->around; ++j) add_mirrors(&m, turn_of(view, j), all, edge);
    out[0] = out[1] = 0;
    for (int k = 0; k < ALONG; ++k) out[0] += all[k], out[1] += edge[k];
    for (int c = 0; c < 2; ++c) out[c] /= (float)(view->around * ALONG);
}

/* ---- glass ---- */

typedef struct glass_sums {
    float low[GLASS_ALONG], high[GLASS_ALONG], open[GLASS_ALONG];
} glass_sums;

static void add_glass(const viewer *m, float eta, float turn, glass_sums *restrict sums) {
    const float inverse = 1 / eta;
    float cosine, sine;
    turn_by(turn, &cosine, &sine);
    for (int k = 0; k < GLASS_ALONG; ++k) {
        const float q = ((float)k + 0.5f) / GLASS_ALONG;
        const facet f = facet_at(m, q, cosine, sine);
        const float along = f.along < 1 ? f.along : 1;
        const float far2 = 1 - (1 - along) * (1 + along) * (inverse * inverse);
        const float far = sqrtf(far2 > 0 ? far2 : 0), of_h = along * inverse - far;
        const float back = mirrored(m, &f);
        const float through = seen(m, of_h * f.h[0] - m->v[0] * inverse, of_h * f.h[1] - m->v[1] * inverse,
                                   m->v[2] * inverse - of_h * f.h[2]);
        const float refracted = far2 > 0 ? through : 0, near = eta < 1 ? far : along;
        const float rise = far2 > 0 ? power5(1 - near) : 1;
        sums->low[k] += 2 * q * (back - refracted) * (1 - rise);
        sums->high[k] += 2 * q * (back - refracted) * rise;
        sums->open[k] += 2 * q * refracted;
    }
}

static void glass(const energy_view *view, float eta, float out[3]) {
    const viewer m = viewer_of(view);
    glass_sums sums = {{0}, {0}, {0}};
    for (int j = 0; j < view->around; ++j) add_glass(&m, eta, turn_of(view, j), &sums);
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < GLASS_ALONG; ++k)
        out[0] += sums.low[k], out[1] += sums.high[k], out[2] += sums.open[k];
    for (int c = 0; c < 3; ++c) out[c] /= (float)(view->around * GLASS_ALONG);
}

/* ---- by the cosine between viewer and facet ---- */

static void add_facets(const viewer *m, float turn, float part, float *restrict out) {
    float cosine, sine, share[ALONG], place[ALONG];
    turn_by(turn, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        const float q = ((float)k + 0.5f) / ALONG;
        const facet f = facet_at(m, q, cosine, sine);
        share[k] = part * 2 * q * mirrored(m, &f);
        place[k] = sqrtf(f.along > 0 ? (f.along < 1 ? f.along : 1) : 0) * ENERGY_FACETS_STEPS;
    }
    for (int k = 0; k < ALONG; ++k) {
        const int node = place[k] < ENERGY_FACETS_STEPS - 1 ? (int)place[k] : ENERGY_FACETS_STEPS - 1;
        const float t = place[k] - (float)node;
        out[node] += (1 - t) * share[k], out[node + 1] += t * share[k];
    }
}

static void facets(const energy_view *view, float part, float out[ENERGY_FACETS_STEPS + 1]) {
    const viewer m = viewer_of(view);
    for (int j = 0; j < view->around; ++j)
        add_facets(&m, turn_of(view, j), part / (float)(view->around * ALONG), out);
}

const energy_kernels KERNEL(energy_kernels) = {.mirror = mirror, .glass = glass, .facets = facets};
