/* Lights evaluated at points: direction, distance and arriving radiance. */
#pragma once

#include "math/lanes.h"
#include "scene/scene.h"
#include "scene/world/world.h"

/* A surface that holds a light, or is so near that rounding could move a shadow ray's end to its other side.
 * Shadow rays must end clear of it, as they start clear of the surface that they leave. */
typedef struct light_surface {
    vec3_f32 normal; /* unit */
    float above; /* the light's distance from the surface, positive on the normal's side; 0: the surface holds
                    the light */
    float clear, slope; /* a ray of length D must end at least clear + slope D away from the surface */
} light_surface;

/* A light in float world coordinates. */
typedef struct shade_light {
    fathom_light_type type;
    vec3_f32 position;
    vec3_f32 to_light; /* directional: unit, towards the light; spot: unit, against the cone's axis */
    float intensity[3];
    /* Spot: falloff = clamp((cone_edge - (1 - cos)) cone_scale)^2, as in KHR_lights_punctual, but in terms of
     * 1 - cos, which float represents accurately even for the narrowest cones. */
    float cone_edge, cone_scale;
    const light_surface *surfaces; /* point, spot: surfaces near the light */
    uint32_t surface_count;
} shade_light;

/* A spot's falloff for the unit direction from a point to the light. 1 - cos of the angle between unit
 * vectors is half their squared difference. */
static inline float light_falloff(const shade_light *light, float x, float y, float z) {
    x -= light->to_light.x, y -= light->to_light.y, z -= light->to_light.z;
    float t = (light->cone_edge - 0.5f * (x * x + y * y + z * z)) * light->cone_scale;
    t = t < 0 ? 0 : (t > 1 ? 1 : t);
    return t * t;
}

/* origin: the world's origin, see world.h. Does not set the surfaces. */
void light_prepare(const fathom_light *light, vec3_f64 origin, shade_light *out);

/* A light evaluated at sixteen points, and the shadow rays towards it. */
typedef struct light_block {
    _Alignas(64) lanes3 origin; /* of the shadow ray */
    lanes3 direction;           /* of the shadow ray, unit */
    float distance[LANES]; /* its length: to the light, or until it is clear of the surfaces near the light;
                              infinite for directional lights; 0: there is no ray */
    lanes3 radiance;       /* arriving L if nothing occludes the light, before the falloff */
    float falloff[LANES];  /* the fraction that a spot's cone transmits; else 1 */
} light_block;

typedef struct light_kernels {
    /* Evaluates the light at the points p; sets all but `origin`. */
    void (*sample)(const shade_light *light, const lanes3 p, light_block *out);

    /* Sets directions and distances of shadow rays from their origins, so that they end clear of the surfaces
     * near the light. */
    void (*aim)(const shade_light *light, light_block *b);
} light_kernels;

const light_kernels *light_kernels_best(void);

/* Maximum number of surfaces per light; the nearest are kept. At worst, twenty triangles meet in a vertex of
 * a fine mesh. */
#define LIGHT_SURFACES_MOST 32

/* Finds the surfaces that hold a light or are very close to it: light/kernels/light.c ends shadow rays clear
 * of them. Sets surfaces and surface_count of the lights; they stay valid until the caller frees *out, which
 * is NULL if there are none. eye: the camera's position in world space. in_mesh, a flag per light: set if a
 * mesh holds the light. */
fathom_status light_surfaces_find(fathom_context *context, const world *w, vec3_f32 eye, shade_light *lights,
                                  uint32_t count, bool *in_mesh, light_surface **out);
