/* What the stages do to a block of sixteen rays at once; see base/kernel.h. */
#ifndef RENDER_KERNELS_H
#define RENDER_KERNELS_H

#include "shade/kernels.h"
#include "trace/trace.h"

/* Beside each block of rays: what the paths carry. */
typedef struct path_block {
    _Alignas(64) float weight[3][LANES];
    uint32_t slot[LANES];
    uint8_t depth[LANES]; /* closed meshes around the ray's origin; see trace/watertight/watertight.h */
} path_block;

/* Where in their pixels the samples of a square of 4 × 4 lie, row by row: [0,1) from the top left. */
typedef struct square_samples {
    _Alignas(64) double x[LANES], y[LANES];
    bool alike; /* in the same place of all: the first says it, and the rest is not read */
} square_samples;

typedef struct render_kernels {
    /* Rays through a square of pixels, whose first is (left, top), towards t = infinity. */
    void (*camera_rays)(const shade_camera *camera, float t_near, uint32_t left, uint32_t top,
                        const square_samples *at, trace_rays *out);
    /* Paths of weight 1 that begin in neighbouring slots. */
    void (*begin_paths)(uint32_t first_slot, uint8_t depth, path_block *out);

    /* The lanes, as bits, that met something. */
    uint32_t (*met)(const trace_hits *hits);

    /* Rays to a light, and the lanes, as bits, that have more than `least` to gain from seeing it. */
    uint32_t (*shadow_rays)(const light_block *from, float least, float t_near, trace_rays *out);

    /* Adds the gains of the first `lanes` rays that reached their light. */
    void (*add_seen)(const trace_rays *rays, const float gain[3][LANES], const uint32_t slot[LANES],
                     unsigned lanes, float *const radiance[3]);

    /* to[i] += from[i]; count is a multiple of 16. */
    void (*add_samples)(const float *from, size_t count, double *to);

    /* A square of 4 × 4 sums, scaled, to an image of this width. */
    void (*store_square)(const double *sums, double scale, size_t width, float *to);
} render_kernels;

const render_kernels *render_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const render_kernels *render_kernels_at(unsigned index);

#endif
