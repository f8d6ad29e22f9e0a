/* The emitters of a scene, for tests that fill it: set-up of each, and light samples. */
#pragma once

#include "light/emitters.h"
#include "math/lane.h"
#include "random.h"
#include "unit_scene.h"
#include "worlds.h"

UNIT_OWNS(emitters, emitters, emitters_destroy)

static world *w;
static emitters *e;

/* The background is black until a test sets another. */
static inline int begin_light(void **state) {
    open_scene(state);
    return fathom_scene_set_background(scene, (float[3]){0, 0, 0});
}

/* The scene must be filled. */
static inline void open_light(void) {
    w = new_world(scene);
    assert_ok(context, emitters_create(context, w, NULL, NULL, &e));
    own_emitters(e);
}

/* ---- samples ---- */

/* The point p with the normal n, at the time 0. */
static inline void fill_query(emitter_query *q, vec3_f64 p, vec3_f64 n) {
    memset(q, 0, sizeof *q);
    for (unsigned i = 0; i < LANES; ++i) {
        put_lane_f32(q->p, i, narrow(sub_f64(p, w->origin)));
        put_lane_f32(q->n, i, narrow(n));
    }
}

static inline void fill_numbers(random_state *r, lanes3 u) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) u[c][i] = (float)(random_bits(r) >> 40) * 0x1p-24f;
    }
}

/* The irradiance over pi at p, by samples. */
typedef struct received {
    double mean, error, square; /* of the samples; the mean of their squares */
    double dark;                /* fraction without light */
} received;

static inline received receive(vec3_f64 p, vec3_f64 n, int blocks) {
    random_state r = {1};
    emitter_query q;
    double sum = 0, squares = 0, dark = 0;
    const double count = blocks * LANES;
    fill_query(&q, p, n);
    for (int b = 0; b < blocks; ++b) {
        emitter_sample s;
        _Alignas(64) lanes3 u;
        fill_numbers(&r, u);
        emitters_sample(e, &q, u, &s);
        for (unsigned i = 0; i < LANES; ++i) {
            const double cosine = fmax(dot_f64(n, widen(lane_f32(s.direction, i))), 0);
            const bool lit = s.density[i] > 0 && s.radiance[0][i] > 0;
            const double light = lit ? (double)s.radiance[0][i] * cosine / ((double)s.density[i] * M_PI) : 0;
            sum += light, squares += light * light, dark += !lit;
        }
    }
    const double mean = sum / count;
    return (received){mean, sqrt((squares / count - mean * mean) / (count - 1)), squares / count,
                      dark / count};
}
