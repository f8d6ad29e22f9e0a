/* Operations of integrators on a block of sixteen rays; see base/kernel.h. */
#pragma once

#include "light/light.h"
#include "material/material.h"
#include "trace/trace.h"

/* State of the paths of a block of rays. */
typedef struct path_block {
    _Alignas(64) float weight[3][LANES]; /* factor of the ray's radiance in its sample */
    uint32_t slot[LANES];                /* the sample to which it contributes */
    uint8_t depth[LANES]; /* closed meshes around the origin; see trace/watertight/watertight.h */
} path_block;

/* State of a block of shadow rays. */
typedef struct shadow_block {
    _Alignas(64) lanes3 gain; /* light that the sample gets if nothing occludes the ray */
    uint32_t slot[LANES];
    uint8_t depth[LANES], end_depth[LANES]; /* number of closed meshes around the ray's two ends */
    uint8_t sized[LANES];                   /* 1: other rays can hit the light */
} shadow_block;

typedef struct integrate_kernels {
    /* Paths of weight 1 that begin in neighbouring slots. */
    void (*begin_paths)(uint32_t first_slot, uint8_t depth, path_block *out);

    /* Returns bits: lanes with a hit. */
    uint32_t (*met)(const trace_hits *hits);

    /* Returns bits: lanes with this key. */
    uint32_t (*alike)(const uint32_t key[LANES], uint32_t one);

    /* The contribution of a light to the samples: weight L f cosine. */
    void (*gains)(const path_block *path, const light_block *light, const bsdf_value *value,
                  float (*gain)[LANES]);

    /* Makes rays to a light. Returns bits: lanes with a gain above 0. */
    uint32_t (*shadow_rays)(const light_block *light, const float gain[3][LANES], float t_near,
                            trace_rays *out);

    /* Adds the gains of the unoccluded rays among the first `lanes`. */
    void (*add_seen)(const trace_rays *rays, const shadow_block *shadows, unsigned lanes,
                     float *const radiance[3]);

    /* Rows of sixteen numbers of 4 bytes each: copies the lanes given as bits, in order, to the positions
     * from `at` on, where there must be room for them. `to` may be `from` if at is 0. */
    void (*append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at);
} integrate_kernels;

/* Numbers of rows to append: of trace_rays, of path_block or shadow_block, of trace_hits from `primitive` on,
 * and of normals. */
enum { ROWS_OF_RAYS = 9, ROWS_OF_PATHS = 4, ROWS_OF_IDS = 3, ROWS_OF_NORMALS = 3 };

const integrate_kernels *integrate_kernels_best(void);
