/* A few spheres of the root, tested next to Embree's trees as planes are.
 *
 * Embree keeps a tree for each kind of geometry, and every ray goes through all of them: ten spheres with
 * callbacks next to a mesh of a million triangles cost all rays 6 to 7 %, met or not (bench/README.md). Two
 * of AVX2's vectors hold sixteen spheres, which are tested against a whole block of rays; few blocks come
 * near one. */
#ifndef TRACE_EMBREE_SPHERES_H
#define TRACE_EMBREE_SPHERES_H

#include "trace/embree/embree_clusters.h"

#define FEW_SPHERES_MOST 16

typedef struct few_spheres {
    _Alignas(64) float x[FEW_SPHERES_MOST], y[FEW_SPHERES_MOST], z[FEW_SPHERES_MOST],
        radius[FEW_SPHERES_MOST];
    const world_sphere *sphere[FEW_SPHERES_MOST];
    uint32_t geometry[FEW_SPHERES_MOST], primitive[FEW_SPHERES_MOST]; /* the world's */
    unsigned count;
    uint32_t shadows; /* bit k: sphere k casts them */
} few_spheres;

/* The spheres of the world's root; false: there are none, or more than FEW_SPHERES_MOST. */
bool few_gather(const world *w, few_spheres *out);

/* Where the line of each lane meets a sphere, in order; `doubt`: lanes that float cannot decide. */
typedef struct few_roots {
    _Alignas(64) float near[LANES], far[LANES];
    uint32_t met, doubt; /* bits, one for each lane */
} few_roots;

/* kernels/spheres_block.c */
typedef struct few_kernels {
    /* A ray of a packet, its rows `stride` floats apart. Bits of lanes that are not in use mean nothing. */
    void (*cluster)(const sphere_cluster *cluster, const float *ray, size_t stride, cluster_roots *out);
    /* Spheres, as bits, that rays of a whole block may meet before t_far. */
    uint32_t (*close)(const few_spheres *spheres, const trace_rays *rays);
    void (*roots)(const world_sphere *sphere, const trace_rays *rays, few_roots *out);
} few_kernels;
const few_kernels *few_kernels_best(void);

#endif
