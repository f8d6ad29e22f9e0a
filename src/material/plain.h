/* Plain materials of sixteen points, whose shaders are prepared together: metallic-roughness with
 * `multiscatter`, opaque, without transmission, clear coat, sheen, anisotropy, film and diffuse
 * transmission. */
#pragma once

#include "material/shader.h"

typedef struct plain_block {
    uint32_t lanes; /* bits */
    _Alignas(64) lanes3 base_color;
    lanes3 specular_color;
    float metallic[LANES], alpha[LANES], ior[LANES], specular[LANES];
    float mean[LANES], mean_edge[LANES]; /* mean albedos of the facets */
} plain_block;

/* Members of `shader`; if the lobe is a mirror, f0 and f90 are its mirror0 and mirror90. */
typedef struct plain_shaders {
    _Alignas(64) lanes3 diffuse, albedo, f0, again;
    float f90[LANES], layer0[LANES], layer_again[LANES], mean_under[LANES], missing_share[LANES];
    uint32_t lobes[LANES];
} plain_shaders;

typedef struct plain_kernels {
    void (*prepare)(const plain_block *b, plain_shaders *out);
} plain_kernels;
const plain_kernels *plain_kernels_best(void);

/* Adds a material as lane i of a block, which must be zeroed before the first lane. False: the material is
 * not plain. */
bool plain_add(plain_block *b, unsigned i, const fathom_material *material, shader *out);
/* Fills in the shaders of the lanes that were added. */
void plain_finish(const plain_block *b, const plain_kernels *kernels, shader made[LANES]);
