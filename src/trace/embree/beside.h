/* A few spheres of the root, tested next to Embree's trees as planes are.
 *
 * Embree keeps a tree for each kind of geometry, and every ray goes through all of them: ten spheres with
 * callbacks next to a mesh of a million triangles cost all rays 6 to 7 %, met or not, Embree's own spheres
 * 27 % (bench/README.md). Sixteen spheres are held against a block of rays in two of AVX2's vectors, and few
 * blocks come near one. */
#ifndef TRACE_BESIDE_H
#define TRACE_BESIDE_H

#include "trace/trace.h"

#define BESIDE_MOST 16

typedef struct beside_spheres {
    _Alignas(64) float x[BESIDE_MOST], y[BESIDE_MOST], z[BESIDE_MOST], radius[BESIDE_MOST];
    const world_sphere *sphere[BESIDE_MOST];
    uint32_t geometry[BESIDE_MOST], primitive[BESIDE_MOST]; /* the world's */
    unsigned count;
    uint32_t shadows; /* bit k: sphere k casts them */
} beside_spheres;

/* The spheres of the world's root; false: there are none, or more than BESIDE_MOST. */
bool beside_gather(const world *w, beside_spheres *out);

/* Where the line of each lane meets a sphere, in order; `doubt`: lanes that float cannot decide. */
typedef struct beside_roots {
    _Alignas(64) float near[TRACE_WIDTH], far[TRACE_WIDTH];
    uint32_t met, doubt; /* bits, one for each lane */
} beside_roots;

/* kernels/beside_block.c */
typedef struct beside_kernels {
    /* Spheres, as bits, that rays of a whole block may meet before t_far. */
    uint32_t (*close)(const beside_spheres *spheres, const trace_rays *rays);
    void (*roots)(const world_sphere *sphere, const trace_rays *rays, beside_roots *out);
} beside_kernels;
const beside_kernels *beside_kernels_best(void);

#endif
