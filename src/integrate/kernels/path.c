/* Light samples of path vertices, and the scattered rays. */
#include "base/kernel.h"
#include "integrate/path/path_kernels.h"
#include "math/limit.h"

#include <math.h>

static void aim(const surface_block *s, const lanes3 n, const emitter_sample *light,
                light_block *restrict ray, uint32_t behind[restrict LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float along = 0, side = 0, to[3], square = 0;
        for (int c = 0; c < 3; ++c) {
            along += light->direction[c][i] * s->ng[c][i];
            side += light->direction[c][i] * n[c][i];
        }
        const uint32_t below = along < 0 ? ~0u : 0, lifted = below & s->smooth[i] & (side > 0 ? ~0u : 0);
        behind[i] = below & ~lifted;
        const float off = chosen(behind[i], -s->offset[i], s->offset[i]);
        const uint32_t far = light->distance[i] == INFINITY ? ~0u : 0;
        const float distance = chosen(far, 1, light->distance[i]);
        for (int c = 0; c < 3; ++c) {
            const float from = s->p[c][i] + chosen(lifted, s->lift[c][i], 0),
                        start = surface_start(from, off, s->ng[c][i]);
            ray->origin[c][i] = start;
            to[c] = light->direction[c][i] * distance - chosen(far, 0, start - s->p[c][i]);
            square += to[c] * to[c];
        }
        const float length = sqrtf(square), inverse = 1 / length;
        const uint32_t there = length > 0 ? ~0u : 0;
        for (int c = 0; c < 3; ++c)
            ray->direction[c][i] = chosen(there, to[c] * inverse, light->direction[c][i]);
        ray->distance[i] = chosen(far, INFINITY, length);
    }
}

static void weigh(const path_block *path, const emitter_sample *light, const lanes3 f,
                  const float density[LANES], float factor, const uint32_t done[LANES],
                  float (*restrict gain)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        const uint32_t any = (light->density[i] > 0 ? ~0u : 0) & ~done[i];
        const float asked = chosen(any, light->density[i], 1);
        const uint32_t sky = light->part[i] == EMITTER_OUTSIDE ? ~0u : 0;
        const float share = chosen(light->sized[i] & any, path_share(factor * asked, density[i], sky), 1);
        const float scale = chosen(any, share / asked, 0);
        for (int c = 0; c < 3; ++c)
            gain[c][i] =
                limited(path->weight[c][i] * limited(f[c][i] * limited(light->radiance[c][i] * scale)));
    }
}

/* ---- scattered rays ---- */

static void carry(const path_block *path, const shader_sample *to, float (*restrict weight)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) weight[c][i] = limited(path->weight[c][i] * to->weight[c][i]);
    }
}

static inline float larger(float a, float b) { return a > b ? a : b; }

/* The probability to continue is the root of the largest component of the weight, at most 1: the light of a
 * sample varies so much that ending fewer paths pays (bench/path_tracing.md). The fraction of a path that the
 * camera would see says nothing about the light that the path will hit. */
static uint32_t survive(const float u[LANES], const uint32_t safe[LANES], float (*restrict weight)[LANES]) {
    uint32_t bits = 0;
    float chance[LANES];
    for (int i = 0; i < LANES; ++i) {
        const float most = larger(larger(weight[0][i], weight[1][i]), weight[2][i]);
        chance[i] = most < 1 ? sqrtf(most) : 1;
        bits |= most > 0 ? 1u << i : 0;
    }
    if (!u) return bits;
    for (int i = 0; i < LANES; ++i) {
        chance[i] = chosen(safe[i], 1, chance[i]);
        const float divisor = chance[i] > 0 ? chance[i] : 1;
        for (int c = 0; c < 3; ++c) weight[c][i] /= divisor;
    }
    uint32_t stays = 0;
    for (int i = 0; i < LANES; ++i) stays |= u[i] < chance[i] ? 1u << i : 0;
    return bits & stays;
}

static void depart(const surface_block *s, const shader_sample *to, float t_near, trace_rays *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float along = 0, from[3];
        for (int c = 0; c < 3; ++c) along += to->direction[c][i] * s->ng[c][i];
        const uint32_t lifted = ~to->through[i] & (along < 0 ? ~0u : 0);
        const float off = chosen(to->through[i], -s->offset[i], s->offset[i]);
        for (int c = 0; c < 3; ++c)
            from[c] = surface_start(s->p[c][i] + chosen(lifted, s->lift[c][i], 0), off, s->ng[c][i]);
        out->org_x[i] = from[0], out->org_y[i] = from[1], out->org_z[i] = from[2];
        out->dir_x[i] = to->direction[0][i];
        out->dir_y[i] = to->direction[1][i];
        out->dir_z[i] = to->direction[2][i];
        out->t_near[i] = t_near;
        out->t_far[i] = INFINITY;
    }
}

const path_kernels KERNEL(path_kernels) = {
    .aim = aim,
    .weigh = weigh,
    .carry = carry,
    .survive = survive,
    .depart = depart,
};
