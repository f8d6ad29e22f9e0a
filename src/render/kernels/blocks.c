#include "render/kernels.h"

#include "base/kernel.h"

/* ---- camera ---- */

static inline void directions(const shade_camera *camera, uint32_t left, uint32_t top,
                              const square_samples *at, bool alike, trace_rays *restrict out) {
    const shade_camera c = *camera;
    for (uint32_t i = 0; i < LANES; ++i) {
        double x = (double)(int32_t)(left + i % 4) + at->x[alike ? 0 : i];
        double y = (double)(int32_t)(top + i / 4) + at->y[alike ? 0 : i];
        vec3_f32 d = camera_direction(&c, x, y);
        out->dir_x[i] = d.x, out->dir_y[i] = d.y, out->dir_z[i] = d.z;
    }
}

/* Samples that are alike are read as two numbers: sixteen that were stored a moment ago one by one would be
 * waited for. */
static void camera_rays(const shade_camera *camera, float t_near, uint32_t left, uint32_t top,
                        const square_samples *at, trace_rays *restrict out) {
    if (at->alike)
        directions(camera, left, top, at, true, out);
    else
        directions(camera, left, top, at, false, out);
    for (uint32_t i = 0; i < LANES; ++i) {
        out->org_x[i] = camera->eye.x, out->org_y[i] = camera->eye.y, out->org_z[i] = camera->eye.z;
        out->t_near[i] = t_near, out->t_far[i] = INFINITY;
    }
}

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

/* ---- shadows ---- */

/* The ray ends before the light, not behind it: two roundings enter the distance, and one the product. What
 * surfaces near the light need is in the distance already (shade/kernels/light_aim.c). */
static const float before_light = 1 - 4 * 0x1p-24f;

static uint32_t shadow_rays(const light_block *from, float least, float t_near, trace_rays *restrict out) {
    uint32_t bits = 0;
    for (int i = 0; i < LANES; ++i) {
        float gain = from->radiance[0][i] + from->radiance[1][i] + from->radiance[2][i];
        out->org_x[i] = from->origin[0][i], out->dir_x[i] = from->direction[0][i];
        out->org_y[i] = from->origin[1][i], out->dir_y[i] = from->direction[1][i];
        out->org_z[i] = from->origin[2][i], out->dir_z[i] = from->direction[2][i];
        out->t_near[i] = t_near;
        out->t_far[i] = from->distance[i] * before_light;
        bits |= (gain > least) & (from->distance[i] > 0) ? 1u << i : 0;
    }
    return bits;
}

/* Rays of neighbouring pixels, as most blocks hold: nothing is a gain that changes no sum. */
static void add_seen_row(const trace_rays *rays, const float gain[LANES], float *restrict to) {
    for (int i = 0; i < LANES; ++i) to[i] += chosen(rays->t_far[i] < 0 ? ~0u : 0, 0, gain[i]);
}

static void add_seen(const trace_rays *rays, const float gain[3][LANES], const uint32_t slot[LANES],
                     unsigned lanes, float *const radiance[3]) {
    uint32_t apart = lanes == LANES ? 0 : 1;
    for (unsigned i = 0; i < LANES; ++i) apart |= slot[i] ^ (slot[0] + i);
    if (!apart) {
        for (int c = 0; c < 3; ++c) add_seen_row(rays, gain[c], radiance[c] + slot[0]);
        return;
    }
    for (unsigned i = 0; i < lanes; ++i) {
        if (rays->t_far[i] < 0) continue;
        for (int c = 0; c < 3; ++c) radiance[c][slot[i]] += gain[c][i];
    }
}

/* ---- film ---- */

static void add_samples(const float *restrict from, size_t count, double *restrict to) {
    for (size_t i = 0; i < count / LANES * LANES; ++i) to[i] += (double)from[i];
}

static void store_square(const double *restrict sums, double scale, size_t width, float *restrict to) {
    _Alignas(64) float mean[LANES];
    for (int i = 0; i < LANES; ++i) mean[i] = (float)(sums[i] * scale);
    for (size_t row = 0; row < 4; ++row) memcpy(to + row * width, mean + 4 * row, 4 * sizeof *to);
}

const render_kernels KERNEL(render_kernels) = {
    .camera_rays = camera_rays,
    .begin_paths = begin_paths,
    .met = met,
    .shadow_rays = shadow_rays,
    .add_seen = add_seen,
    .add_samples = add_samples,
    .store_square = store_square,
};
