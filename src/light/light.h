/* Lights as points see them: direction, distance and arriving radiance. */
#ifndef LIGHT_LIGHT_H
#define LIGHT_LIGHT_H

#include "math/lanes.h"
#include "scene/scene.h"

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
    /* Spot: falloff = clamp((cone_edge - (1 - cos)) cone_scale)^2, as in KHR_lights_punctual, but in terms of
     * 1 - cos, which float holds for the narrowest of cones. */
    float cone_edge, cone_scale;
    const light_surface *surfaces; /* point, spot: those near it */
    uint32_t surface_count;
} shade_light;

/* A spot's falloff in the unit direction from a point to the light: 1 - cos of the angle between unit vectors
 * is half their difference squared. */
static inline float light_falloff(const shade_light *light, float x, float y, float z) {
    x -= light->to_light.x, y -= light->to_light.y, z -= light->to_light.z;
    float t = (light->cone_edge - 0.5f * (x * x + y * y + z * z)) * light->cone_scale;
    t = t < 0 ? 0 : (t > 1 ? 1 : t);
    return t * t;
}

/* origin: the world's, see world.h. Without surfaces. */
void light_prepare(const fathom_light *light, vec3_f64 origin, shade_light *out);

/* A light as sixteen points see it, and the shadow rays towards it. */
typedef struct light_block {
    _Alignas(64) lanes3 origin; /* of the shadow ray */
    lanes3 direction;           /* of the shadow ray, unit */
    float distance[LANES];      /* how far it goes: to the light, or to where the surfaces near the light are
                                   left behind; infinite for directional lights; 0: there is no ray */
    lanes3 radiance;            /* L that arrives if nothing is in the way, before the falloff */
    float falloff[LANES];       /* the share of it that a spot's cone lets through; else 1 */
} light_block;

typedef struct light_kernels {
    /* The light as the points p see it; sets all but `origin`. */
    void (*sample)(const shade_light *light, const lanes3 p, light_block *out);

    /* Sets directions and distances of shadow rays by their origins, clear of the surfaces near the light. */
    void (*aim)(const shade_light *light, light_block *b);
} light_kernels;

const light_kernels *light_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const light_kernels *light_kernels_at(unsigned index);

#endif
