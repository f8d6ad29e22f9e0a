/* All that sends out light under path tracing: emissive surfaces, the background, environments, suns and
 * lights of a point or a direction. A point asks for one of them, chosen by chance. */
#ifndef LIGHT_EMITTERS_H
#define LIGHT_EMITTERS_H

#include "math/lanes.h"
#include "scene/light_groups.h"
#include "scene/world/world.h"

#include <stdbool.h>

typedef struct emitters emitters;
struct texturing;

/* varied: materials whose emission varies; NULL: none does. groups: NULL: nobody asks for them. Release with
 * emitters_destroy(). Both must outlive them. Fails when an environment's image cannot be read, or holds a
 * NaN or an infinity (the message names the file and the texel). */
fathom_status emitters_create(fathom_context *context, const world *w, const struct texturing *varied,
                              const light_groups *groups, emitters **out);
void emitters_destroy(emitters *e);

/* Nothing sends out any light. */
bool emitters_none(const emitters *e);
/* Rays that leave the scene may meet light. */
bool emitters_any_outside(const emitters *e);
/* Suns that have a size. */
uint32_t emitters_sun_count(const emitters *e);

/* The most that comes from outside in any direction, by channel. */
void emitters_brightest_outside(const emitters *e, float out[3]);

/* Where light is asked for, a point a lane. */
typedef struct emitter_query {
    _Alignas(64) lanes3 p; /* in the world's coordinates */
    lanes3 n; /* shading normal towards the viewer: light from behind counts nothing; 0: it does count */
    float time[LANES]; /* of the shutter, in [0, 1]; read where emitters_move() */
} emitter_query;

/* One direction a lane from which light may come. */
typedef struct emitter_sample {
    _Alignas(64) lanes3 direction; /* unit, towards the light */
    float distance[LANES]; /* a shadow ray of this length ends clear of the emitter by the error bounds of its
                              end; INFINITY: it comes from outside of the scene */
    lanes3 radiance; /* from there when nothing is in the way; for a light without size, the irradiance of
                        a surface that faces it */
    float density[LANES];  /* with which this direction is taken, the choice of the light included: per solid
                              angle, or of a light without size: the chance of its choice. 0: there is no light
                            */
    uint32_t sized[LANES]; /* all ones: a ray can meet the emitter by chance; 0: it has no size */
    uint8_t group[LANES];  /* where groups are asked for, as emitters_outside_group() */
} emitter_sample;

/* True when there is a choice of lights. */
bool emitters_choose(const emitters *e);
/* True when some emitter moves while the shutter is open: it is where it is at the time of each question. */
bool emitters_move(const emitters *e);
/* u: three numbers in [0,1) a lane; the third chooses the light, and is read where emitters_choose(). */
void emitters_sample(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out);

/* MIS multiplies densities of light samples by this before it weighs them. */
float emitters_mis_factor(const emitters *e);

/* A point of an emitter that a ray met by chance. */
typedef struct emitter_hit {
    uint32_t geometry, primitive, instance; /* as in trace_hits */
    float time;                             /* as in emitter_query */
} emitter_hit;

/* The density with which emitters_sample() takes, at the time of the hit and at a point p whose normal is n
 * (0: as in emitter_query), the unit direction towards the hit. 0: it never does. */
float emitters_hit_density(const emitters *e, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                           const emitter_hit *hit);

/* Radiance from outside of the scene, and the density of its direction as above, in the lanes whose bits are
 * set. */
void emitters_outside(const emitters *e, unsigned lanes, const lanes3 n, const lanes3 direction,
                      lanes3 radiance, float density[LANES]);

/* The disc of a sun, as scattered rays find it; the camera does not see it. */
typedef struct emitter_disc {
    float radiance[3];
    float density; /* with which emitters_sample() takes each direction to it; 0: as if it had no size, so
                      that only rays of smooth lobes may add its light */
    uint8_t group;
} emitter_disc;
/* False: the unit direction leads past the disc. k: below emitters_sun_count(). */
bool emitters_disc(const emitters *e, uint32_t k, vec3_f32 direction, emitter_disc *out);

/* The group of what comes from outside; LIGHT_GROUP_OUTSIDE: of several, which emitters_outside_shares()
 * tells for each direction: by group and channel, the share of it. */
uint8_t emitters_outside_group(const emitters *e);
void emitters_outside_shares(const emitters *e, vec3_f32 direction, float (*shares)[3]);

#endif
