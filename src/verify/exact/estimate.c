/* The first way: quadruple precision with its error carried along. */
#include "verify/exact/exact.h"

static ball row_times(const float row[4], ball3 p, double w) {
    ball3 linear = {ball_exact((double)row[0]), ball_exact((double)row[1]), ball_exact((double)row[2])};
    return ball_add(ball3_dot(linear, p), ball_mul(ball_exact((double)row[3]), ball_exact(w)));
}

static ball3 carried(const float m[3][4], ball3 p, double w) {
    return (ball3){row_times(m[0], p, w), row_times(m[1], p, w), row_times(m[2], p, w)};
}

estimate_ray estimate_ray_of(const oracle_ray *ray, const world_instance *instance) {
    estimate_ray r = {ball3_exact(ray->org), ball3_exact(ray->dir)};
    if (instance) {
        r.org = carried(instance->to_object, r.org, 1);
        r.dir = carried(instance->to_object, r.dir, 0);
    }
    return r;
}

static bool known(const solution *s) {
    for (unsigned i = 0; i < (s->roots ? s->roots : 1); ++i) {
        if (!ball_known(s->t[i])) return false;
        if (s->roots && !(ball_known(s->above_near[i]) && ball_known(s->below_far[i]))) return false;
    }
    return true;
}

/* The distance of t = n/d from an end of the interval, sign (n - end d) / d. */
static ball from_end(ball n, ball d, float end, int sign) {
    if (isinf(end)) return (ball){sign * (end < 0 ? HUGE_VAL : -HUGE_VAL), 0};
    ball difference = ball_sub(n, ball_mul(ball_exact((double)end), d));
    return ball_div(sign < 0 ? ball_neg(difference) : difference, d);
}

static void set_quotient(solution *out, unsigned i, ball n, ball d, const oracle_ray *ray) {
    out->t[i] = ball_div(n, d);
    out->above_near[i] = from_end(n, d, ray->t_near, 1);
    out->below_far[i] = from_end(n, d, ray->t_far, -1);
}

/* The line P(t) = E + t d and the plane with normal n through a: t = (a-E)·n / (d·n). */
static bool solve_plane(const oracle_ray *ray, ball3 a, ball3 n, ball3 dir, solution *out) {
    ball along = ball3_dot(dir, n);
    out->parallel = along.value == 0 && along.error == 0;
    if (out->parallel) return true;
    if (!ball_known(along)) return false;
    out->roots = 1;
    set_quotient(out, 0, ball3_dot(a, n), along, ray);
    return known(out);
}

/* Corners a, b, c as seen from the origin; the weight of a is d·(b×c) over d·n, with n = (b-a)×(c-a) the sum
 * of all three cross products. n is formed from the sides, where the origin has no part. */
static bool solve_triangle(const oracle_ray *ray, const estimate_ray *r, const vec3_f32 v[3], solution *out) {
    ball3 corner[3], from_org[3];
    for (int k = 0; k < 3; ++k) {
        corner[k] = ball3_exact(v[k]);
        from_org[k] = ball3_sub(corner[k], r->org);
    }
    ball3 n = ball3_cross(ball3_sub(corner[1], corner[0]), ball3_sub(corner[2], corner[0]));
    if (!solve_plane(ray, from_org[0], n, r->dir, out)) return false;
    if (out->parallel) return true;
    ball along = ball3_dot(r->dir, n);
    for (int k = 0; k < 3; ++k) {
        ball edge = ball3_dot(r->dir, ball3_cross(from_org[(k + 1) % 3], from_org[(k + 2) % 3]));
        out->weight[k] = ball_div(edge, along);
        if (!ball_known(out->weight[k])) return false;
    }
    return true;
}

/* With f = E - C: a = d·d, b = f·d, c = f·f - R², and by Lagrange's identity b² - a c = a R² - |f×d|² = D,
 * where nothing of size |f|² is subtracted. The roots are c / (-b + √D) and (-b + √D) / a for b <= 0, where
 * nothing cancels, and mirrored for b > 0. D = 0 is told from its error by whole numbers alone. */
static bool solve_sphere(const oracle_ray *ray, const estimate_ray *r, const oracle_primitive *sphere,
                         solution *out) {
    ball rest = ball_exact((double)sphere->radius_rest);
    ball radius = ball_add(ball_exact((double)sphere->radius), rest), r2 = ball_mul(radius, radius);
    ball3 center = ball3_sub(ball3_exact(sphere->v[0]), ball3_exact(neg_f32(sphere->rest)));
    ball3 f = ball3_sub(r->org, center);
    ball a = ball3_dot(r->dir, r->dir), b = ball3_dot(f, r->dir);
    out->parallel = a.value == 0 && a.error == 0;
    if (out->parallel) return true;
    if (!ball_known(a)) return false;
    ball3 g = ball3_cross(f, r->dir);
    ball D = ball_sub(ball_mul(a, r2), ball3_dot(g, g));
    if (!ball_known(D)) return false;
    out->edge = ball_div(D, ball_mul(a, r2));
    out->roots = D.value < 0 ? 0 : 2;
    if (!out->roots) {
        out->t[0] = ball_div(ball_neg(b), a);
        return known(out);
    }
    ball c = ball_sub(ball3_dot(f, f), r2), root = ball_sqrt(D);
    bool ahead = b.value <= 0;
    ball sum = ahead ? ball_sub(root, b) : ball_neg(ball_add(root, b));
    set_quotient(out, ahead ? 1 : 0, sum, a, ray);
    set_quotient(out, ahead ? 0 : 1, c, sum, ray);
    return known(out);
}

bool estimate_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out) {
    estimate_ray r = estimate_ray_of(ray, primitive->instance);
    switch (primitive->shape) {
    case ORACLE_SPHERE: return solve_sphere(ray, &r, primitive, out);
    case ORACLE_PLANE: {
        ball3 a = ball3_sub(ball3_exact(primitive->v[0]), r.org);
        return solve_plane(ray, a, ball3_exact(primitive->v[1]), r.dir, out);
    }
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: break;
    }
    return solve_triangle(ray, &r, primitive->v, out);
}
