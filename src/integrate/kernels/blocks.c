#include "integrate/kernels.h"
#include "integrate/kernels/kernel.h"
#include "math/limit.h"

static void begin_paths(uint32_t first_slot, uint8_t depth, path_block *restrict out) {
    for (uint32_t i = 0; i < LANES; ++i) {
        out->weight[0][i] = out->weight[1][i] = out->weight[2][i] = 1;
        out->slot[i] = first_slot + i;
    }
    memset(out->depth, depth, sizeof out->depth);
}

/* ---- hits ---- */

static uint32_t met(const trace_hits *hits) {
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) bits |= hits->geometry[i] != FATHOM_NONE ? 1u << i : 0;
    return bits;
}

static uint32_t alike(const uint32_t key[LANES], uint32_t one) {
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) bits |= key[i] == one ? 1u << i : 0;
    return bits;
}

/* ---- shadows ---- */

/* The ray ends before the light, not behind it: two roundings enter the distance, and one the product. The
 * distance already includes the clearance from surfaces near the light (light/kernels/light.c). */
static const float before_light = 1 - 4 * 0x1p-24f;

static uint32_t shadow_rays(const light_block *light, const float gain[3][LANES], float t_near,
                            trace_rays *restrict out) {
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) {
        float sum = gain[0][i] + gain[1][i] + gain[2][i];
        out->org_x[i] = light->origin[0][i], out->dir_x[i] = light->direction[0][i];
        out->org_y[i] = light->origin[1][i], out->dir_y[i] = light->direction[1][i];
        out->org_z[i] = light->origin[2][i], out->dir_z[i] = light->direction[2][i];
        out->t_near[i] = t_near;
        out->t_far[i] = light->distance[i] * before_light;
        bits |= (sum > 0) & (light->distance[i] > 0) ? 1u << i : 0;
    }
    return bits;
}

/* Each product is limited before the next, so that infinity is never multiplied by zero. */
static void gains(const path_block *path, const light_block *light, const bsdf_value *value,
                  float (*restrict gain)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            float arriving = light->radiance[c][i] * (light->falloff[i] * value->cosine[i]);
            float weighed = limited(path->weight[c][i] * arriving);
            gain[c][i] = limited(weighed * value->f[c][i]);
        }
    }
}

/* For blocks of neighbouring pixels, the most frequent case. An occluded lane adds 0, which changes no
 * sum. */
static void add_seen_row(const trace_rays *rays, const float gain[LANES], float *restrict to) {
    for (int i = 0; i < LANES; ++i) to[i] += chosen(rays->t_far[i] < 0 ? ~0u : 0, 0, gain[i]);
}

static void add_seen(const trace_rays *rays, const shadow_block *shadows, unsigned lanes,
                     float *const radiance[3]) {
    const uint32_t *slot = shadows->slot;
    uint32_t apart = lanes == LANES ? 0 : 1;
    for (unsigned i = 0; i < LANES; ++i) apart |= slot[i] ^ (slot[0] + i);
    if (!apart) {
        for (int c = 0; c < 3; ++c) add_seen_row(rays, shadows->gain[c], radiance[c] + slot[0]);
        return;
    }
    for (unsigned i = 0; i < lanes; ++i) {
        if (rays->t_far[i] < 0) continue;
        for (int c = 0; c < 3; ++c) radiance[c][slot[i]] += shadows->gain[c][i];
    }
}

const integrate_kernels KERNEL(integrate_kernels) = {
    .begin_paths = begin_paths,
    .met = met,
    .alike = alike,
    .gains = gains,
    .shadow_rays = shadow_rays,
    .add_seen = add_seen,
    .append = KERNEL(append),
};
