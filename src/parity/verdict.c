#include "parity/verdict.h"
#include "parity/verdict_bound.h"
#include "trace/trace.h"

#include <string.h>

/* One answer on its way to a verdict. */
typedef struct judge {
    const search *search;
    const world *world;
    const verdict_tracer *tracer;
    const oracle_ray *ray;
    search_result *room;
    bool failed; /* out of memory */
} judge;

const char *verdict_name(verdict v) {
    static const char *const names[VERDICT_COUNT] = {"agree",       "tie",    "edge", "range",
                                                     "conditioned", "beyond", "leak", "wrong"};
    return names[v];
}

verdict_tracer verdict_tracer_of(const trace_spec *spec, double unit) {
    bool embree = spec->kind == TRACE_EMBREE;
    return (verdict_tracer){.unit = unit,
                            .inverted = embree,
                            .leaks = embree,
                            .clamped = embree ? 1e-18 : 0,
                            .largest = embree ? 1.844e18 / 2 : 0};
}

static double value(ball b) { return (double)b.value; }

/* The exact t of the nearest hit, infinite for a miss. */
static double nearest(judge *j, const oracle_ray *ray) {
    if (!search_closest(j->search, ray, j->room)) {
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

/* Whether a ray that the precision cannot tell from this one meets nothing before t. A surface that goes on
 * beyond the edge is met on all sides. */
static bool passes_aside(judge *j, double by, double before) {
    for (int k = 0; k < 8; ++k) {
        oracle_ray ray = moved_aside(j->ray, by, k);
        if (!finite_f32(ray.org)) return true;
        if (nearest(j, &ray) >= before) return true;
    }
    return false;
}

/* Whether nothing is met before t by a ray whose interval leaves out what lies at its ends. */
static bool passes_in_range(judge *j, const search_hit *hit, const verdict_bound *bound, double before) {
    oracle_ray ray = *j->ray;
    double t = value(hit->answer.t);
    if (value(hit->answer.above_near) <= bound->t)
        ray.t_near = nextafterf((float)(t + bound->t), INFINITY);
    else if (value(hit->answer.below_far) <= bound->t)
        ray.t_far = nextafterf((float)(t - bound->t), -INFINITY);
    else
        return false;
    return !(ray.t_near < ray.t_far) || nearest(j, &ray) >= before;
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

/* Why `hit`, exactly the nearest, was not reported; the tracer saw nothing before t (infinite: at all). */
static verdict judge_skip(judge *j, const search_hit *hit, double before) {
    oracle_primitive p = search_primitive(j->world, hit->geometry, hit->primitive, hit->instance);
    if (verdict_beyond(j->tracer, j->world, j->ray, &p, value(hit->answer.t))) return VERDICT_BEYOND;
    verdict_bound bound = verdict_bound_of(j->tracer, j->ray, &p, &hit->answer);
    /* A slanted surface is met earlier by its bound, times as much as the ray is moved aside. */
    if (passes_in_range(j, hit, &bound, isfinite(before) ? before - bound.t : before)) return VERDICT_RANGE;
    if (is_clamped(j, &p)) return VERDICT_LEAK;
    if (value(hit->answer.edge) > bound.edge) return VERDICT_WRONG;
    /* Twice as far, and by some units of a float at least, which the origin is rounded to. */
    double aside = fmax(2 * bound.aside, 0x1p-21 * length_f64(widen(j->ray->org)));
    if (passes_aside(j, aside, isfinite(before) ? before - 2 * bound.t * aside / bound.aside : before))
        return VERDICT_EDGE;
    return j->tracer->leaks ? VERDICT_LEAK : VERDICT_WRONG;
}

/* ---- what was reported ---- */

static bool names_primitive(const world *w, const verdict_answer *a) {
    if (a->geometry == TRACE_PLANE) return a->primitive < w->planes.count;
    if (a->geometry >= w->geometries.count) return false;
    if (a->instance != FATHOM_NONE && a->instance >= w->instances.count) return false;
    uint32_t group = a->instance == FATHOM_NONE ? 0 : w->instances.items[a->instance].group;
    const world_group *g = &w->groups.items[group];
    return a->geometry - g->first < g->count && a->primitive < w->geometries.items[a->geometry].count;
}

/* The exact intersection nearest to the tracer's t: of a sphere, of the root that it took. */
static void ask_nearest(const judge *j, const oracle_primitive *p, double t, oracle_answer *out) {
    oracle_ask(j->ray, p, ORACLE_FAST, out);
    if (out->parallel || p->shape != ORACLE_SPHERE || !out->line) return;
    double here = value(out->t), other = value(out->other);
    if (fabs(t - here) <= fabs(t - other)) return;
    oracle_ray ray = *j->ray;
    float middle = (float)((here + other) / 2);
    ray.t_near = other > here ? middle : -INFINITY;
    ray.t_far = other > here ? INFINITY : middle;
    oracle_answer narrowed;
    oracle_ask(&ray, p, ORACLE_FAST, &narrowed);
    if (!narrowed.hit) return;
    *out = narrowed;
    /* In the interval that was asked for. */
    out->above_near.value = out->t.value - (real_f128)j->ray->t_near;
    out->below_far.value = (real_f128)j->ray->t_far - out->t.value;
    out->hit = out->above_near.value > 0 && out->below_far.value > 0;
}

/* Whether the reported primitive may be met at that t at all; AGREE: it is, exactly. */
static verdict judge_meeting(const judge *j, const oracle_primitive *p, const oracle_answer *a, double t,
                             verdict_bound *bound) {
    /* In its plane a ray exactly misses, but it is as good as on a ray through it. */
    if (a->parallel) return verdict_in_plane(j->tracer, j->ray, p) ? VERDICT_EDGE : VERDICT_WRONG;
    *bound = verdict_bound_of(j->tracer, j->ray, p, a);
    if (!a->line && value(a->edge) < -bound->edge) return VERDICT_WRONG;
    if (fabs(t - value(a->t)) > bound->t) return VERDICT_WRONG;
    if (!a->line) return VERDICT_EDGE;
    if (a->hit) return VERDICT_AGREE;
    return value(a->above_near) >= -bound->t && value(a->below_far) >= -bound->t ? VERDICT_RANGE
                                                                                 : VERDICT_WRONG;
}

static bool is_tie(const search_hit *hit, const verdict_answer *a) {
    return hit->geometry == a->geometry && hit->primitive == a->primitive && hit->instance == a->instance;
}

static verdict judge_tie(const judge *j, const verdict_answer *a, double exact) {
    if (!is_tie(&j->room->ties.items[0], a)) return VERDICT_TIE;
    bool close = fabs(a->t - exact) <= verdict_rounding(j->tracer, exact);
    return close ? VERDICT_AGREE : VERDICT_CONDITIONED;
}

static verdict judge_hit(judge *j, const verdict_answer *said, verdict_report *out) {
    const oracle_ray *ray = j->ray;
    if (!names_primitive(j->world, said)) return VERDICT_WRONG;
    if (!(said->t >= (double)ray->t_near && said->t <= (double)ray->t_far)) return VERDICT_WRONG;
    oracle_primitive p = search_primitive(j->world, said->geometry, said->primitive, said->instance);
    oracle_answer a;
    verdict_bound bound = {0, 0, 0};
    ask_nearest(j, &p, said->t, &a);
    out->measured = !a.parallel && a.line;
    if (out->measured) {
        out->exact_t = value(a.t), out->t_error = (double)fabsl((long double)(a.t.value - said->t));
        out->condition = j->tracer->inverted ? a.inverted.t : a.condition.t;
    }
    verdict met = judge_meeting(j, &p, &a, said->t, &bound);
    if (met == VERDICT_WRONG) {
        bool beyond = out->measured && verdict_beyond(j->tracer, j->world, ray, &p, out->exact_t);
        return beyond ? VERDICT_BEYOND : VERDICT_WRONG;
    }
    (void)nearest(j, ray);
    const search_result *ties = j->room;
    if (!ties->ties.count) return met;
    search_hit first = ties->ties.items[0];
    for (size_t i = 0; i < ties->ties.count && met == VERDICT_AGREE; ++i) {
        if (is_tie(&ties->ties.items[i], said)) return judge_tie(j, said, value(a.t));
    }
    oracle_primitive q = search_primitive(j->world, first.geometry, first.primitive, first.instance);
    verdict_bound nearer = verdict_bound_of(j->tracer, ray, &q, &first.answer);
    double reported = a.parallel ? said->t : value(a.t);
    if (value(first.answer.t) >= reported - bound.t - nearer.t)
        return met == VERDICT_AGREE ? VERDICT_TIE : met;
    return judge_skip(j, &first, reported - bound.t);
}

static verdict judge_miss(judge *j) {
    (void)nearest(j, j->ray);
    if (!j->room->ties.count) return VERDICT_AGREE;
    search_hit first = j->room->ties.items[0];
    return judge_skip(j, &first, (double)INFINITY);
}

bool verdict_closest(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                     const verdict_answer *answer, search_result *room, verdict_report *out) {
    judge j = {s, w, tracer, ray, room, false};
    *out = (verdict_report){.measured = false};
    out->verdict = answer->geometry == FATHOM_NONE ? judge_miss(&j) : judge_hit(&j, answer, out);
    return !j.failed;
}
