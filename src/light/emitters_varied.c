/* Emission that varies over a surface: its mean over an emitter, and its value where a sample hits. */
#include "light/emitters_inner.h"

texturing_place emitters_place(const emitters *e, const emitter_run *run, uint32_t index) {
    const uint32_t primitive = emitters_primitive(e, run, index);
    return (texturing_place){.material = world_material(e->w, run->geometry, primitive, run->instance),
                             .geometry = run->geometry,
                             .primitive = primitive,
                             .second = emitters_is_second(e, run, index)};
}

static float look_up(const emitters *e, vec3_f64 weight, texturing_place *place) {
    float rgb[3];
    store_f32(place->weight, narrow(weight));
    texturing_emission(e->texturing, place, rgb);
    return luminance(rgb);
}

/* ---- means ---- */

/* Looks up the triangle or half quad at `place`, or its cell, at the centre and towards each corner, with
 * footprints that cover it. */
static float half_power(const emitters *e, const emitter_run *run, uint32_t index, texturing_place *place) {
    vec3_f64 c[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    emitters_divide(c, run, index);
    const vec3_f64 center = scale_f64(1 / 3.0, add_f64(c[0], add_f64(c[1], c[2])));
    place->width = 0.5f / (float)(1u << run->level);
    float sum = look_up(e, center, place);
    for (int k = 0; k < 3; ++k) sum += look_up(e, scale_f64(0.5, add_f64(center, c[k])), place);
    return sum / 4;
}

/* Looks up normals at equal steps along the axis. Each is turned from the last by the golden angle. */
static float ball_power(const emitters *e, texturing_place *place) {
    enum { COUNT = 16 };
    float sum = 0;
    place->width = 0.25f;
    for (int k = 0; k < COUNT; ++k) {
        const double z = (2 * k + 1) / (double)COUNT - 1, flat = sqrt(1 - z * z),
                     turn = 2.399963229728653 * k;
        sum += look_up(e, vec_f64(flat * cos(turn), flat * sin(turn), z), place);
    }
    return sum / COUNT;
}

float emitters_varied_power(const emitters *e, const emitter_run *run, uint32_t index) {
    texturing_place place = emitters_place(e, run, index);
    if (emitters_is_ball(e, run)) return ball_power(e, &place);
    const float power = half_power(e, run, index, &place);
    if (!emitters_is_quad(e, run)) return power;
    place.second = true;
    return (power + half_power(e, run, index, &place)) / 2;
}

/* ---- samples ---- */

void emitters_face_place(const shape_face *f, vec3_f64 p, vec3_f64 direction, texturing_place *out) {
    for (int half = 0; half < (f->quad ? 2 : 1); ++half) {
        const vec3_f64 a = f->corner[half ? 2 : 0], b = sub_f64(f->corner[half ? 3 : 1], a),
                       c = sub_f64(f->corner[half ? 1 : 3], a), from = sub_f64(p, a);
        const vec3_f64 across = cross_f64(direction, c), along = cross_f64(from, b);
        const double all = dot_f64(b, across), inverse = all != 0 ? 1 / all : 0;
        const double u = fmin(fmax(dot_f64(from, across) * inverse, 0), 1),
                     v = fmin(fmax(dot_f64(direction, along) * inverse, 0), 1);
        const double over = fmax(u + v, 1);
        out->second = half;
        out->weight[1] = (float)(u / over), out->weight[2] = (float)(v / over);
        out->weight[0] = 1 - out->weight[1] - out->weight[2];
        if (u + v <= 1) return;
    }
}

static void find_place(const emitters *e, const emitter_run *run, float time, vec3_f64 p, vec3_f64 direction,
                       texturing_place *place) {
    if (emitters_is_ball(e, run)) {
        emitter_ball ball;
        emitters_ball(e, run, place->primitive, time, &ball);
        store_f32(place->weight, narrow(emitters_ball_normal(&ball, p, direction)));
    } else {
        shape_face face;
        emitters_face(e, run, place->primitive, time, &face);
        emitters_face_place(&face, p, direction, place);
    }
}

/* Directions that are sampled but hit nothing that emits stay dark. */
void emitters_vary(const emitters *e, const emitter_choices *c, emitter_sample *out) {
    for (unsigned lanes = c->faces | c->balls; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const emitter_run *run = emitters_run_of(e, c->emitter[i]);
        texturing_place place = emitters_place(e, run, c->emitter[i] - run->first);
        const vec3_f32 even = lane_f32(out->radiance, i);
        const bool dark = !(even.x > 0 || even.y > 0 || even.z > 0);
        if (dark || !texturing_varies_emission(e->texturing, place.material)) continue;
        float rgb[3];
        find_place(e, run, e->moving ? c->from->time[i] : 0, widen(lane_f32(c->from->p, i)),
                   widen(lane_f32(out->direction, i)), &place);
        texturing_emission(e->texturing, &place, rgb);
        put_lane_f32(out->radiance, i, load_f32(rgb));
    }
}
