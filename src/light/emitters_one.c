/* Scenes with one light, as most rooms and most landscapes have: a face that rests or an even sky. Nothing is
 * chosen there, and all lanes ask the same light. */
#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

static bool is_alone(const emitters *e, emitter_part part) {
    for (int k = 0; k < EMITTER_PARTS; ++k) {
        if ((e->chance[k] > 0) != (k == (int)part)) return false;
    }
    return true;
}

static bool prepare_face(emitters *e) {
    const emitter_run *run = emitters_run_of(e, e->only);
    const uint32_t primitive = e->only - run->first;
    if (e->w->geometries.items[run->geometry].kind == WORLD_SPHERES || e->moving) return true;
    e->one.face = malloc(sizeof *e->one.face);
    if (!e->one.face) return false;
    emitters_face(e, run, primitive, 0, e->one.face);
    e->one.radiance = e->emission[world_material(e->w, run->geometry, primitive, run->instance)];
    return true;
}

bool emitters_prepare_one(emitters *e) {
    e->one.sky = is_alone(e, EMITTER_OUTSIDE) && !e->sky_count;
    if (!is_alone(e, EMITTER_FINITE) || e->only >= e->surface_count || e->texturing) return true;
    return prepare_face(e);
}

bool emitters_choose(const emitters *e) { return !e->one.face && !e->one.sky; }

/* Under an even sky a light sample brings the sky's light or none. A BSDF sample that does not reach the sky
 * brings what a surface reflects of it, a part a, and so varies less (Grittmann et al., "Variance-Aware
 * Multiple Importance Sampling", 2019). Where densities are equal, as on Lambert's surfaces, weights of
 * (1 - a) / 2 and (1 + a) / 2 give the least variance. a = 1/4 gains nearly as much as the albedo itself, and
 * loses little where surfaces are black: the squares of the weights are as 1 - a to 1 + a. */
float emitters_mis_factor(const emitters *e) { return e->one.sky ? 0.7745967f : 1; }

/* Densities beyond float are of lights too small to be met. Lanes without light get a direction all the same.
 */
static void finish(const double density[LANES], const float radiance[3], emitter_sample *restrict out) {
    int dark = 0;
    for (int i = 0; i < LANES; ++i) {
        out->density[i] = density[i] < 0x1p127 ? (float)density[i] : 0x1p127f;
        dark |= !(out->density[i] > 0);
        out->sized[i] = ~0u;
    }
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->radiance[c][i] = radiance[c];
    }
    for (int i = 0; dark && i < LANES; ++i) {
        if (out->density[i] > 0) continue;
        for (int c = 0; c < 3; ++c) out->direction[c][i] = c == 2, out->radiance[c][i] = 0;
        out->distance[i] = out->density[i] = 0;
        out->sized[i] = 0;
    }
}

static void sample_face(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    _Alignas(64) double density[LANES];
    e->shapes->face(e->one.face, from->p, u, density, out->direction, out->distance);
    finish(density, e->one.radiance, out);
    if (e->groups) memset(out->group, emitters_group_of(e, e->only), sizeof out->group);
}

static void sample_sky(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    double density[LANES];
    e->shapes->sky(from->n, u, out->direction, density);
    for (int i = 0; i < LANES; ++i) density[i] *= e->background_chance;
    for (int i = 0; i < LANES; ++i) out->distance[i] = INFINITY;
    finish(density, e->background, out);
    memset(out->group, e->outside_group, sizeof out->group);
}

void emitters_sample_one(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    if (e->one.face)
        sample_face(e, from, u, out);
    else
        sample_sky(e, from, u, out);
}
