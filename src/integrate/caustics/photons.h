/* Internals of photons, shared by photons.c and connect.c. */
#pragma once

#include "integrate/caustics/caustics.h"

struct photon_wave {
    path_wave *path;
    const caustics *caustics;
    trace_approach bounds;
    /* By slot: the density of the photon's ray per étendue, its light's group, its caster, and the direction
     * to its light. */
    float found[WAVE_SLOTS];
    float chain[WAVE_SLOTS]; /* the product of caustic_step() at its vertices */
    uint8_t group[WAVE_SLOTS], caster[WAVE_SLOTS];
    float to_light[3][WAVE_SLOTS];
    surface_block bare; /* of the current block, without normal maps */
    /* The slots of this step with a ray to the camera, and the pixels that it reaches. */
    uint32_t asked[WAVE_SLOTS], pixel[WAVE_SLOTS];
    size_t asked_count;
};

/* Random numbers at a vertex for what paths of the camera do not choose: with SAMPLE_SCATTER the pixel, with
 * SAMPLE_ROULETTE whether the photon goes on. */
static inline sample_dimension photon_dimension(const path_wave *p, sample_purpose purpose) {
    return sample_at_vertex(p->depth + (1u << 16), purpose);
}

static inline void put_slot(float to[3][WAVE_SLOTS], uint32_t slot, vec3_f32 a) {
    to[0][slot] = a.x, to[1][slot] = a.y, to[2][slot] = a.z;
}

/* The points of a block as seen from the unit directions `to`: sets out->surface and out->path. */
void photon_turn(const photon_wave *w, const vertex_block *v, const lanes3 to, vertex_block *out);
/* Sends rays to the camera from those vertices of a block that end a chain. Their materials are not yet
 * known. */
void photon_connect(photon_wave *w, vertex_block *v);
