/* What tests of BSDFs share: a point seen under an angle, directions, integrals over the sphere. */
#pragma once

#include "material/shader.h"
#include "random.h"
#include "unit.h"

/* A point of one material, in all lanes. */
typedef struct shading {
    const shader_kernels *kernels;
    surface_block surface;
    shader_block block;
    shader material;
} shading;

static inline void shading_put(lanes3 to, double x, double y, double z) {
    for (int i = 0; i < LANES; ++i) to[0][i] = (float)x, to[1][i] = (float)y, to[2][i] = (float)z;
}

/* The normal is +z, and the viewer in the plane y = 0. */
static inline void shading_open(shading *at, const fathom_material *m, double cosine, bool entering) {
    memset(at, 0, sizeof *at);
    at->kernels = shader_kernels_best();
    at->surface.count = LANES;
    shading_put(at->surface.ng, 0, 0, 1);
    shading_put(at->surface.ns, 0, 0, 1);
    shading_put(at->surface.base, 0, 0, 1);
    shading_put(at->surface.coat, 0.28, 0, 0.96); /* where the material has one */
    at->surface.coated = 0xffff;
    shading_put(at->surface.v, sqrt((1 - cosine) * (1 + cosine)), 0, cosine);
    for (int i = 0; i < LANES; ++i) at->surface.entering[i] = entering ? ~0u : 0;
    shader_prepare(m, &at->material);
    for (int i = 0; i < LANES; ++i) at->block.at[i] = &at->material;
    at->kernels->make(&at->surface, &at->block);
}

/* Gives the surface a tangent. */
static inline void shading_direct(shading *at, double x, double y, double z) {
    shading_put(at->surface.along, x, y, z);
    at->surface.directed = 0xffff;
    at->kernels->make(&at->surface, &at->block);
}

/* Lane 0 of light from one direction. */
static inline double shading_value(const shading *at, const double l[3], double f[3]) {
    lanes3 to, value;
    float density[LANES];
    shading_put(to, l[0], l[1], l[2]);
    at->kernels->evaluate(&at->surface, &at->block, to, value, density);
    for (int c = 0; c < 3; ++c) f[c] = (double)value[c][0];
    return (double)density[0];
}

static inline void shading_numbers(random_state *r, lanes3 u) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            const float x = (float)random_unit(r);
            u[c][i] = x < 1 ? x : 0x1.fffffep-1f;
        }
    }
}
