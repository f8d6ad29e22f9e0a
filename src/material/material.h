/* Materials: from parameters to BSDFs, a block of sixteen points at a time. */
#ifndef MATERIAL_MATERIAL_H
#define MATERIAL_MATERIAL_H

#include "scene/scene.h"
#include "surface/surface.h"

/* What a material can do at all, a bit each: stages that no material needs are never run. */
enum {
    MATERIAL_LIT = 1u << 0,     /* k_d or k_s */
    MATERIAL_MIRROR = 1u << 1,  /* k_r */
    MATERIAL_REFRACT = 1u << 2, /* k_t */
    MATERIAL_EMIT = 1u << 3,    /* k_e */
};
unsigned material_features(const fathom_material *m);
/* It bounds a volume that absorbs light; path tracing. */
bool material_absorbs(const fathom_material *m);

/* What a material does with light, as kernels read it. */
typedef struct bsdf {
    float k_d[3], k_s[3], k_r[3], k_t[3];
    float emission[3]; /* k_a L_a + k_e: what a point sends to the viewer without any light */
    float shininess, ior;
    uint32_t phong, blinn, fresnel, from_behind; /* all ones or 0 */
} bsdf;

void bsdf_prepare(const fathom_material *m, const float ambient[3], bsdf *out);

/* The BSDFs of a block, lane by lane. */
typedef struct bsdf_block {
    _Alignas(64) lanes3 k_d;
    lanes3 k_s, k_r, k_t;
    lanes3 emission;
    float shininess[LANES], ior[LANES];
    uint32_t phong[LANES], blinn[LANES], fresnel[LANES], from_behind[LANES];
} bsdf_block;

/* What a block does with light from one direction a lane. */
typedef struct bsdf_value {
    _Alignas(64) lanes3 f;  /* k_d + k_s times the highlight: what is reflected is L f cosine */
    float cosine[LANES];    /* |n·l| where the side that it lights is seen, else 0 */
    uint32_t behind[LANES]; /* all ones: the light is on the viewer's far side */
} bsdf_value;

/* Rays that leave sixteen points, one each. */
typedef struct scatter_block {
    _Alignas(64) lanes3 origin;
    lanes3 direction; /* unit */
    lanes3 share;     /* of the radiance along the ray, what the point sends on to the viewer; 0: no ray */
} scatter_block;

typedef struct material_kernels {
    /* The BSDFs of the points, which are at[i]. */
    void (*make)(const bsdf *const at[LANES], bsdf_block *out);

    /* Light from unit directions l. arriving: of each lane, 0 where none does; false, and f not set, where no
     * lane reflects any. */
    bool (*evaluate)(const surface_block *s, const bsdf_block *m, const lanes3 l, const float arriving[LANES],
                     bsdf_value *out);

    /* Mirror: r = -v + 2(n·v)n, share k_r. Refraction by Snell's law with eta = 1/ior on entering and ior on
     * leaving, share k_t; on total internal reflection the mirrored ray gets k_t as well. With `fresnel`, k_r
     * and k_t are scaled by the unpolarised dielectric reflectance F and 1 - F; on total internal reflection
     * F is 1, so k_r alone is left. Where a shading normal would send a ray through the surface, the
     * geometric normal replaces it. */
    void (*scatter)(const surface_block *s, const bsdf_block *m, scatter_block *mirrored,
                    scatter_block *refracted);
} material_kernels;

const material_kernels *material_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const material_kernels *material_kernels_at(unsigned index);

#endif
