/* A few spheres of the root group, tested outside Embree's trees, as planes are.
 *
 * Embree keeps one tree per kind of geometry, and every ray traverses all of them. Ten spheres with callbacks
 * next to a mesh of a million triangles therefore cost every ray 6 to 7 %, whether it hits them or not
 * (bench/README.md). Here sixteen spheres fit in two AVX2 vectors. They are tested against a whole block of
 * rays; few blocks come near one. */
#pragma once

#include "trace/embree/embree_clusters.h"

#define FEW_SPHERES_MOST 16

typedef struct few_spheres {
    _Alignas(64) float x[FEW_SPHERES_MOST], y[FEW_SPHERES_MOST], z[FEW_SPHERES_MOST],
        radius[FEW_SPHERES_MOST];
    const world_sphere *sphere[FEW_SPHERES_MOST];
    uint32_t geometry[FEW_SPHERES_MOST], primitive[FEW_SPHERES_MOST]; /* the world's */
    unsigned count;
    uint32_t shadows; /* bit k: sphere k casts shadows */
} few_spheres;

/* Collects the spheres of the world's root group. False: none, or more than FEW_SPHERES_MOST. */
bool few_gather(const world *w, few_spheres *out);

/* Intersections of each lane's line with a sphere, near <= far; `doubt`: lanes that need more than float. */
typedef struct few_roots {
    _Alignas(64) float near[LANES], far[LANES];
    uint32_t met, doubt; /* bits, one for each lane */
} few_roots;

/* kernels/spheres_block.c */
typedef struct few_kernels {
    /* Intersects one ray of a packet, whose rows are `stride` floats apart. Output bits of unused lanes are
     * undefined. */
    void (*cluster)(const sphere_cluster *cluster, const float *ray, size_t stride, cluster_roots *out);
    /* Returns a bit for each sphere that some ray of the block may hit before t_far. */
    uint32_t (*close)(const few_spheres *spheres, const trace_rays *rays);
    void (*roots)(const world_sphere *sphere, const trace_rays *rays, few_roots *out);
} few_kernels;
const few_kernels *few_kernels_best(void);
