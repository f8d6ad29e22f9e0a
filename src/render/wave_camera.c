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

/* A square of 4 × 4 pixels, one sample each. */
typedef struct square {
    uint32_t left, top, index;
    uint32_t first; /* slot of its first pixel */
} square;

/* The pixels of the square, as bits, that are rendered. */
static uint32_t pixels_in(const wave_region *r, uint32_t left, uint32_t top) {
    uint32_t bits = 0;
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = left + k % 4, y = top + k / 4;
        bits |= x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1 ? 1u << k : 0;
    }
    return bits;
}

static bool is_whole(const wave_region *r, const square *s) {
    return s->left >= r->x0 && s->left + 4 <= r->x1 && s->top >= r->y0 && s->top + 4 <= r->y1;
}

static bool is_grid(const render_plan *plan) { return plan->settings.pattern == FATHOM_PATTERN_GRID; }

static void place(const render_plan *plan, const square *s, square_samples *out) {
    for (uint32_t k = 0; k < LANES; ++k)
        wave_sample_position(plan, s->left + k % 4, s->top + k / 4, s->index, &out->x[k], &out->y[k]);
}

static void camera_rays(const render_plan *plan, const square *s, const square_samples *at, trace_rays *out) {
    plan->blocks->camera_rays(&plan->camera, plan->t_near, s->left, s->top, at, out);
}

/* A packet of 16 rays is a square: its rays stay together longer than those of a line. */
static void push_whole(wave *w, const square *s, const square_samples *at) {
    camera_rays(w->plan, s, at, &w->now.rays[w->now.count / LANES].rays);
    w->plan->blocks->begin_paths(s->first, w->plan->eye_depth, &w->now.paths[w->now.count / LANES]);
    w->now.count += LANES;
}

static void push_pixel(wave *w, const square *s, const trace_rays *from, uint32_t i) {
    size_t lane = w->now.count % LANES;
    path_block *path = &w->now.paths[w->now.count / LANES];
    trace_rays_move(from, i, &w->now.rays[w->now.count / LANES].rays, lane);
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = 1;
    path->slot[lane] = s->first + i;
    path->depth[lane] = w->plan->eye_depth;
    ++w->now.count;
}

static void push_partial(wave *w, const wave_region *region, const square *s, const square_samples *at) {
    trace_rays rays;
    camera_rays(w->plan, s, at, &rays);
    for (uint32_t left = pixels_in(region, s->left, s->top); left; left &= left - 1)
        push_pixel(w, s, &rays, (uint32_t)__builtin_ctz(left));
}

static void push_squares(wave *w, const wave_region *region, const square *squares, uint32_t count,
                         bool whole) {
    const render_plan *plan = w->plan;
    square_samples at;
    uint32_t placed = UINT32_MAX;
    for (uint32_t i = 0; i < count; ++i) {
        const square *s = &squares[i];
        if (is_whole(region, s) != whole) continue;
        /* In a grid, samples of one index lie in the same place of all pixels. */
        if (!is_grid(plan) || s->index != placed) place(plan, s, &at);
        placed = s->index;
        if (whole)
            push_whole(w, s, &at);
        else
            push_partial(w, region, s, &at);
    }
}

/* Squares at the rims of images follow the whole ones, which fill whole blocks. */
static bool push_all(wave *w, const wave_region *region, const square *squares, uint32_t count) {
    w->now.count = 0;
    if (!wave_reserve_paths(w, &w->now, WAVE_SLOTS)) return false;
    push_squares(w, region, squares, count, true);
    push_squares(w, region, squares, count, false);
    w->rays.camera += w->now.count;
    return true;
}

bool wave_camera_rays(wave *w, const wave_region *region, uint32_t index) {
    square squares[WAVE_SQUARES];
    uint32_t count = 0;
    for (uint32_t y = 0; y < WAVE_SIDE; y += 4) {
        for (uint32_t x = 0; x < WAVE_SIDE; x += 4) {
            square s = {region->left + x, region->top + y, index, wave_slot(x, y)};
            if (s.left < region->x1 && s.top < region->y1) squares[count++] = s;
        }
    }
    return push_all(w, region, squares, count);
}

bool wave_camera_batch(wave *w, const wave_region *region, const wave_batch *batch) {
    square squares[WAVE_SQUARES];
    for (uint32_t i = 0; i < batch->count; ++i) {
        const wave_square *from = &batch->squares[i];
        squares[i] = (square){from->left, from->top, from->index, i * LANES};
    }
    return push_all(w, region, squares, batch->count);
}
