/* Spheres in Embree's trees: eight neighbouring spheres form one primitive.
 *
 * One callback, one box and one memory fetch serve eight spheres, which SIMD code tests against a ray. A
 * cloud of a million points takes 36 MB. With one primitive per sphere it takes 96 MB and a fifth more
 * rendering time. */
#pragma once

#include "trace/trace.h"

enum { CLUSTER = 8 };

typedef struct sphere_cluster {
    _Alignas(32) float x[CLUSTER], y[CLUSTER], z[CLUSTER], radius[CLUSTER];
    uint32_t primitive[CLUSTER]; /* of the geometry */
    uint32_t lanes;              /* bits: spheres in use */
    uint32_t split;              /* bits: spheres for which world_sphere_is_split() */
} sphere_cluster;

/* The user data of a geometry of spheres. */
typedef struct sphere_clusters {
    sphere_cluster *items;
    const world_sphere *spheres; /* by primitive */
    uint32_t count;
    const struct embree_passing *passing; /* NULL: light passes no sphere straight */
    const struct few_kernels *kernels;
} sphere_clusters;

/* Intersections of a ray's line with each sphere, near <= far; `doubt`: spheres that need more than float. */
typedef struct cluster_roots {
    _Alignas(32) float near[CLUSTER], far[CLUSTER];
    uint32_t met, doubt;
} cluster_roots;

/* Spheres that Embree cannot hold are left out. The order depends only on the spheres. out->items: NULL after
 * a failure; the caller frees it with free(). */
fathom_status clusters_make(fathom_context *context, const world_sphere *spheres, uint32_t count,
                            unsigned threads, sphere_clusters *out);
