#include "verify/verdict/verdict_judge.h"

static double value(ball b) { return (double)b.value; }

double judge_nearest(judge *j, const oracle_ray *ray) {
    bool done = j->shadows ? search_shadow(j->search, ray, j->room) : search_closest(j->search, ray, j->room);
    if (!done) {
        j->failed = true;
        return (double)INFINITY;
    }
    return j->room->ties.count ? value(j->room->ties.items[0].answer.t) : (double)INFINITY;
}

/* ---- what was skipped ---- */

/* The ray moved aside, at right angles to itself, to side `k` of eight. */
static oracle_ray moved_aside(const oracle_ray *ray, double by, int k) {
    vec3_f64 d = normalize_f64(widen(ray->dir));
    vec3_f64 other = fabs(d.x) < 0.6 ? vec_f64(1, 0, 0) : vec_f64(0, 1, 0);
    vec3_f64 x = normalize_f64(cross_f64(d, other)), y = cross_f64(d, x);
    double angle = k * 0.7853981633974483 + 0.2;
    vec3_f64 aside = add_f64(scale_f64(by * cos(angle), x), scale_f64(by * sin(angle), y));
    oracle_ray out = *ray;
    out.org = narrow(add_f64(widen(ray->org), aside));
    return out;
}

/* Whether the nearest hit is what was reported, or nothing that the tracer could report. */
static bool is_fair(const judge *j, const oracle_ray *ray) {
    const search_hit *hit = &j->room->ties.items[0];
    oracle_primitive p = search_primitive(j->world, hit->geometry, hit->primitive, hit->instance);
    if (verdict_beyond(j->tracer, j->world, ray, &p, value(hit->answer.t))) return true;
    return j->said && hit->geometry == j->said->geometry && hit->primitive == j->said->primitive &&
           hit->instance == j->said->instance;
}

/* Whether a ray that the precision cannot tell from this one meets nothing before t, or at whatever t what
 * was reported, or what the tracer cannot hold. A surface that goes on beyond the edge is met on all sides.
 */
static bool passes_aside(judge *j, const oracle_ray *from, double by, double before) {
    for (int k = 0; k < 8; ++k) {
        oracle_ray ray = moved_aside(from, by, k);
        if (!finite_f32(ray.org)) return true;
        double t = judge_nearest(j, &ray);
        if (t >= before || (t < (double)INFINITY && is_fair(j, &ray))) return true;
    }
    return false;
}

/* Takes a hit away that lies within its bound of an end of the interval asked for. */
static bool trim(const judge *j, const search_hit *hit, const verdict_bound *bound, oracle_ray *ray) {
    double t = value(hit->answer.t);
    if (t - (double)j->ray->t_near <= bound->t)
        ray->t_near = nextafterf((float)(t + bound->t), INFINITY);
    else if ((double)j->ray->t_far - t <= bound->t)
        ray->t_far = nextafterf((float)(t - bound->t), -INFINITY);
    else
        return false;
    return true;
}

/* Embree's rcp_safe(): no component of a direction is taken for less than 1e-18 where boxes are tested. That
 * bends the ray for them, by more than rounding does if the whole direction is that small; in the world it
 * never is (trace/stretch.h). */
static bool is_clamped(const judge *j, const oracle_primitive *p) {
    if (!p->instance) return false;
    oracle_ray ray = *j->ray;
    ray.dir = narrow(normalize_f64(widen(ray.dir)));
    vec3_f32 d = verdict_object_direction(&ray, p);
    double clamped = j->tracer->clamped, least = clamped / j->tracer->unit;
    double part[3] = {fabs((double)d.x), fabs((double)d.y), fabs((double)d.z)};
    double most = fmax(part[0], fmax(part[1], part[2])), small = fmin(part[0], fmin(part[1], part[2]));
    return most < least && small < clamped;
}

/* Why the hit, which lies well inside the ray's interval, was not reported. */
static verdict judge_inside(judge *j, const oracle_ray *ray, const search_hit *hit, const oracle_primitive *p,
                            const verdict_bound *bound, double before) {
    if (is_clamped(j, p)) return VERDICT_LEAK;
    if (value(hit->answer.edge) > bound->edge) return VERDICT_WRONG;
    /* Twice as far, and by some units of a float at least, which the origin is rounded to. A slanted surface
     * is met earlier by its bound, times as much as the ray is moved aside. */
    double aside = fmax(2 * bound->aside, 0x1p-21 * length_f64(widen(ray->org)));
    double limit = isfinite(before) ? before - 2 * bound->t * aside / bound->aside : before;
    if (passes_aside(j, ray, aside, limit)) return VERDICT_EDGE;
    return j->tracer->leaks ? VERDICT_LEAK : VERDICT_WRONG;
}

verdict judge_skip(judge *j, const search_hit *nearest, double before) {
    oracle_ray ray = *j->ray;
    search_hit hit = *nearest;
    for (int trimmed = 0;; ++trimmed) {
        oracle_primitive p = search_primitive(j->world, hit.geometry, hit.primitive, hit.instance);
        if (verdict_beyond(j->tracer, j->world, j->ray, &p, value(hit.answer.t))) return VERDICT_BEYOND;
        verdict_bound bound = verdict_bound_of(j->tracer, j->ray, &p, &hit.answer);
        if (trimmed == 16 || !trim(j, &hit, &bound, &ray))
            return judge_inside(j, &ray, &hit, &p, &bound, before);
        if (!(ray.t_near < ray.t_far)) return VERDICT_RANGE;
        double limit = isfinite(before) ? before - bound.t : before;
        if (judge_nearest(j, &ray) >= limit) return VERDICT_RANGE;
        if (j->failed) return VERDICT_WRONG;
        hit = j->room->ties.items[0];
    }
}

/* ---- what was reported ---- */

void judge_ask(const judge *j, const oracle_primitive *p, double t, oracle_answer *out) {
    oracle_ask(j->ray, p, ORACLE_FAST, out);
    if (out->parallel || p->shape != ORACLE_SPHERE || !out->line) return;
    double here = value(out->t), other = value(out->other);
    if (fabs(t - here) <= fabs(t - other)) return;
    /* The oracle answers with the smaller root of the whole line: of the line run backwards that is the
     * larger one. (A bound between both roots need not exist in float.) */
    bool larger = other > here;
    oracle_ray ray = *j->ray;
    ray.t_near = -INFINITY, ray.t_far = INFINITY;
    if (larger) ray.dir = neg_f32(ray.dir);
    oracle_answer whole;
    oracle_ask(&ray, p, ORACLE_FAST, &whole);
    *out = whole;
    if (larger) {
        out->t = ball_neg(whole.t), out->other = ball_neg(whole.other);
        out->part = 1 - whole.part;
    }
    /* In the interval that was asked for. */
    out->above_near.value = out->t.value - (real_f128)j->ray->t_near;
    out->below_far.value = (real_f128)j->ray->t_far - out->t.value;
    out->hit = out->above_near.value > 0 && out->below_far.value > 0;
}

verdict judge_meeting(const judge *j, const oracle_primitive *p, const oracle_answer *a, double t,
                      verdict_bound *bound) {
    /* In its plane a ray exactly misses, but it is as good as on a ray through it. */
    if (a->parallel) return verdict_in_plane(j->tracer, j->ray, p) ? VERDICT_EDGE : VERDICT_WRONG;
    *bound = verdict_bound_of(j->tracer, j->ray, p, a);
    if (!a->line && value(a->edge) < -bound->edge) return VERDICT_WRONG;
    if (fabs(t - value(a->t)) > verdict_reported(j->tracer, p, bound)) return VERDICT_WRONG;
    if (!a->line) return VERDICT_EDGE;
    if (a->hit) return VERDICT_AGREE;
    return value(a->above_near) >= -bound->t && value(a->below_far) >= -bound->t ? VERDICT_RANGE
                                                                                 : VERDICT_WRONG;
}
