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

static void push_camera_ray(wave *w, const wave_region *region, uint32_t x, uint32_t y, uint32_t index) {
    const render_plan *plan = w->plan;
    double dx, dy;
    wave_sample_position(plan, x, y, index, &dx, &dy);
    vec3_f32 d = camera_direction(&plan->camera, x + dx, y + dy);
    size_t block = w->now.count / LANES, lane = w->now.count % LANES;
    trace_rays *rays = &w->now.rays[block].rays;
    path_block *path = &w->now.paths[block];
    rays->org_x[lane] = plan->camera.eye.x;
    rays->org_y[lane] = plan->camera.eye.y;
    rays->org_z[lane] = plan->camera.eye.z;
    rays->dir_x[lane] = d.x;
    rays->dir_y[lane] = d.y;
    rays->dir_z[lane] = d.z;
    rays->t_near[lane] = plan->t_near;
    rays->t_far[lane] = INFINITY;
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = 1;
    path->slot[lane] = (y - region->top) * WAVE_SIDE + x - region->left;
    ++w->now.count;
}

/* A packet of 16 rays is a square of 4 × 4 pixels: its rays stay together longer than those of a line. */
bool wave_camera_rays(wave *w, const wave_region *region, uint32_t index) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    for (uint32_t by = region->top; by < region->y1; by += 4) {
        for (uint32_t bx = region->left; bx < region->x1; bx += 4) {
            for (uint32_t k = 0; k < LANES; ++k) {
                uint32_t x = bx + k % 4, y = by + k / 4;
                if (x < region->x0 || x >= region->x1 || y < region->y0 || y >= region->y1) continue;
                push_camera_ray(w, region, x, y, index);
            }
        }
    }
    w->rays.camera += w->now.count;
    return true;
}
