#include "verify/exact/oracle.h"
#include "verify/exact/exact.h"
#include "verify/mode.h"

#include <string.h>

static bool finite_rows(const float m[3][4]) {
    for (int i = 0; i < 12; ++i) {
        if (!isfinite(m[i / 4][i % 4])) return false;
    }
    return true;
}

/* True when ray and shape are valid. */
static bool answerable(const oracle_ray *ray, const oracle_primitive *primitive) {
    const unsigned points = oracle_corners(primitive) + (primitive->shape == ORACLE_PLANE);
    for (unsigned i = 0; i < points; ++i) {
        if (!finite_f32(primitive->v[i])) return false;
    }
    if (primitive->shape == ORACLE_SPHERE && !(primitive->radius > 0 && isfinite(primitive->radius)))
        return false;
    if (primitive->instance && !finite_rows(primitive->instance->to_object)) return false;
    return finite_f32(ray->org) && finite_f32(ray->dir) && !isnan(ray->t_near) && !isnan(ray->t_far);
}

static bool inside(const solution *s, unsigned i) { return s->above_near[i] > 0 && s->below_far[i] > 0; }

static real_f128 smallest(const real_f128 *x, unsigned count) {
    real_f128 least = x[0];
    for (unsigned i = 1; i < count; ++i) {
        if (x[i] < least) least = x[i];
    }
    return least;
}

static void judge_sphere(const solution *s, oracle_answer *answer) {
    answer->edge = s->edge;
    answer->line = s->roots == 2;
    if (!answer->line) {
        answer->t = s->t[0];
        return;
    }
    unsigned part = s->above_near[0] > 0 ? 0u : 1u;
    answer->part = part;
    answer->hit = inside(s, part);
    answer->t = s->t[part], answer->other = s->t[1 - part];
    answer->above_near = s->above_near[part], answer->below_far = s->below_far[part];
}

static void judge_flat(const solution *s, const oracle_primitive *primitive, oracle_answer *answer) {
    memcpy(answer->weight, s->weight, sizeof answer->weight);
    answer->edge = primitive->shape == ORACLE_PLANE ? 1 : smallest(s->weight, 3);
    answer->line = answer->edge >= 0;
    answer->hit = answer->line && inside(s, 0);
    answer->t = s->t[0];
    answer->above_near = s->above_near[0], answer->below_far = s->below_far[0];
}

/* A sphere, triangle or plane. */
static void ask_one(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer) {
    solution s;
    memset(&s, 0, sizeof s);
    memset(answer, 0, sizeof *answer);
    exact_solve(ray, primitive, &s);
    answer->parallel = s.parallel;
    if (s.parallel) return;
    if (primitive->shape == ORACLE_SPHERE)
        judge_sphere(&s, answer);
    else
        judge_flat(&s, primitive, answer);
}

/* The primitive that the answer's t belongs to: for a quad, the part's triangle. */
static oracle_primitive part_of(const oracle_primitive *primitive, unsigned part) {
    oracle_primitive one = *primitive;
    if (primitive->shape != ORACLE_QUAD) return one;
    one.shape = ORACLE_TRIANGLE;
    oracle_part(primitive, part, one.v);
    return one;
}

static oracle_pair pair_of(const oracle_primitive *primitive, const oracle_answer *answer) {
    return (oracle_pair){part_of(primitive, answer->part), *answer};
}

/* Prefers the part that is hit. If both are hit, or the line hits both outside the interval: the nearer, on
 * equal t the first. Else the part that the line hits, or the one that it passes more closely. */
static unsigned better_part(const oracle_ray *ray, const oracle_primitive *quad,
                            const oracle_answer part[2]) {
    if (part[0].parallel || part[1].parallel) return part[0].parallel;
    if (part[0].hit != part[1].hit) return part[1].hit;
    if (part[0].line && part[1].line) {
        oracle_pair a = pair_of(quad, &part[0]), b = pair_of(quad, &part[1]);
        return oracle_compare(ray, &a, &b) > 0;
    }
    return part[1].edge > part[0].edge;
}

static void ask_quad(const oracle_ray *ray, const oracle_primitive *quad, oracle_answer *answer) {
    oracle_answer part[2];
    for (unsigned i = 0; i < 2; ++i) {
        oracle_primitive triangle = part_of(quad, i);
        ask_one(ray, &triangle, &part[i]);
        part[i].part = i;
    }
    const unsigned better = better_part(ray, quad, part);
    *answer = part[better];
    if (answer->line && !part[1 - better].parallel) answer->edge = smallest(answer->weight + 1, 2);
}

static MODE_APART void ask(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer) {
    if (!answerable(ray, primitive)) {
        memset(answer, 0, sizeof *answer);
        answer->parallel = true;
    } else if (primitive->shape == ORACLE_QUAD) {
        ask_quad(ray, primitive, answer);
    } else {
        ask_one(ray, primitive, answer);
    }
}

void oracle_ask(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer) {
    unsigned mode = mode_enter();
    ask(ray, primitive, answer);
    mode_leave(mode);
}

double oracle_condition(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                        bool inverted) {
    unsigned mode = mode_enter();
    oracle_primitive one = part_of(primitive, answer->part);
    double condition = condition_of(ray, &one, answer, inverted);
    mode_leave(mode);
    return condition;
}

static void root_of(const oracle_ray *ray, const oracle_pair *pair, exact_root *out) {
    oracle_primitive one = part_of(&pair->primitive, pair->answer.part);
    exact_root_of(ray, &one, pair->answer.part, out);
}

/* Integers are only needed if the difference is within the rounding of t. */
static MODE_APART int compare(const oracle_ray *ray, const oracle_pair *a, const oracle_pair *b) {
    const real_f128 x_t = a->answer.t, y_t = b->answer.t, apart = x_t - y_t;
    if (abs_f128(apart) > (real_f128)0x1p-90 * (abs_f128(x_t) + abs_f128(y_t))) return apart > 0 ? 1 : -1;
    exact_root x, y;
    root_of(ray, a, &x);
    root_of(ray, b, &y);
    return exact_root_compare(&x, &y);
}

int oracle_compare(const oracle_ray *ray, const oracle_pair *a, const oracle_pair *b) {
    unsigned mode = mode_enter();
    int order = compare(ray, a, b);
    mode_leave(mode);
    return order;
}
