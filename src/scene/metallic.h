/* Metallic-roughness materials as the classic model has them. */
#ifndef SCENE_METALLIC_H
#define SCENE_METALLIC_H

#include <fathom/scene.h>

typedef struct metallic_factors {
    double base[3], cover; /* cover: the part of the surface that is there; light passes the remaining part */
    double metallic, roughness, emissive[3], emissive_strength;
    double ior, transmission, specular, specular_color[3];
    bool unlit; /* sends out its base colour, and reflects nothing */
} metallic_factors;

metallic_factors metallic_factors_of(const fathom_material *material);
void metallic_to_classic(const metallic_factors *factors, fathom_material *out);
/* As the model of path tracing; what the factors leave out has its default. */
void metallic_to_material(const metallic_factors *factors, fathom_material *out);

#endif
