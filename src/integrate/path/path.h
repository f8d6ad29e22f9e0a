/* The state of a wave of path tracing, and the functions shared by its files. */
#pragma once

#include "integrate/media.h"
#include "integrate/wave/wave.h"
#include "math/lane.h"
#include "math/rgb.h"

typedef struct path_scout path_scout;

typedef struct path_wave {
    wave wave; /* must be first: the integrator's interface points to it */
    uint32_t depth;
    bool ends;                  /* vertices at this depth continue no paths and take no light samples */
    bool looked_through;        /* some ray of the batch has passed the back of a one-sided surface */
    bool lit;                   /* there are lights to sample */
    bool shows_lamps;           /* scattered rays may find lamps with a radius */
    float light_factor;         /* emitters_mis_factor() */
    uint64_t pixel[WAVE_SLOTS]; /* pixel hash of the sample's key; see sample_pixel_hash() */
    uint32_t index[WAVE_SLOTS];
    /* The vertex that the ray left, from which lights were sampled, and the density of the ray's direction.
     * The density is infinite for camera rays and smooth lobes. */
    float p[3][WAVE_SLOTS], n[3][WAVE_SLOTS], density[WAVE_SLOTS];
    /* The cone around the ray where it left that vertex: its width there, and its angle. */
    float width[WAVE_SLOTS], spread[WAVE_SLOTS];
    /* Number of surfaces that the ray passed straight through, and the distance from the vertex to the last
     * of them. */
    uint32_t passes[WAVE_SLOTS];
    bool paned[WAVE_SLOTS]; /* one of them is a clear thin wall */
    float passed[WAVE_SLOTS];
    /* Only if first hits are kept: whether the path has hit only smooth surfaces so far, and their product of
     * colours. */
    bool smooth[WAVE_SLOTS];
    float tint[3][WAVE_SLOTS];
    media *media;                /* NULL: no volume absorbs light or has a priority */
    uint8_t channel[WAVE_SLOTS]; /* the one channel that the path carries, from 1; 0: all three */
    shader hidden; /* of surfaces inside a volume of a higher priority, and of backs that the camera does not
                      see */
    /* Only with caustics: the density of the path as a chain, see caustic_chain(). 0: photons do not find it,
     * or it is none. */
    float chain[WAVE_SLOTS];
    struct photon_wave *photons; /* set for paths of photons; else NULL */
    path_scout *scout;           /* set for scout paths, which record what light samples see; else NULL */
} path_wave;

static inline vec3_f32 of_slot(const float from[3][WAVE_SLOTS], uint32_t slot) {
    return (vec3_f32){from[0][slot], from[1][slot], from[2][slot]};
}

/* How often the path was scattered before its current vertex. */
static inline uint32_t path_scattered(const path_wave *p, uint32_t slot) {
    return p->depth - p->passes[slot];
}

/* The camera sees what the path hits next: it has passed nothing but holes. */
static inline bool path_in_view(const path_wave *p, uint32_t slot) {
    return !path_scattered(p, slot) && !p->paned[slot];
}

static inline bool path_sends_light(const shader *s) { return rgb_any(s->emission); }

/* ---- path.c ---- */

/* Release with path_wave_destroy(). NULL: out of memory. */
path_wave *path_wave_create(const render_plan *plan, const atomic_bool *stop, const wave_stages *stages);
void path_wave_destroy(path_wave *p);

/* The samples that the vertices of a block belong to. */
typedef struct vertex_keys {
    uint64_t pixel[LANES];
    uint32_t index[LANES];
} vertex_keys;
void path_find_keys(const path_wave *p, const vertex_block *v, vertex_keys *out);
/* Two random numbers for each vertex, and a third one if there is a choice; else it is 0. */
void path_numbers(const path_wave *p, const vertex_keys *keys, sample_purpose purpose, bool choice, lanes3 u);
/* Sets the shaders at the points. width: of the cones there; NULL: those of the paths. */
void path_find_shaders(path_wave *p, vertex_block *v, const float *width);
/* Where channels separate, only one continues. */
void path_part_paths(path_wave *p, const vertex_block *v, const shader_sample *to, lanes3 weight);
/* Appends scattered rays to `next`. lanes: bits of the lanes that continue. */
void path_push_lanes(path_wave *p, const vertex_block *v, const shader_sample *to, path_block *path,
                     uint32_t lanes);

/* ---- path_scout.c ---- */

/* Keeps the light samples of the vertices; gain: the light if nothing hides it. */
void path_scout_asks(path_scout *s, const vertex_block *v, const emitter_query *from,
                     const emitter_sample *light, const lanes3 gain);
/* Before and after the shadow rays of a step: notes how much of the light arrives. */
void path_scout_waits(path_scout *s, const wave *w);
void path_scout_sees(path_scout *s, const wave *w);

/* ---- path_begin.c ---- */

/* Sets the state of the paths of a batch's samples. */
void path_begin(path_wave *p, const wave_batch *batch);
/* Completes it once `now` holds the camera's rays. */
void path_begin_rays(path_wave *p);

/* ---- path_met.c ---- */

/* Adds the lamps with a radius that the rays of `now` meet before their hits. */
void path_add_lamps(path_wave *p);
/* Adds light from outside the scene, for lanes that hit nothing. */
void path_add_outside(wave *w, const trace_block *block, const path_block *path, uint32_t missed);
/* Adds the emission of the surface that lane i hit; see path_sends_light(). */
void path_add_emission(path_wave *p, const vertex_block *v, unsigned i, const shader *s);

/* The features for denoisers, if requested, after the first vertex and on the way from it. to: where the
 * paths go, because those that pass a hole do not show its surface; NULL: they all end. */
void path_show_features(path_wave *p, const vertex_block *v, const shader_sample *to);
void path_leave_features(path_wave *p, const shader_sample *to, unsigned i, uint32_t slot);
/* z of the first hits along the viewing direction of a moving camera. */
void path_show_depths(path_wave *p, const vertex_block *v);

/* ---- path_volumes.c ---- */

/* Absorbs light on the segments to the vertices. */
void path_absorb(path_wave *p, vertex_block *v);
/* Returns bits: lanes whose surfaces are hidden in another volume. around: the indices around the others. */
uint32_t path_meet_volumes(const path_wave *p, const vertex_block *v, float around[LANES]);
/* Gives these lanes the shaders that apply inside the surrounding volumes. */
void path_hide_surfaces(path_wave *p, vertex_block *v, const float around[LANES], uint32_t hidden);
/* The camera looks through the backs of one-sided surfaces. */
void path_hide_backs(path_wave *p, vertex_block *v);
/* Consecutive samples of a pixel take the channels in turn; the first channel is random per pixel. */
void path_choose_channels(const path_wave *p, vertex_block *v);
/* At a dispersive surface, keeps one channel of rgb, multiplied by three. crosses: the ray crosses the
 * surface. Returns true if the path carries only that channel from there on. */
bool path_part_channels(const path_wave *p, const vertex_block *v, unsigned i, bool crosses, float rgb[3]);
/* The same two operations for light samples. */
void path_dim_lights(const path_wave *p, const vertex_block *v, const light_block *ray,
                     const uint32_t behind[LANES], lanes3 gain);
void path_part_lights(const path_wave *p, const vertex_block *v, const uint32_t behind[LANES], lanes3 gain);
