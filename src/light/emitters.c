#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

/* ---- the whole ---- */

static bool from_outside(const emitters *e) {
    double sum = e->background_chance;
    for (uint32_t i = 0; i < e->sky_count; ++i) sum += e->skies[i].chance;
    return sum > 0;
}

/* Each part that is there is asked for equally often. */
static void share(emitters *e) {
    const bool there[EMITTER_PARTS] = {e->finite_count > 0, from_outside(e), e->sun_count > 0};
    int parts = 0;
    for (int k = 0; k < EMITTER_PARTS; ++k) parts += there[k];
    for (int k = 0; k < EMITTER_PARTS; ++k) e->chance[k] = there[k] ? 1.0 / parts : 0;
}

fathom_status emitters_create(fathom_context *context, const world *w, emitters **out) {
    *out = NULL;
    emitters *e = calloc(1, sizeof *e);
    if (!e) return fail_memory(context, sizeof *e);
    e->w = w;
    e->faces = face_kernels_best();
    memcpy(e->background, w->scene->background, sizeof e->background);
    fathom_status status = emitters_collect(context, e);
    if (status == FATHOM_OK) status = emitters_open_skies(context, e);
    if (status != FATHOM_OK) {
        emitters_destroy(e);
        return status;
    }
    share(e);
    *out = e;
    return FATHOM_OK;
}

void emitters_destroy(emitters *e) {
    if (!e) return;
    tree_destroy(&e->lights);
    if (e->run_of) free(e->run_of - 1);
    free(e->emission);
    free(e->runs);
    free(e->slot_of);
    free(e->lamps);
    free(e->surfaces);
    free(e->suns);
    for (uint32_t i = 0; i < e->sky_count; ++i) environment_destroy(e->skies[i].image);
    free(e->skies);
    free(e);
}

bool emitters_none(const emitters *e) {
    double sum = 0;
    for (int k = 0; k < EMITTER_PARTS; ++k) sum += e->chance[k];
    return !(sum > 0);
}

/* ---- one lane ---- */

static vec3_f32 lane_f32(const lanes3 v, int i) { return (vec3_f32){v[0][i], v[1][i], v[2][i]}; }

static void put_lane(lanes3 v, int i, vec3_f32 a) { v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z; }

static vec3_f64 unit_or_zero(vec3_f32 n) { return normalize_f64(widen(n)); }

static void no_light(emitter_sample *out, int i) {
    put_lane(out->direction, i, (vec3_f32){0, 0, 1});
    put_lane(out->radiance, i, (vec3_f32){0, 0, 0});
    out->distance[i] = out->density[i] = 0;
    out->sized[i] = 0;
}

/* Densities beyond float are of lights too small to be met. */
static float density_f32(double density) { return density < 0x1p127 ? (float)density : 0x1p127f; }

static void put_answer(emitter_sample *out, int i, const emitter_answer *a, double chance,
                       const float radiance[3]) {
    out->density[i] = density_f32(a->density * chance);
    if (!(out->density[i] > 0)) {
        no_light(out, i);
        return;
    }
    put_lane(out->direction, i, narrow(a->direction));
    out->distance[i] = a->distance < 0x1p127 ? (float)a->distance : INFINITY;
    put_lane(out->radiance, i, a->dark ? (vec3_f32){0, 0, 0} : load_f32(radiance));
    out->sized[i] = ~0u;
}

/* ---- primitives ---- */

static void sample_ball(const emitters *e, const emitter_query *from, const lanes3 u, int i,
                        const emitter_run *run, uint32_t primitive, emitter_answer *out) {
    emitter_ball ball;
    emitters_ball(e, run, primitive, &ball);
    emitters_ask_ball(&ball, widen(lane_f32(from->p, i)), unit_or_zero(lane_f32(from->n, i)), (double)u[0][i],
                      (double)u[1][i], out);
}

/* Faces that lanes have chosen, to be asked together. */
typedef struct chosen_faces {
    face_query query;
    const float *radiance[LANES];
    unsigned lanes; /* as bits */
} chosen_faces;

static void put_face(const shape_face *f, int i, face_query *out) {
    for (int k = 0; k < 4; ++k) {
        out->corner[k][0][i] = f->corner[k].x;
        out->corner[k][1][i] = f->corner[k].y;
        out->corner[k][2][i] = f->corner[k].z;
    }
    out->quad[i] = f->quad ? 1 : 0, out->clear[i] = f->clear, out->slope[i] = f->slope;
}

/* The lanes, as bits, that chose this primitive. */
static void sample_primitive(const emitters *e, const emitter_query *from, const lanes3 u, unsigned lanes,
                             uint32_t emitter, const double chance[LANES], chosen_faces *faces,
                             emitter_sample *out) {
    const emitter_run *run = emitters_run_of(e, emitter);
    const uint32_t primitive = emitter - run->first;
    const float *radiance = e->emission[world_material(e->w, run->geometry, primitive, run->instance)];
    const bool round = e->w->geometries.items[run->geometry].kind == WORLD_SPHERES;
    shape_face face;
    emitter_answer answer;
    if (!round) emitters_face(e, run, primitive, &face);
    for (; lanes; lanes &= lanes - 1) {
        const int i = __builtin_ctz(lanes);
        if (round) {
            sample_ball(e, from, u, i, run, primitive, &answer);
            put_answer(out, i, &answer, chance[i], radiance);
        } else {
            put_face(&face, i, &faces->query);
            faces->radiance[i] = radiance;
            faces->lanes |= 1u << i;
        }
    }
}

/* Other lanes repeat the face of one that chose any. */
static void sample_faces(const emitters *e, const emitter_query *from, const lanes3 u,
                         const double chance[LANES], chosen_faces *faces, emitter_sample *out) {
    face_query *q = &faces->query;
    face_answer answer;
    const int any_lane = __builtin_ctz(faces->lanes);
    for (int i = 0; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) q->p[c][i] = (double)from->p[c][i];
        q->u[i] = (double)u[0][i], q->v[i] = (double)u[1][i];
        if (faces->lanes >> i & 1) continue;
        for (int k = 0; k < 4; ++k) {
            for (int c = 0; c < 3; ++c) q->corner[k][c][i] = q->corner[k][c][any_lane];
        }
        q->quad[i] = q->clear[i] = q->slope[i] = 0;
    }
    e->faces->sample(q, &answer);
    for (unsigned left = faces->lanes; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        const emitter_answer a = {{answer.direction[0][i], answer.direction[1][i], answer.direction[2][i]},
                                  answer.distance[i],
                                  answer.density[i],
                                  false};
        put_answer(out, i, &a, chance[i], faces->radiance[i]);
    }
}

static double primitive_density(const emitters *e, const emitter_run *run, uint32_t primitive, vec3_f64 p,
                                vec3_f64 n, vec3_f64 direction) {
    if (e->w->geometries.items[run->geometry].kind == WORLD_SPHERES) {
        emitter_ball ball;
        emitters_ball(e, run, primitive, &ball);
        return emitters_ball_density(&ball, p, n, direction);
    }
    shape_face face;
    emitters_face(e, run, primitive, &face);
    return emitters_face_density(&face, p);
}

/* ---- lamps ---- */

/* A lamp with a size is a sphere that no ray meets, of the radiance k_l / r². Points inside see it without
 * size. */
static bool widen_lamp(const emitter_lamp *lamp, vec3_f64 p, double u, double v, emitter_sample *out, int i) {
    const vec3_f64 from = sub_f64(p, widen(lamp->light.position));
    const double r = (double)lamp->radius;
    if (!(dot_f64(from, from) > r * r) || !(r > 0)) return false;
    const shape_cone cone = shape_cone_of(from, r);
    const vec3_f64 d = shape_cone_sample(&cone, u, v);
    put_lane(out->direction, i, narrow(d));
    out->distance[i] = (float)fmax(shape_sphere_near(from, d, r) * (1 - 0x1p-20), 0x1p-126);
    const double more = shape_cone_angle(&cone) / (SHAPE_PI * r * r) * dot_f64(from, from);
    for (int c = 0; c < 3; ++c) out->radiance[c][i] *= (float)more;
    return true;
}

/* The lanes of `lanes` that chose this lamp. */
static void sample_lamp(const emitter_lamp *lamp, const emitter_query *from, const lanes3 u, unsigned lanes,
                        const double chance[LANES], emitter_sample *out) {
    const light_kernels *kernels = light_kernels_best();
    light_block seen, aimed;
    kernels->sample(&lamp->light, from->p, &seen);
    memcpy(aimed.origin, from->p, sizeof aimed.origin);
    kernels->aim(&lamp->light, &aimed);
    for (int i = 0; i < LANES; ++i) {
        if (!(lanes >> i & 1)) continue;
        for (int c = 0; c < 3; ++c) {
            out->direction[c][i] = aimed.direction[c][i];
            out->radiance[c][i] = (float)SHAPE_PI * (seen.radiance[c][i] * seen.falloff[i]);
        }
        out->distance[i] = aimed.distance[i];
        out->density[i] = seen.distance[i] > 0 ? (float)chance[i] : 0;
        out->sized[i] = 0;
        if (lamp->radius > 0)
            widen_lamp(lamp, widen(lane_f32(from->p, i)), (double)u[0][i], (double)u[1][i], out, i);
    }
}

/* ---- from outside ---- */

static void sample_sun(const emitters *e, double u, double v, double choice, emitter_sample *out, int i) {
    uint32_t k = e->sun_count - 1;
    while (k > 0 && choice < e->suns[k].below) --k;
    const emitter_sun *sun = &e->suns[k];
    const shape_cone cone = {shape_unit(widen(sun->to_light)), 1, sun->cap};
    put_lane(out->direction, i, narrow(shape_cone_sample(&cone, u, v)));
    put_lane(out->radiance, i, load_f32(sun->irradiance));
    out->distance[i] = INFINITY;
    out->density[i] = (float)(e->chance[EMITTER_DIRECTIONAL] * sun->chance);
    out->sized[i] = 0;
}

/* Background and environments add up. One of them takes a direction; its density counts them all. */
static void look_outside(const emitters *e, vec3_f64 n, vec3_f64 direction, float radiance[3],
                         double *density) {
    memcpy(radiance, e->background, sizeof e->background);
    *density = e->background_chance * shape_all_density(n, direction);
    for (uint32_t i = 0; i < e->sky_count; ++i) {
        float more[3];
        *density += e->skies[i].chance * environment_at(e->skies[i].image, direction, more);
        for (int c = 0; c < 3; ++c) radiance[c] += more[c];
    }
}

static vec3_f64 aim_outside(const emitters *e, vec3_f64 n, double choice, double u, double v) {
    for (uint32_t i = 0; i < e->sky_count; ++i) {
        if (choice < e->skies[i].chance)
            return environment_sample(e->skies[i].image, choice / e->skies[i].chance, u, v);
        choice -= e->skies[i].chance;
    }
    if (e->background_chance > 0) return shape_all_sample(n, u, v);
    return environment_sample(e->skies[e->sky_count - 1].image, 0, u, v);
}

static void sample_outside(const emitters *e, const emitter_query *from, const lanes3 u, double choice,
                           emitter_sample *out, int i) {
    const vec3_f64 n = unit_or_zero(lane_f32(from->n, i));
    emitter_answer answer = {.distance = INFINITY};
    float radiance[3];
    /* As it will be traced: a texel's edge may lie next to it. */
    answer.direction = widen(narrow(aim_outside(e, n, choice, (double)u[0][i], (double)u[1][i])));
    look_outside(e, n, answer.direction, radiance, &answer.density);
    put_answer(out, i, &answer, e->chance[EMITTER_OUTSIDE], radiance);
}

void emitters_outside(const emitters *e, vec3_f32 p, vec3_f32 n, vec3_f32 direction, float radiance[3],
                      float *density) {
    double outside;
    (void)p;
    look_outside(e, unit_or_zero(n), widen(direction), radiance, &outside);
    *density = density_f32(e->chance[EMITTER_OUTSIDE] * outside);
}

/* ---- the choice ---- */

/* u in [0,1) has 24 digits, too few to choose among millions fairly: others follow, from u's neighbours. */
static double finer(const lanes3 u, int i) {
    uint32_t a, b;
    memcpy(&a, &u[0][i], sizeof a), memcpy(&b, &u[1][i], sizeof b);
    uint64_t h = ((uint64_t)a << 32 | b) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 31) * 0x94d049bb133111ebu;
    const double whole = floor((double)u[2][i] * 0x1p24);
    return (whole + (double)(h >> 35) * 0x1p-29) * 0x1p-24;
}

/* Which part lane i asks; *u becomes a number in [0,1) within it. */
static emitter_part choose_part(const emitters *e, double *u) {
    emitter_part part = EMITTER_FINITE, last = EMITTER_FINITE;
    double left = *u;
    for (; part < EMITTER_PARTS; ++part) {
        if (!(e->chance[part] > 0)) continue;
        last = part;
        if (left < e->chance[part]) break;
        left -= e->chance[part];
    }
    *u = fmin(left / e->chance[last], 0x1.fffffffffffffp-1);
    return last;
}

/* Lanes whose light is still to be asked. */
typedef struct chosen_lights {
    uint32_t emitter[LANES];
    double chance[LANES];
    unsigned finite; /* lanes that chose a primitive or a lamp */
} chosen_lights;

static void choose_finite(const emitters *e, const emitter_query *from, double choice, int i,
                          chosen_lights *chosen, emitter_sample *out) {
    double chance = 1;
    uint32_t emitter = e->only;
    if (emitter == FATHOM_NONE)
        emitter = tree_choose(&e->lights, lane_f32(from->p, i), lane_f32(from->n, i), choice, &chance);
    chance *= e->chance[EMITTER_FINITE];
    chosen->emitter[i] = emitter, chosen->chance[i] = chance;
    if (!(chance > 0))
        no_light(out, i);
    else
        chosen->finite |= 1u << i;
}

/* Lanes with one light ask it together. */
static void sample_finite(const emitters *e, const emitter_query *from, const lanes3 u,
                          const chosen_lights *chosen, emitter_sample *out) {
    unsigned left = chosen->finite;
    chosen_faces faces;
    faces.lanes = 0;
    while (left) {
        const uint32_t emitter = chosen->emitter[__builtin_ctz(left)];
        unsigned same = 0;
        for (int i = 0; i < LANES; ++i) {
            if (left >> i & 1 && chosen->emitter[i] == emitter) same |= 1u << i;
        }
        if (emitter >= e->surface_count)
            sample_lamp(&e->lamps[emitter - e->surface_count], from, u, same, chosen->chance, out);
        else
            sample_primitive(e, from, u, same, emitter, chosen->chance, &faces, out);
        left &= ~same;
    }
    if (faces.lanes) sample_faces(e, from, u, chosen->chance, &faces, out);
}

void emitters_sample(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out) {
    chosen_lights chosen = {.finite = 0};
    for (int i = 0; i < LANES; ++i) {
        double choice = finer(u, i);
        if (emitters_none(e)) {
            no_light(out, i);
            continue;
        }
        switch (choose_part(e, &choice)) {
        case EMITTER_FINITE: choose_finite(e, from, choice, i, &chosen, out); break;
        case EMITTER_OUTSIDE: sample_outside(e, from, u, choice, out, i); break;
        case EMITTER_DIRECTIONAL: sample_sun(e, (double)u[0][i], (double)u[1][i], choice, out, i); break;
        case EMITTER_PARTS: break;
        }
    }
    sample_finite(e, from, u, &chosen, out);
}

float emitters_hit_density(const emitters *e, vec3_f32 p, vec3_f32 n, vec3_f32 direction,
                           const emitter_hit *hit) {
    const emitter_run *run = emitters_run(e, hit->geometry, hit->instance);
    if (!run) return 0;
    const uint32_t slot = e->slot_of[run->first + hit->primitive];
    if (slot == FATHOM_NONE) return 0;
    double density = primitive_density(e, run, hit->primitive, widen(p), unit_or_zero(n), widen(direction));
    if (density > 0 && e->only == FATHOM_NONE) density *= tree_chance(&e->lights, p, n, slot);
    return density_f32(density * e->chance[EMITTER_FINITE]);
}
