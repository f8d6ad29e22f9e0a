/* The state of a wave of path tracing, and the functions that its files share. */
#ifndef INTEGRATE_PATH_H
#define INTEGRATE_PATH_H

#include "integrate/media.h"
#include "integrate/wave.h"
#include "math/lane.h"

typedef struct path_wave {
    wave wave; /* first: the integrator's interface points to it */
    uint32_t depth;
    bool ends;                  /* vertices at this depth send no rays */
    bool lit;                   /* there are lights to ask */
    float light_factor;         /* emitters_mis_factor() */
    uint64_t pixel[WAVE_SLOTS]; /* of the sample's key; see sample_pixel_hash() */
    uint32_t index[WAVE_SLOTS];
    /* The vertex that the ray left: where lights were asked for, and the density of the ray's direction. A
     * camera ray's is infinite, as is that of a smooth lobe. */
    float p[3][WAVE_SLOTS], n[3][WAVE_SLOTS], density[WAVE_SLOTS];
    /* The cone around the ray as it left that vertex: its width there, and its angle. */
    float width[WAVE_SLOTS], spread[WAVE_SLOTS];
    /* Surfaces passed as if they were not there, and the way from the vertex to the last of them. */
    uint32_t passes[WAVE_SLOTS];
    float passed[WAVE_SLOTS];
    /* Where first hits are kept: whether the path has met smooth surfaces alone, and what is left of white
     * light by them. */
    bool smooth[WAVE_SLOTS];
    float tint[3][WAVE_SLOTS];
    media *media;                /* NULL: no volume absorbs light or has a priority */
    uint8_t channel[WAVE_SLOTS]; /* that the path carries alone, from 1; 0: all three */
    shader hidden;               /* a surface inside a volume of a higher priority */
} path_wave;

static inline vec3_f32 of_slot(const float from[3][WAVE_SLOTS], uint32_t slot) {
    return (vec3_f32){from[0][slot], from[1][slot], from[2][slot]};
}

/* How often the path was scattered before the vertex it is at. */
static inline uint32_t path_scattered(const path_wave *p, uint32_t slot) {
    return p->depth - p->passes[slot];
}

static inline bool path_sends_light(const shader *s) {
    return s->emission[0] > 0 || s->emission[1] > 0 || s->emission[2] > 0;
}

/* ---- path_met.c ---- */

/* Light from outside of the scene, along the lanes that met nothing. */
void path_add_outside(wave *w, const trace_block *block, const path_block *path, uint32_t missed);
/* The light of the surface that lane i met; see path_sends_light(). */
void path_add_emission(path_wave *p, const vertex_block *v, unsigned i, const shader *s);

/* The features for denoisers, where asked for, after the first vertex and on the way from it. */
void path_show_features(path_wave *p, const vertex_block *v);
void path_leave_features(path_wave *p, const shader_sample *to, unsigned i, uint32_t slot);

/* ---- path_volumes.c ---- */

/* The light that the way to the vertices leaves. */
void path_absorb(path_wave *p, vertex_block *v);
/* The lanes, as bits, whose surfaces are not there, and the indices around the others. */
uint32_t path_meet_volumes(const path_wave *p, const vertex_block *v, float around[LANES]);
/* Gives these lanes the materials that they have there. */
void path_hide_surfaces(path_wave *p, vertex_block *v, const float around[LANES], uint32_t hidden);
/* Neighbouring samples of a pixel take the channels in turns; which one begins is a matter of chance. */
void path_choose_channels(const path_wave *p, vertex_block *v);
/* Light that is another one for each channel counts three times in one of them. crosses: the surface. True:
 * from there on the path carries that channel alone. */
bool path_part_channels(const path_wave *p, const vertex_block *v, unsigned i, bool crosses, float rgb[3]);
/* Both for the light that vertices ask for. */
void path_dim_lights(const path_wave *p, const vertex_block *v, const light_block *ray,
                     const uint32_t behind[LANES], lanes3 gain);
void path_part_lights(const path_wave *p, const vertex_block *v, const uint32_t behind[LANES], lanes3 gain);

#endif
