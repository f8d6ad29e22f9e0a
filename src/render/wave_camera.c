#include "math/sampling.h"
#include "render/wave.h"

#include <string.h>

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

/* Up to 16 pixels, and what belongs to their samples. */
typedef struct pixel_block {
    uint32_t x[LANES], y[LANES], slot[LANES], count;
    double at_x[LANES], at_y[LANES]; /* image positions */
    _Alignas(64) lanes3 direction;
} pixel_block;

static void add_pixel(const wave_region *r, uint32_t x, uint32_t y, pixel_block *out) {
    uint32_t i = out->count++;
    out->x[i] = x, out->y[i] = y;
    out->slot[i] = (y - r->top) * WAVE_SIDE + x - r->left;
}

/* The pixels of a 4 × 4 square that are rendered. */
static void gather_pixels(const wave_region *r, uint32_t left, uint32_t top, pixel_block *out) {
    out->count = 0;
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = left + k % 4, y = top + k / 4;
        if (x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1) add_pixel(r, x, y, out);
    }
}

static void place_samples(const render_plan *plan, uint32_t index, pixel_block *b) {
    for (uint32_t i = 0; i < LANES; ++i) {
        uint32_t k = i < b->count ? i : 0; /* unused lanes are computed too */
        double dx, dy;
        wave_sample_position(plan, b->x[k], b->y[k], index, &dx, &dy);
        b->at_x[i] = b->x[k] + dx;
        b->at_y[i] = b->y[k] + dy;
    }
}

/* The same for a whole square and the pattern whose cells are the same in every pixel: four columns and four
 * rows. */
static void place_grid(const render_plan *plan, const wave_region *r, uint32_t left, uint32_t top,
                       uint32_t index, pixel_block *b) {
    uint32_t first = (top - r->top) * WAVE_SIDE + left - r->left;
    double dx, dy;
    wave_sample_position(plan, left, top, index, &dx, &dy);
    for (uint32_t row = 0; row < 4; ++row) {
        double y = top + row + dy;
        for (uint32_t column = 0; column < 4; ++column) {
            b->at_x[4 * row + column] = left + column + dx;
            b->at_y[4 * row + column] = y;
            b->slot[4 * row + column] = first + row * WAVE_SIDE + column;
        }
    }
    b->count = LANES;
}

static void place(const render_plan *plan, const wave_region *r, uint32_t left, uint32_t top, uint32_t index,
                  pixel_block *b) {
    bool whole = left >= r->x0 && left + 4 <= r->x1 && top >= r->y0 && top + 4 <= r->y1;
    if (whole && plan->settings.pattern == FATHOM_PATTERN_GRID) {
        place_grid(plan, r, left, top, index, b);
        return;
    }
    gather_pixels(r, left, top, b);
    if (b->count) place_samples(plan, index, b);
}

static void push_pixel(wave *w, const pixel_block *b, uint32_t i) {
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
    path->slot[lane] = b->slot[i];
    path->depth[lane] = plan->eye_depth;
    ++w->now.count;
}

/* The rays of a whole square, where they fill a whole block: all but those at the rims of images. */
static void push_square(wave *w, const pixel_block *b) {
    const render_plan *plan = w->plan;
    const vec3_f32 eye = plan->camera.eye;
    trace_rays *rays = &w->now.rays[w->now.count / LANES].rays;
    path_block *path = &w->now.paths[w->now.count / LANES];
    memcpy(rays->dir_x, b->direction[0], sizeof rays->dir_x);
    memcpy(rays->dir_y, b->direction[1], sizeof rays->dir_y);
    memcpy(rays->dir_z, b->direction[2], sizeof rays->dir_z);
    memcpy(path->slot, b->slot, sizeof path->slot);
    for (int i = 0; i < LANES; ++i) rays->org_x[i] = eye.x, rays->org_y[i] = eye.y, rays->org_z[i] = eye.z;
    for (int i = 0; i < LANES; ++i) rays->t_near[i] = plan->t_near, rays->t_far[i] = INFINITY;
    for (int i = 0; i < LANES; ++i) path->weight[0][i] = path->weight[1][i] = path->weight[2][i] = 1;
    memset(path->depth, plan->eye_depth, sizeof path->depth);
    w->now.count += LANES;
}

static void push_block(wave *w, pixel_block *b) {
    if (!b->count) return;
    w->plan->kernels->camera_directions(&w->plan->camera, b->at_x, b->at_y, b->direction);
    if (b->count == LANES && w->now.count % LANES == 0) {
        push_square(w, b);
    } else {
        for (uint32_t i = 0; i < b->count; ++i) push_pixel(w, b, i);
    }
}

/* A packet of 16 rays is a square of 4 × 4 pixels: its rays stay together longer than those of a line. */
bool wave_camera_rays(wave *w, const wave_region *region, uint32_t index) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    for (uint32_t top = region->top; top < region->y1; top += 4) {
        for (uint32_t left = region->left; left < region->x1; left += 4) {
            pixel_block block;
            place(w->plan, region, left, top, index, &block);
            push_block(w, &block);
        }
    }
    w->rays.camera += w->now.count;
    return true;
}

bool wave_camera_batch(wave *w, const wave_region *region, const wave_batch *batch) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    for (uint32_t at = 0; at < batch->count; ++at) {
        const wave_square *square = &batch->squares[at];
        pixel_block block;
        gather_pixels(region, square->left, square->top, &block);
        for (uint32_t i = 0; i < block.count; ++i)
            block.slot[i] = at * LANES + (block.y[i] - square->top) * 4 + block.x[i] - square->left;
        if (block.count) place_samples(w->plan, square->index, &block);
        push_block(w, &block);
    }
    w->rays.camera += w->now.count;
    return true;
}
