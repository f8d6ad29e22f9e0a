/* Lights: direction, distance and radiance at a point, and what of it the surface sends to the viewer. */
#ifndef SHADE_LIGHT_H
#define SHADE_LIGHT_H

#include "scene/scene.h"
#include "shade/surface.h"

/* A surface that holds a light, or is so near that roundings could take a shadow ray's end to its other side:
 * it is the same for the end of a ray as the surface that a ray leaves is for its start. */
typedef struct light_surface {
    vec3_f32 normal; /* unit */
    float above;     /* the light's distance, positive on the normal's side; 0: the surface holds the light */
    float clear, slope; /* a ray of length D must end at least clear + slope D off the surface */
} light_surface;

/* A light in the world's float coordinates. */
typedef struct shade_light {
    fathom_light_type type;
    vec3_f32 position;
    vec3_f32 to_light; /* directional: unit, towards the light; spot: unit, against the cone's axis */
    float intensity[3];
    /* Spot: falloff = clamp((cone_edge - (1 - cos)) cone_scale)^2. That is KHR_lights_punctual's, written in
     * 1 - cos, which float holds for the narrowest of cones. */
    float cone_edge, cone_scale;
    const light_surface *surfaces; /* point, spot: those near it */
    uint32_t surface_count;
} shade_light;

/* origin: the world's, see world.h. Without surfaces. */
void light_prepare(const fathom_light *light, vec3_f64 origin, shade_light *out);

/* What arrives from one light at sixteen points, were nothing in the way. */
typedef struct light_block {
    _Alignas(64) lanes3 origin; /* of the shadow ray */
    lanes3 direction;           /* of the shadow ray, unit */
    float distance[LANES];      /* how far it goes: to the light, or to where the surfaces near the light are
                                   left behind; infinite for directional lights; 0: there is no ray */
    lanes3 radiance; /* weight L (rho_d + rho_s) |n·l|: what the sample gains when the light is seen */
} light_block;

#endif
