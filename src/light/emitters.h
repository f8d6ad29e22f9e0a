/* All emitters for path tracing: emissive surfaces, the background, environments, suns (directional lights),
 * and point and spot lights. A light sample chooses one emitter at random. */
#pragma once

#include "light/sky.h"
#include "math/lanes.h"
#include "scene/light_groups.h"
#include "scene/world/world.h"

#include <stdbool.h>

typedef struct emitters emitters;
struct texturing;

/* varied: materials whose emission varies; NULL: none. groups: NULL: light groups are not needed. Both must
 * outlive the emitters. Release with emitters_destroy(). Fails if an environment's image cannot be read or
 * holds a NaN or an infinity; the message names the file and the texel. */
fathom_status emitters_create(fathom_context *context, const world *w, const struct texturing *varied,
                              const light_groups *groups, emitters **out);
void emitters_destroy(emitters *e);

/* True if nothing emits light. */
bool emitters_none(const emitters *e);
/* True if rays that leave the scene may get radiance. */
bool emitters_any_outside(const emitters *e);
/* Suns that have a size. */
uint32_t emitters_sun_count(const emitters *e);

/* Upper bound of the radiance from outside in any direction, per channel. */
void emitters_brightest_outside(const emitters *e, float out[3]);

/* A class of emitters. A light sample chooses one of them by probabilities that depend on the region of the
 * point. */
typedef enum emitter_part {
    EMITTER_FINITE,
    EMITTER_OUTSIDE,
    EMITTER_DIRECTIONAL,
    EMITTER_PARTS
} emitter_part;

/* Query of a light sample, one point per lane. */
typedef struct emitter_query {
    _Alignas(64) lanes3 p; /* in world coordinates */
    lanes3 n; /* shading normal towards the viewer: light from behind is ignored; 0: light from both sides
                 counts */
    float time[LANES]; /* of the shutter, in [0, 1]; read if emitters_move() */
} emitter_query;

/* One direction per lane from which light may come. */
typedef struct emitter_sample {
    _Alignas(64) lanes3 direction; /* unit, towards the light */
    float distance[LANES]; /* a shadow ray of this length ends clear of the emitter by the rounding error of
                              its end; INFINITY: the light is outside the scene */
    lanes3 radiance; /* radiance from this direction if nothing occludes it; for a light without size, the
                        irradiance of a surface that faces the light */
    float density[LANES];  /* density of sampling this direction, including the choice of the light: per solid
                              angle, or for a light without size the probability of its choice. 0: there is no
                              light */
    uint32_t sized[LANES]; /* all ones: BSDF samples can hit the emitter; 0: light samples count alone */
    uint8_t group[LANES];  /* if groups are given, as emitters_outside_group() */
    uint8_t part[LANES];   /* emitter_part */
    uint32_t emitter[LANES]; /* number of the light if part is EMITTER_FINITE and emitters_choose() */
} emitter_sample;

/* True if a random choice among lights is needed. */
bool emitters_choose(const emitters *e);
/* True if there are several surfaces and lamps to choose among. */
bool emitters_choose_finite(const emitters *e);
/* True if some emitter moves while the shutter is open: it is at its position at each query's time. */
bool emitters_move(const emitters *e);
/* u: three numbers in [0,1) per lane; the third chooses the light, and is read if emitters_choose(). */
void emitters_sample(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out);

/* True if some light from outside comes from an image of a sky. */
bool emitters_any_skies(const emitters *e);

/* MIS multiplies the densities of light samples by this factor before it computes weights. */
float emitters_mis_factor(const emitters *e);

/* A hit of a BSDF-sampled ray on an emitter. */
typedef struct emitter_hit {
    uint32_t geometry, primitive, instance; /* as in trace_hits */
    float time;                             /* as in emitter_query */
    bool inside;                            /* the ray leaves the shape */
} emitter_hit;

/* The density with which emitters_sample() chooses the unit direction towards the hit, at the time of the
 * hit, at a point p whose normal is n (0: as in emitter_query). 0: emitters_sample() never chooses it. */
float emitters_hit_density(const emitters *e, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                           const emitter_hit *hit);

/* Radiance from outside the scene, and the density of its direction as above, in the lanes whose bits are
 * set. The density is 0 if light samples leave an even background to scattered rays. */
void emitters_outside(const emitters *e, unsigned lanes, const lanes3 p, const lanes3 n,
                      const lanes3 direction, lanes3 radiance, float density[LANES]);

/* ---- learning ---- */

/* A copy of the emitters for scout paths (path_scout.c), valid as long as e. Most of its light samples go
 * outside: to images of skies, and uniformly over all directions; or to an even background. The others go
 * to surfaces and lamps, and to suns. *out is NULL if there is nothing to learn. Release with free().
 * False: out of memory. */
bool emitters_scout(const emitters *e, emitters **out);

/* A light sample. */
typedef struct emitter_glance {
    float at[6]; /* point and normal, as in emitter_query */
    float direction[3], density;
    float light;            /* that it brings to the viewer, 0 if it does not arrive */
    float seen;             /* fraction that arrives; -1: it would bring nothing anyway */
    uint32_t part, emitter; /* as in emitter_sample */
} emitter_glance;

/* The results of scout paths. */
typedef struct emitter_lesson {
    const emitters *by;  /* the copy */
    const sky_ray *rays; /* light samples from outside */
    size_t ray_count;
    double seen;             /* fraction of these that arrive */
    double outside;          /* fraction of the light that they bring */
    emitter_glance *glances; /* all light samples of some paths; their order is lost */
    size_t glance_count;
} emitter_lesson;
/* From now on, light samples prefer the lights, and the parts of the skies, that are visible from the
 * points. Call at most once. False: out of memory. */
bool emitters_learn(emitters *e, const emitter_lesson *from);

/* The disc of a sun, or the sphere of a lamp, as scattered rays find it; the camera does not see it. */
typedef struct emitter_disc {
    float radiance[3];
    float density;  /* with which emitters_sample() samples each direction to it. 0: it does not sample the
                       disc, or it treats a sun as if it had no size; then only rays of smooth lobes may add
                       the light */
    float distance; /* of the sphere; INFINITY: a sun */
    uint32_t lamp;  /* number of the lamp, for emitters_sphere_density() */
    uint8_t group;
} emitter_disc;
/* For a ray from a point p whose normal is n, as in emitters_hit_density(). False: its unit direction leads
 * past the disc. k: below emitters_sun_count(). */
bool emitters_disc(const emitters *e, uint32_t k, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                   emitter_disc *out);

/* Part of a ray from a point p whose normal is n, as in emitters_hit_density(). */
typedef struct emitter_ray {
    vec3_f32 p, n, direction; /* direction: unit */
    float from, to;           /* distances from p; `to` may be INFINITY */
    bool smooth;              /* of a smooth lobe: it adds the light of all lamps, and no density is set */
} emitter_ray;
/* True if lamps have a radius, so that scattered rays may find them. */
bool emitters_any_spheres(const emitters *e);
/* Calls `found` for each lamp whose light a scattered ray adds because it enters the lamp's sphere on this
 * part, in an order that depends on the lamps alone. */
void emitters_find_spheres(const emitters *e, const emitter_ray *ray,
                           void (*found)(void *user, const emitter_disc *lamp), void *user);

/* The density with which emitters_sample() samples each direction to the sphere of a lamp, at a point p whose
 * normal is n, as in emitters_hit_density(). 0: it treats the lamp as one without size. */
float emitters_sphere_density(const emitters *e, uint32_t lamp, vec3_f32 p, vec3_f32 n);

/* The light group of the light from outside; LIGHT_GROUP_OUTSIDE: there are several, and
 * emitters_outside_shares() gives their fractions for a direction, by group and channel. */
uint8_t emitters_outside_group(const emitters *e);
void emitters_outside_shares(const emitters *e, vec3_f32 direction, float (*shares)[3]);
