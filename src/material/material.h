/* Materials: conversion of parameters to BSDFs, a block of sixteen points at a time. */
#pragma once

#include "scene/scene.h"
#include "surface/surface.h"

/* Features of a material, one bit each: stages that no material needs never run. */
enum {
    MATERIAL_LIT = 1u << 0,     /* k_d or k_s */
    MATERIAL_MIRROR = 1u << 1,  /* k_r */
    MATERIAL_REFRACT = 1u << 2, /* k_t */
    MATERIAL_EMIT = 1u << 3,    /* k_e */
};
unsigned material_features(const fathom_material *m);
/* The material bounds a volume that absorbs light (path tracing). */
bool material_absorbs(const fathom_material *m);

/* The reflection and transmission constants of a material, as kernels read them. */
typedef struct bsdf {
    float k_d[3], k_s[3], k_r[3], k_t[3];
    float emission[3]; /* k_a L_a + k_e: radiance towards the viewer without any light source */
    float shininess, ior;
    uint32_t phong, blinn, fresnel, from_behind; /* all ones or 0 */
} bsdf;

void bsdf_prepare(const fathom_material *m, const float ambient[3], bsdf *out);

/* The BSDFs of a block, one per lane. */
typedef struct bsdf_block {
    _Alignas(64) lanes3 k_d;
    lanes3 k_s, k_r, k_t;
    lanes3 emission;
    float shininess[LANES], ior[LANES];
    uint32_t phong[LANES], blinn[LANES], fresnel[LANES], from_behind[LANES];
} bsdf_block;

/* The BSDFs of a block for light from one direction per lane. */
typedef struct bsdf_value {
    _Alignas(64) lanes3 f;  /* k_d + k_s times the highlight; the reflected radiance is L f cosine */
    float cosine[LANES];    /* |n·l| if the viewer sees the lit side, else 0 */
    uint32_t behind[LANES]; /* all ones: the light is on the viewer's far side */
} bsdf_value;

/* Rays that leave sixteen points, one per point. */
typedef struct scatter_block {
    _Alignas(64) lanes3 origin;
    lanes3 direction; /* unit */
    lanes3 share;     /* fraction of the ray's radiance that reaches the viewer; 0: no ray */
} scatter_block;

typedef struct material_kernels {
    /* The BSDFs of the points, given as at[i]. */
    void (*make)(const bsdf *const at[LANES], bsdf_block *out);

    /* Light from unit directions l. arriving: radiance per lane, 0 if none arrives. Returns false, and
     * leaves f unset, if no lane reflects any light. */
    bool (*evaluate)(const surface_block *s, const bsdf_block *m, const lanes3 l, const float arriving[LANES],
                     bsdf_value *out);

    /* Mirror: r = -v + 2(n·v)n, weight k_r. Refraction by Snell's law with eta = 1/ior on entering and ior
     * on leaving, weight k_t; on total internal reflection the mirrored ray also gets k_t. With `fresnel`,
     * k_r and k_t are multiplied by the unpolarised dielectric reflectance F and by 1 - F; on total internal
     * reflection F is 1, so only k_r remains. If the shading normal would send a ray through the surface, the
     * geometric normal replaces it. */
    void (*scatter)(const surface_block *s, const bsdf_block *m, scatter_block *mirrored,
                    scatter_block *refracted);
} material_kernels;

const material_kernels *material_kernels_best(void);
