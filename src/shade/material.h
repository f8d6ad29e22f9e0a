/* Materials: what they need, and their reflectance. */
#ifndef SHADE_MATERIAL_H
#define SHADE_MATERIAL_H

#include "scene/scene.h"
#include "shade/surface.h"

/* What a material can do at all, a bit each: stages that no material needs are never run. */
enum {
    MATERIAL_LIT = 1u << 0,     /* k_d or k_s */
    MATERIAL_MIRROR = 1u << 1,  /* k_r */
    MATERIAL_REFRACT = 1u << 2, /* k_t */
    MATERIAL_EMIT = 1u << 3,    /* k_e */
};
unsigned material_features(const fathom_material *m);

/* Adds weight (k_a L_a + k_e) of each point to its sample in radiance[3][slots]. */
void material_add_constant(const material_block *m, const surface_block *s, const float ambient[3],
                           float *const radiance[3]);

#endif
