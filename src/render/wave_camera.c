#include "math/sampling.h"
#include "render/wave.h"

void wave_sample_position(const render_plan *plan, uint32_t x, uint32_t y, uint32_t index, double *dx,
                          double *dy) {
    switch (plan->settings.pattern) {
    case FATHOM_PATTERN_GRID: sample_grid(plan->grid, index, dx, dy); break;
    case FATHOM_PATTERN_STRATIFIED:
        sample_stratified(plan->grid, index, x, y, plan->settings.seed, dx, dy);
        break;
    case FATHOM_PATTERN_SOBOL: sample_sobol(index, x, y, plan->settings.seed, dx, dy); break;
    }
}

/* Up to 16 pixels and the directions through their samples. */
typedef struct pixel_block {
    uint32_t x[LANES], y[LANES], count;
    _Alignas(64) lanes3 direction;
} pixel_block;

/* The pixels of a 4 × 4 square that are rendered. */
static void gather_pixels(const wave_region *r, uint32_t left, uint32_t top, pixel_block *out) {
    out->count = 0;
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = left + k % 4, y = top + k / 4;
        if (x < r->x0 || x >= r->x1 || y < r->y0 || y >= r->y1) continue;
        out->x[out->count] = x;
        out->y[out->count++] = y;
    }
}

static void aim(const render_plan *plan, uint32_t index, pixel_block *b) {
    const shade_camera c = plan->camera;
    double x[LANES] = {0}, y[LANES] = {0};
    for (uint32_t i = 0; i < b->count; ++i) {
        double dx, dy;
        wave_sample_position(plan, b->x[i], b->y[i], index, &dx, &dy);
        x[i] = b->x[i] + dx;
        y[i] = b->y[i] + dy;
    }
    for (int i = 0; i < LANES; ++i) {
        vec3_f32 d = camera_direction(&c, x[i], y[i]);
        b->direction[0][i] = d.x;
        b->direction[1][i] = d.y;
        b->direction[2][i] = d.z;
    }
}

static void push_pixel(wave *w, const wave_region *r, const pixel_block *b, uint32_t i) {
    const render_plan *plan = w->plan;
    size_t block = w->now.count / LANES, lane = w->now.count % LANES;
    trace_rays *rays = &w->now.rays[block].rays;
    path_block *path = &w->now.paths[block];
    rays->org_x[lane] = plan->camera.eye.x;
    rays->org_y[lane] = plan->camera.eye.y;
    rays->org_z[lane] = plan->camera.eye.z;
    rays->dir_x[lane] = b->direction[0][i];
    rays->dir_y[lane] = b->direction[1][i];
    rays->dir_z[lane] = b->direction[2][i];
    rays->t_near[lane] = plan->t_near;
    rays->t_far[lane] = INFINITY;
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = 1;
    path->slot[lane] = (b->y[i] - r->top) * WAVE_SIDE + b->x[i] - r->left;
    path->depth[lane] = plan->eye_depth;
    ++w->now.count;
}

/* A packet of 16 rays is a square of 4 × 4 pixels: its rays stay together longer than those of a line. */
bool wave_camera_rays(wave *w, const wave_region *region, uint32_t index) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    for (uint32_t top = region->top; top < region->y1; top += 4) {
        for (uint32_t left = region->left; left < region->x1; left += 4) {
            pixel_block block;
            gather_pixels(region, left, top, &block);
            if (!block.count) continue;
            aim(w->plan, index, &block);
            for (uint32_t i = 0; i < block.count; ++i) push_pixel(w, region, &block, i);
        }
    }
    w->rays.camera += w->now.count;
    return true;
}
