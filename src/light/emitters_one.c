/* Scenes with one light, as most rooms and most landscapes have: a static face or a uniform sky. There is no
 * choice of lights, and all lanes sample the same one. */
#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

static bool is_alone(const emitters *e, emitter_part part) {
    for (int k = 0; k < EMITTER_PARTS; ++k) {
        if ((e->shares.of[k] > 0) != (k == (int)part)) return false;
    }
    return true;
}

/* Rounding takes up to 8 u from the cosine to the normal: the same effect as a larger slope. */
static void make_fast(emitter_face *f) {
    static const int halves[2][3] = {{0, 1, 3}, {2, 3, 1}};
    const shape_face *from = &f->plain;
    shape_face_f32 *to = &f->fast;
    f->exact = true;
    for (int k = 0; k < 4; ++k) {
        to->corner[k] = narrow(from->corner[k]);
        f->exact &= length_f64(sub_f64(widen(to->corner[k]), from->corner[k])) == 0;
    }
    for (int h = 0; h < 2; ++h) {
        const vec3_f64 a = from->corner[halves[h][0]], b = from->corner[halves[h][1]],
                       c = from->corner[halves[h][2]], n = cross_f64(sub_f64(b, a), sub_f64(c, a));
        to->n[h] = normalize_f64(n);
        to->size[h] = h && !from->quad ? 0 : (float)length_f64(n);
    }
    to->clear = (float)(from->clear * (1 + 0x1p-20));
    to->slope = (float)(from->slope + 8 * 0x1p-24);
    for (unsigned i = 0; i < LANES; ++i) shape_faces_put(&f->all, i, from);
}

static bool prepare_face(emitters *e) {
    const emitter_run *run = emitters_run_of(e, e->only);
    const uint32_t primitive = emitters_primitive(e, run, e->only - run->first);
    if (e->w->geometries.items[run->geometry].kind == WORLD_SPHERES || e->moving) return true;
    e->one.face = aligned_alloc(64, sizeof *e->one.face);
    if (!e->one.face) return false;
    emitters_face(e, run, primitive, 0, &e->one.face->plain);
    make_fast(e->one.face);
    e->one.radiance = e->emission[world_material(e->w, run->geometry, primitive, run->instance)];
    return true;
}

bool emitters_prepare_one(emitters *e) {
    e->one.sky = is_alone(e, EMITTER_OUTSIDE) && !e->sky_count;
    if (!is_alone(e, EMITTER_FINITE) || e->only >= e->surface_count || e->texturing) return true;
    return prepare_face(e);
}

bool emitters_choose(const emitters *e) { return !e->one.face && !e->one.sky; }

/* Under a uniform sky, a light sample contributes the sky's light or nothing. A BSDF sample that misses the
 * sky contributes the light that a surface reflects, a fraction a of it, and so has less variance (Grittmann
 * et al., "Variance-Aware Multiple Importance Sampling", 2019). If both densities are equal, as on Lambert
 * surfaces, weights of (1 - a) / 2 and (1 + a) / 2 minimise the variance. a = 1/4 gains nearly as much as the
 * albedo itself, and costs little on black surfaces: the densities' factors are as 1 - a to 1 + a. */
float emitters_mis_factor(const emitters *e) { return e->one.sky ? 0.6f : 1; }

/* Lanes without light get a direction, too. */
static void finish(const float radiance[3], emitter_sample *restrict out) {
    int dark = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        dark |= !(out->density[i] > 0);
        out->sized[i] = ~0u;
    }
    for (int c = 0; c < 3; ++c) {
        for (unsigned i = 0; i < LANES; ++i) out->radiance[c][i] = radiance[c];
    }
    for (unsigned i = 0; dark && i < LANES; ++i) {
        if (out->density[i] > 0) continue;
        for (int c = 0; c < 3; ++c) out->direction[c][i] = c == 2, out->radiance[c][i] = 0;
        out->distance[i] = out->density[i] = 0;
        out->sized[i] = 0;
    }
}

/* Samples the lanes of these bits in double. Densities beyond the range of float belong to lights too small
 * to be hit. */
static void look_closer(const emitters *e, const emitter_query *from, const lanes3 u, uint32_t lanes,
                        emitter_sample *out) {
    lanes3_f64 p;
    shape_answers answers;
    lanes3 direction;
    float distance[LANES];
    for (int c = 0; c < 3; ++c) {
        for (unsigned i = 0; i < LANES; ++i) p[c][i] = (double)from->p[c][i];
    }
    e->shapes->faces(&e->one.face->all, p, u, e->one.face->plain.quad, &answers, direction, distance);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        for (int c = 0; c < 3; ++c) out->direction[c][i] = direction[c][i];
        out->distance[i] = distance[i];
        out->density[i] = answers.density[i] < 0x1p127 ? (float)answers.density[i] : 0x1p127f;
    }
}

static void sample_face(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    const emitter_face *f = e->one.face;
    uint32_t unsure = (1u << LANES) - 1;
    if (f->exact) unsure = e->shapes->face(&f->fast, from->p, u, out->density, out->direction, out->distance);
    if (unsure) look_closer(e, from, u, unsure, out);
    finish(e->one.radiance, out);
    if (e->groups) memset(out->group, emitters_group_of(e, e->only), sizeof out->group);
}

static void sample_sky(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    e->shapes->sky(from->n, u, out->direction, out->density);
    for (unsigned i = 0; i < LANES; ++i) out->distance[i] = INFINITY;
    finish(e->background, out);
    memset(out->group, e->outside_group, sizeof out->group);
}

void emitters_sample_one(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    memset(out->part, e->one.face ? EMITTER_FINITE : EMITTER_OUTSIDE, sizeof out->part);
    if (e->one.face)
        sample_face(e, from, u, out);
    else
        sample_sky(e, from, u, out);
}
