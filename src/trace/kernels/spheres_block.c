/* Spheres against a block of rays. */
#include "base/kernel.h"
#include "reference/reference.h"
#include "trace/embree/embree_api.h"
#include "trace/embree/embree_spheres.h"

#include <math.h>

#define ALWAYS_INLINE inline __attribute__((always_inline))

/* ---- all spheres against the beam of a block ---- */

/* Bounds all rays of a block relative to o and d of the first: |o_i - o| <= wide, |d_i - d| <= turn, t_i <=
 * end. The norm is the 1-norm, which is never below the length. */
typedef struct beam {
    vec3_f32 org, dir;
    float wide, turn, end;
} beam;

static ALWAYS_INLINE float sum_of(vec3_f32 v) { return fabsf(v.x) + fabsf(v.y) + fabsf(v.z); }

static ALWAYS_INLINE float larger(float a, float b) { return a > b ? a : b; }
static ALWAYS_INLINE float largest(vec3_f32 v) { return larger(fabsf(v.x), larger(fabsf(v.y), fabsf(v.z))); }

static ALWAYS_INLINE int32_t bits_of(float x) {
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static ALWAYS_INLINE float of_bits(int32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Non-negative floats have the same order as their bits, with NaN last, and the compiler vectorises an
 * integer maximum. If all t_far are negative, `end` is one of them. */
static ALWAYS_INLINE beam beam_of(const trace_rays *rays) {
    beam b = {.org = {rays->org_x[0], rays->org_y[0], rays->org_z[0]},
              .dir = {rays->dir_x[0], rays->dir_y[0], rays->dir_z[0]}};
    int32_t wide = 0, turn = 0, end = bits_of(rays->t_far[0]);
    for (int i = 0; i < LANES; ++i) {
        vec3_f32 o = {rays->org_x[i], rays->org_y[i], rays->org_z[i]};
        vec3_f32 d = {rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]};
        int32_t w = bits_of(sum_of(sub_f32(o, b.org))), t = bits_of(sum_of(sub_f32(d, b.dir)));
        int32_t e = bits_of(rays->t_far[i]);
        wide = w > wide ? w : wide, turn = t > turn ? t : turn, end = e > end ? e : end;
    }
    b.wide = of_bits(wide), b.turn = of_bits(turn), b.end = of_bits(end);
    return b;
}

/* A point of a ray at t lies within wide + t turn of o + t d. With f from o to the centre: a ray that hits a
 * sphere at t has travelled t |d_i| <= |f| + R + wide, so t <= T = (|f| + R + wide) / (|d| - turn). Then the
 * line of o and d passes the centre within R + wide + T turn, or o itself is that close. The ray also travels
 * at least |f| - R - wide before the hit. For |f| we use the 1-norm or the maximum norm, whichever is safe.
 *
 * Errors in float, u = 2^-24: f has 2 u of the coordinates on each axis, f²d² - (f·d)² less than 16 u f²d²,
 * all other terms less than 16 u of themselves. 2^-18 covers each of these. With a NaN anywhere, the sphere
 * counts as close. */
static uint32_t close_to(const few_spheres *s, const trace_rays *rays) {
    const beam b = beam_of(rays);
    const float slack = 0x1p-18f, a = dot_f32(b.dir, b.dir), length = sqrtf(a);
    const float least = length * (1 - slack) - b.turn, most = (length + b.turn) * (1 + slack);
    const float around = sum_of(b.org), rate = b.turn / least;
    const float end = b.end * most * (1 + 0x1p-14f); /* including hits that are about equally near:
                                                        embree_settle.c */
    if (!(least > 0.5f * length) || !(b.wide < INFINITY)) return (1u << s->count) - 1;
    uint32_t close = 0;
    for (int k = 0; k < FEW_SPHERES_MOST; ++k) {
        vec3_f32 c = {s->x[k], s->y[k], s->z[k]}, f = sub_f32(c, b.org);
        float f2 = dot_f32(f, f), along = dot_f32(f, b.dir);
        float reach = s->radius[k] + b.wide + slack * (around + sum_of(c));
        float aside = reach + (sum_of(f) + reach) * rate;
        float within = aside * aside + slack * (f2 + aside * aside);
        int passes = f2 * a - along * along > within * a;
        int behind = (along < 0) & (f2 > within);
        int late = largest(f) * (1 - slack) - reach > end;
        close |= passes | behind | late ? 0 : 1u << k;
    }
    return close & ((1u << s->count) - 1);
}

/* ---- one sphere, sixteen rays ---- */

static void find_roots(const world_sphere *sphere, const trace_rays *rays, few_roots *restrict out) {
    const vec3_f32 center = sphere->center;
    const float radius = sphere->radius;
    uint32_t real = 0, doubt = 0;
    for (int i = 0; i < LANES; ++i) {
        float roots[2];
        bool sure;
        bool met = sphere_plain_f32(center, radius, trace_org(rays, (size_t)i), trace_dir(rays, (size_t)i),
                                    roots, &sure);
        real |= met ? 1u << i : 0, doubt |= sure ? 0 : 1u << i;
        out->near[i] = roots[0], out->far[i] = roots[1];
    }
    out->met = real, out->doubt = doubt;
    if (world_sphere_is_split(sphere)) out->doubt = (1u << LANES) - 1;
}

/* ---- a cluster, one ray ---- */

static vec3_f32 row_vector(const float *row, size_t stride) {
    return vec_f32(row[0], row[stride], row[2 * stride]);
}

/* The ray is read here, because vector arguments would be packed in halves and unpacked again. */
static void cluster_meet(const sphere_cluster *c, const float *ray, size_t stride,
                         cluster_roots *restrict out) {
    const vec3_f32 org = row_vector(ray + EMBREE_ROW_ORG * stride, stride),
                   dir = row_vector(ray + EMBREE_ROW_DIR * stride, stride);
    uint32_t real[CLUSTER], unsure[CLUSTER], met = 0, doubt = 0;
#pragma GCC unroll 1 /* otherwise gcc unrolls the short loop instead of vectorising it */
    for (int k = 0; k < CLUSTER; ++k) {
        const vec3_f32 center = {c->x[k], c->y[k], c->z[k]};
        float roots[2];
        bool sure;
        real[k] = sphere_plain_f32(center, c->radius[k], org, dir, roots, &sure) ? 1u << k : 0;
        unsure[k] = sure ? 0 : 1u << k;
        out->near[k] = roots[0], out->far[k] = roots[1];
    }
    for (int k = 0; k < CLUSTER; ++k) met |= real[k], doubt |= unsure[k];
    out->met = met, out->doubt = doubt | c->split;
}

const few_kernels KERNEL(few_kernels) = {.close = close_to, .roots = find_roots, .cluster = cluster_meet};
