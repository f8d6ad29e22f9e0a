/* What integrators do to a block of sixteen rays at once; see base/kernel.h. */
#ifndef INTEGRATE_KERNELS_H
#define INTEGRATE_KERNELS_H

#include "light/light.h"
#include "material/material.h"
#include "trace/trace.h"

/* Next to each block of rays: what the paths carry. */
typedef struct path_block {
    _Alignas(64) float weight[3][LANES]; /* what radiance along the ray counts in its sample */
    uint32_t slot[LANES];                /* the sample it counts in */
    uint8_t depth[LANES]; /* closed meshes around the ray's origin; see trace/watertight/watertight.h */
} path_block;

/* Next to each block of shadow rays. */
typedef struct shadow_block {
    _Alignas(64) lanes3 gain; /* what the sample gains when nothing is in the way */
    uint32_t slot[LANES];
    uint8_t depth[LANES], end_depth[LANES]; /* closed meshes around the ray's two ends */
    uint8_t sized[LANES];                   /* 1: rays can meet the light by chance */
} shadow_block;

typedef struct integrate_kernels {
    /* Paths of weight 1 that begin in neighbouring slots. */
    void (*begin_paths)(uint32_t first_slot, uint8_t depth, path_block *out);

    /* The lanes, as bits, that met something. */
    uint32_t (*met)(const trace_hits *hits);

    /* The lanes, as bits, of this key. */
    uint32_t (*alike)(const uint32_t key[LANES], uint32_t one);

    /* What samples gain from a light: weight L f cosine. */
    void (*gains)(const path_block *path, const light_block *light, const bsdf_value *value,
                  float (*gain)[LANES]);

    /* Rays to a light, and the lanes, as bits, that have something to gain from seeing it. */
    uint32_t (*shadow_rays)(const light_block *light, const float gain[3][LANES], float t_near,
                            trace_rays *out);

    /* Adds the gains of the first `lanes` rays that reached their light. */
    void (*add_seen)(const trace_rays *rays, const shadow_block *shadows, unsigned lanes,
                     float *const radiance[3]);

    /* Rows of sixteen numbers of 4 bytes each: those of `lanes`, as bits, go in order to the places from `at`
     * on, where there is room for them. `to` may be `from` if at is 0. */
    void (*append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at);
} integrate_kernels;

/* Rows to append of trace_rays, of path_block or shadow_block, and of trace_hits from `primitive` on. */
enum { ROWS_OF_RAYS = 9, ROWS_OF_PATHS = 4, ROWS_OF_IDS = 3, ROWS_OF_NORMALS = 3 };

const integrate_kernels *integrate_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const integrate_kernels *integrate_kernels_at(unsigned index);

#endif
