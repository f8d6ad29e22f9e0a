/* Samples emitters, and computes densities of hits on them. */
#include "light/emitters_inner.h"

#include "math/limit.h"

#include <stdlib.h>
#include <string.h>

#define READY_MOST (1u << 17) /* 17 MB */

/* ---- one lane ---- */

static void put_answer(emitter_sample *out, unsigned i, const emitter_answer *a, double chance,
                       const float radiance[3]) {
    static const float none[3] = {0, 0, 0};
    put_lane_f32(out->direction, i, narrow(a->direction));
    out->distance[i] = a->distance < 0x1p127 ? (float)a->distance : INFINITY;
    emitters_finish(out, i, a->density * chance, a->dark ? none : radiance);
}

/* ---- primitives ---- */

static float time_of(const emitters *e, const emitter_choices *c, unsigned i) {
    return e->moving ? c->from->time[i] : 0;
}

static const float *radiance_of(const emitters *e, const emitter_run *run, uint32_t primitive) {
    return e->emission[world_material(e->w, run->geometry, primitive, run->instance)];
}

static bool is_ball_chosen(const emitters *e, uint32_t emitter) {
    return e->ready ? !e->ready[emitter].radiance : emitters_is_ball(e, emitters_run_of(e, emitter));
}

static void cut_face(const emitters *e, const emitter_run *run, uint32_t index, shape_face *face) {
    emitters_cut(e, run, index, face->corner);
    face->quad = emitters_is_quad(e, run);
}

static void load_points(const emitter_choices *c, lanes3_f64 p) {
    for (int k = 0; k < 3; ++k) {
        for (unsigned i = 0; i < LANES; ++i) p[k][i] = (double)c->from->p[k][i];
    }
}

/* Copies the samples of `lanes` from those of all lanes. */
static void take_answers(const emitter_choices *c, unsigned lanes, const shape_answers *answers,
                         const lanes3 direction, const float distance[LANES],
                         const float *const radiance[LANES], emitter_sample *out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        for (int k = 0; k < 3; ++k) out->direction[k][i] = direction[k][i];
        out->distance[i] = distance[i];
        emitters_finish(out, i, answers->density[i] * c->chance[i], radiance[i]);
    }
}

/* The face of an emitter, and its radiance. */
static const float *find_face(const emitters *e, uint32_t emitter, float time, shape_face *face) {
    if (e->ready) {
        *face = e->ready[emitter].face;
        return e->ready[emitter].radiance;
    }
    const emitter_run *run = emitters_run_of(e, emitter);
    const uint32_t index = emitter - run->first, primitive = emitters_primitive(e, run, index);
    emitters_face(e, run, primitive, time, face);
    cut_face(e, run, index, face);
    return radiance_of(e, run, primitive);
}

/* Cells may be many, and a light sample of a face that moves depends on its time. */
bool emitters_prepare_ready(emitters *e) {
    if (e->moving || !e->surface_count || e->surface_count > READY_MOST) return true;
    emitter_ready *ready = calloc(e->surface_count, sizeof *ready);
    for (uint32_t r = 0; ready && r < e->run_count; ++r) {
        const emitter_run *run = &e->runs[r];
        for (uint32_t i = 0; i < run->count && !emitters_is_ball(e, run); ++i) {
            emitter_ready *one = &ready[run->first + i];
            one->radiance = find_face(e, run->first + i, 0, &one->face);
        }
    }
    e->ready = ready;
    return ready != NULL;
}

/* Lanes that chose no face get the first one. */
static void sample_faces(const emitters *e, const emitter_choices *c, emitter_sample *out) {
    const float *radiance[LANES];
    shape_faces faces;
    shape_answers answers;
    shape_face face;
    lanes3_f64 p;
    lanes3 direction;
    float distance[LANES];
    bool quads = false;
    uint32_t last = FATHOM_NONE;
    const float *light = NULL;
    for (unsigned left = c->faces; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        if (c->emitter[i] != last || e->moving) {
            light = find_face(e, c->emitter[i], time_of(e, c, i), &face);
            quads |= face.quad;
        }
        for (unsigned k = 0; last == FATHOM_NONE && k < LANES; ++k) shape_faces_put(&faces, k, &face);
        last = c->emitter[i], radiance[i] = light;
        shape_faces_put(&faces, i, &face);
    }
    load_points(c, p);
    e->shapes->faces(&faces, p, c->u, quads, &answers, direction, distance);
    take_answers(c, c->faces, &answers, direction, distance, radiance, out);
}

/* For points inside spheres, and for spheres in instances. */
static void sample_odd_ball(const emitter_ball *ball, const emitter_choices *c, unsigned i,
                            const float *radiance, emitter_sample *out) {
    emitter_answer answer;
    emitters_ask_ball(ball, widen(lane_f32(c->from->p, i)), unit_or_zero(lane_f32(c->from->n, i)),
                      (double)c->u[0][i], (double)c->u[1][i], &answer);
    put_answer(out, i, &answer, c->chance[i], radiance);
}

static void put_ball(shape_balls *to, unsigned i, const emitter_ball *b) {
    to->center[0][i] = b->center.x, to->center[1][i] = b->center.y, to->center[2][i] = b->center.z;
    to->radius[i] = b->radius, to->clear[i] = b->clear, to->slope[i] = b->slope;
}

static void sample_balls(const emitters *e, const emitter_choices *c, emitter_sample *out) {
    const float *radiance[LANES], *light = NULL;
    shape_balls balls;
    shape_answers answers;
    emitter_ball ball;
    lanes3_f64 p;
    lanes3 direction;
    float distance[LANES];
    unsigned plain = 0;
    uint32_t last = FATHOM_NONE;
    for (unsigned left = c->balls; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        if (c->emitter[i] != last || e->moving) {
            const emitter_run *run = emitters_run_of(e, c->emitter[i]);
            emitters_ball(e, run, c->emitter[i] - run->first, time_of(e, c, i), &ball);
            light = radiance_of(e, run, c->emitter[i] - run->first);
        }
        for (unsigned k = 0; last == FATHOM_NONE && k < LANES; ++k) put_ball(&balls, k, &ball);
        last = c->emitter[i], radiance[i] = light;
        put_ball(&balls, i, &ball);
        if (emitters_ball_is_plain(&ball, widen(lane_f32(c->from->p, i))))
            plain |= 1u << i;
        else
            sample_odd_ball(&ball, c, i, light, out);
    }
    if (!plain) return;
    load_points(c, p);
    e->shapes->balls(&balls, p, c->u, &answers, direction, distance);
    take_answers(c, plain, &answers, direction, distance, radiance, out);
}

/* Without the choice of the emitter, whose index in the run is *index. */
static double chosen_density(const emitters *e, const emitter_run *run, const emitter_hit *hit, vec3_f64 p,
                             vec3_f64 n, vec3_f64 direction, uint32_t *index) {
    *index = run->paired ? hit->primitive / 2 : hit->primitive;
    if (e->one.face) return emitters_face_density(&e->one.face->plain, p);
    if (e->ready && !run->level && e->ready[run->first].radiance)
        return emitters_face_density(&e->ready[run->first + *index].face, p);
    if (emitters_is_ball(e, run)) {
        emitter_ball ball;
        emitters_ball(e, run, hit->primitive, hit->time, &ball);
        return emitters_ball_density(&ball, p, n, direction, hit->inside);
    }
    shape_face face;
    emitters_face(e, run, hit->primitive, hit->time, &face);
    if (run->level) {
        texturing_place place;
        emitters_face_place(&face, p, direction, &place);
        *index = emitters_index_at(e, run, hit->primitive, &place);
        cut_face(e, run, *index, &face);
    }
    return emitters_face_density(&face, p);
}

/* ---- the choice ---- */

/* u in [0,1) has 24 bits, too few to choose fairly among millions: more bits are derived from a hash of the
 * lane's other two numbers. */
static double finer(const lanes3 u, unsigned i) {
    uint32_t a, b;
    memcpy(&a, &u[0][i], sizeof a), memcpy(&b, &u[1][i], sizeof b);
    uint64_t h = ((uint64_t)a << 32 | b) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 31) * 0x94d049bb133111ebu;
    const double whole = (double)(uint32_t)(u[2][i] * 0x1p24f);
    return (whole + (double)(h >> 35) * 0x1p-29) * 0x1p-24;
}

/* The class of emitters that a lane samples, EMITTER_PARTS if there is none; *u becomes a number in [0,1)
 * within that class. Numbers that are uniform over the square of the first two stay uniform within each
 * class. */
static emitter_part choose_part(const emitter_shares *shares, double *u) {
    emitter_part part = EMITTER_FINITE, last = EMITTER_PARTS;
    double left = *u;
    for (; part < EMITTER_PARTS; ++part) {
        if (!(shares->of[part] > 0)) continue;
        last = part;
        if (left < shares->of[part]) break;
        left -= shares->of[part];
    }
    if (last == EMITTER_PARTS) return last;
    left /= shares->of[last];
    *u = left < 0x1.fffffffffffffp-1 ? left : 0x1.fffffffffffffp-1;
    return last;
}

static void choose_of_many(const emitters *e, unsigned lanes, double u[LANES], emitter_choices *c) {
    const emitter_query *q = c->from;
    const tree_view *views[LANES] = {NULL};
    for (unsigned left = e->views.items ? lanes : 0; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        views[i] = emitters_find_view(e, lane_f32(q->p, i), lane_f32(q->n, i));
    }
    e->lights.kernels->choose(&e->lights, q->p, q->n, e->views.items ? views : NULL, lanes, u, c->emitter,
                              c->chance);
}

/* Chooses the finite light of each of `lanes`. */
static void choose_finite(const emitters *e, unsigned lanes, double u[LANES], emitter_choices *c,
                          emitter_sample *out) {
    if (e->only != FATHOM_NONE) {
        for (unsigned i = 0; i < LANES; ++i) c->emitter[i] = e->only, c->chance[i] = 1;
    } else {
        choose_of_many(e, lanes, u, c);
    }
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        c->chance[i] *= c->shares[i]->of[EMITTER_FINITE];
        if (!(c->chance[i] > 0))
            no_light(out, i);
        else if (c->emitter[i] >= e->surface_count)
            c->lamps |= 1u << i;
        else if (is_ball_chosen(e, c->emitter[i]))
            c->balls |= 1u << i;
        else
            c->faces |= 1u << i;
    }
}

/* Returns the lanes that sample a finite light; the others are complete. choice: numbers that choose among
 * the lights of a class. Changes the first number of u. */
static unsigned choose_parts(const emitters *e, emitter_choices *c, lanes3 u, double choice[LANES],
                             emitter_sample *out) {
    unsigned finite = 0, outside = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        double first = (double)u[0][i];
        choice[i] = finer(u, i);
        c->shares[i] = emitters_shares(e, lane_f32(c->from->p, i), lane_f32(c->from->n, i));
        const emitter_part part = choose_part(c->shares[i], &first);
        out->part[i] = (uint8_t)part;
        u[0][i] = least((float)first, 0x1.fffffep-1f);
        switch (part) {
        case EMITTER_FINITE: finite |= 1u << i; break;
        case EMITTER_OUTSIDE: outside |= 1u << i; break;
        case EMITTER_DIRECTIONAL:
            emitters_sample_sun(e, (double)u[0][i], (double)u[1][i], choice[i], c->shares[i]->of[part], out,
                                i);
            break;
        case EMITTER_PARTS: no_light(out, i); break;
        }
    }
    if (outside) emitters_sample_outside(e, outside, c->from, u, choice, c->shares, out);
    return finite;
}

void emitters_sample(const emitters *e, const emitter_query *from, const lanes3 numbers,
                     emitter_sample *out) {
    _Alignas(64) lanes3 u;
    memcpy(u, numbers, sizeof u);
    emitter_choices c = {.from = from, .u = u};
    double choice[LANES];
    if (!emitters_choose(e)) {
        emitters_sample_one(e, from, numbers, out);
        return;
    }
    const unsigned finite = choose_parts(e, &c, u, choice, out);
    if (finite) choose_finite(e, finite, choice, &c, out);
    memcpy(out->emitter, c.emitter, sizeof out->emitter);
    for (unsigned lanes = e->groups ? c.faces | c.balls | c.lamps : 0; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        out->group[i] = emitters_group_of(e, c.emitter[i]);
    }
    if (c.faces) sample_faces(e, &c, out);
    if (c.balls) sample_balls(e, &c, out);
    if (c.lamps) emitters_sample_lamps(e, &c, out);
    if (e->texturing) emitters_vary(e, &c, out);
}

float emitters_hit_density(const emitters *e, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                           const emitter_hit *hit) {
    const emitter_run *run = emitters_run(e, hit->geometry, hit->instance);
    if (!run) return 0;
    uint32_t index;
    double density = chosen_density(e, run, hit, widen(p), unit_or_zero(n), widen(direction), &index);
    const uint32_t slot = e->slot_of[run->first + index];
    if (slot == FATHOM_NONE) return 0;
    if (density > 0 && e->only == FATHOM_NONE)
        density *= tree_chance(&e->lights, p, n, emitters_view(e, p, n), slot);
    return density_f32(density * emitters_shares(e, p, n)->of[EMITTER_FINITE]);
}
