/* Checks hits: skipped hits, reported hits, closest hits and any hits. */
#include "verify/verdict/verdict.h"
#include "trace/trace.h"

#include <float.h>

#define ASIDE_RINGS 5

const char *verdict_name(verdict v) {
    static const char *const names[VERDICT_COUNT] = {"agree",       "tie",    "edge", "range",
                                                     "conditioned", "beyond", "leak", "wrong"};
    return names[v];
}

verdict_tracer verdict_tracer_of(const trace_spec *spec, double unit) {
    bool embree = spec->kind == TRACE_EMBREE;
    bool own = embree && spec->shapes != TRACE_SHAPES_USER;
    bool quads = own && spec->flags == TRACE_SCENE_ROBUST;
    unsigned seen = (own ? 1u << ORACLE_TRIANGLE : 0) | (quads ? 1u << ORACLE_QUAD : 0);
    return (verdict_tracer){.unit = unit,
                            .seen = seen,
                            .inverted = embree,
                            .leaks = embree,
                            .strict = true,
                            .clamped = embree ? 1e-18 : 0,
                            .largest = embree ? 1.844e18 / 2 : 0};
}

typedef struct judge {
    const search *search;
    const world *world;
    const verdict_tracer *tracer;
    const oracle_ray *ray;
    search_result *room;
    bool shadows;               /* only shapes that cast shadows */
    bool failed;                /* out of memory */
    const verdict_answer *said; /* the hit reported instead of the nearest one; NULL: none */
} judge;

static double value(real_f128 x) { return (double)x; }

/* The exact t of the nearest hit, infinite for a miss. Leaves the hit in `room`. */
static double judge_nearest(judge *j, const oracle_ray *ray) {
    bool done = j->shadows ? search_shadow(j->search, ray, j->room) : search_closest(j->search, ray, j->room);
    if (!done) {
        j->failed = true;
        return (double)INFINITY;
    }
    return j->room->ties.count ? value(j->room->ties.items[0].answer.t) : (double)INFINITY;
}

static oracle_primitive primitive_of(const judge *j, const search_hit *hit) {
    return search_primitive(j->world, hit->geometry, hit->primitive, hit->instance);
}

/* ---- skipped hits ---- */

static bool same_primitive(const search_hit *hit, const verdict_answer *a) {
    return hit->geometry == a->geometry && hit->primitive == a->primitive && hit->instance == a->instance;
}

/* The ray moved perpendicular to itself, in one of eight directions, by a fraction of `by` for each ring. */
static oracle_ray moved_aside(const oracle_ray *ray, double by, int k) {
    static const double parts[ASIDE_RINGS] = {1, 0.5, 0.25, 0.75, 0.12};
    vec3_f64 d = normalize_f64(widen(ray->dir));
    vec3_f64 other = fabs(d.x) < 0.6 ? vec_f64(1, 0, 0) : vec_f64(0, 1, 0);
    vec3_f64 x = normalize_f64(cross_f64(d, other)), y = cross_f64(d, x);
    int ring = k / 8;
    double angle = k * 0.7853981633974483 + 0.2 + 0.31 * ring, far = by * parts[ring];
    vec3_f64 aside = add_f64(scale_f64(far * cos(angle), x), scale_f64(far * sin(angle), y));
    oracle_ray out = *ray;
    out.org = narrow(add_f64(widen(ray->org), aside));
    return out;
}

/* The origin moved by one ulp or none in each coordinate: neighbour `k` of 27. */
static oracle_ray moved_by_floats(const oracle_ray *ray, int k) {
    oracle_ray out = *ray;
    float *part[3] = {&out.org.x, &out.org.y, &out.org.z};
    for (int i = 0; i < 3; ++i, k /= 3) {
        if (k % 3) *part[i] = nextafterf(*part[i], k % 3 == 1 ? INFINITY : -INFINITY);
    }
    return out;
}

/* True when the nearest hit is the reported one, or the tracer's floats cannot represent it. */
static bool is_fair(const judge *j, const oracle_ray *ray) {
    const search_hit *hit = &j->room->ties.items[0];
    oracle_primitive p = primitive_of(j, hit);
    if (verdict_beyond(j->tracer, j->world, ray, &p, value(hit->answer.t))) return true;
    return j->said && same_primitive(hit, j->said);
}

/* True when the moved ray hits nothing before `before`, or is_fair() for its nearest hit. */
static bool passes(judge *j, const oracle_ray *ray, double before) {
    if (!finite_f32(ray->org)) return true;
    double t = judge_nearest(j, ray);
    return t >= before || (t < (double)INFINITY && is_fair(j, ray));
}

/* True when some ray that the precision cannot distinguish from this one passes. If the surface continues
 * beyond the edge, all these rays hit. Few of them pass a thin part, so there are several rings. */
static bool passes_aside(judge *j, const oracle_ray *from, double by, double before) {
    for (int k = 0; k < 8 * ASIDE_RINGS; ++k) {
        oracle_ray ray = moved_aside(from, by, k);
        if (passes(j, &ray, before)) return true;
    }
    for (int k = 1; k < 27; ++k) {
        oracle_ray ray = moved_by_floats(from, k);
        if (passes(j, &ray, before)) return true;
    }
    return false;
}

/* If the hit lies within its error bound of an end of the queried interval, shortens the interval to exclude
 * it. */
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

/* Embree's rcp_safe() clamps direction components to at least 1e-18 in box tests. For these tests this
 * rotates the ray. If the whole direction is that small, the rotation exceeds rounding; in world space it
 * never is (trace/stretch.h). */
static bool is_clamped(const judge *j, const oracle_primitive *p) {
    if (!p->instance) return false;
    const affine_f64 to_object = affine_widen(p->instance->to_object);
    const vec3_f32 unit = narrow(normalize_f64(widen(j->ray->dir)));
    const vec3_f32 d = narrow(affine_vector(&to_object, widen(unit)));
    double clamped = j->tracer->clamped, least = clamped / j->tracer->unit;
    double part[3] = {fabs((double)d.x), fabs((double)d.y), fabs((double)d.z)};
    double most = fmax(part[0], fmax(part[1], part[2])), small = fmin(part[0], fmin(part[1], part[2]));
    return most < least && small < clamped;
}

/* The verdict for a hit that lies well inside the interval but was not reported. */
static verdict judge_inside(judge *j, const oracle_ray *ray, const search_hit *hit, const oracle_primitive *p,
                            const verdict_bound *bound, double before) {
    if (is_clamped(j, p)) return VERDICT_LEAK;
    if (value(hit->answer.edge) > bound->edge) return VERDICT_WRONG;
    /* Twice as far, and at least some ulps, because the origin is rounded to float. A slanted surface is then
     * hit earlier, by its bound times the ratio of the displacement to bound->aside. */
    double aside = fmax(2 * bound->aside, 0x1p-21 * length_f64(widen(ray->org)));
    double limit = isfinite(before) ? before - 2 * bound->t * aside / bound->aside : before;
    if (passes_aside(j, ray, aside, limit)) return VERDICT_EDGE;
    return j->tracer->leaks ? VERDICT_LEAK : VERDICT_WRONG;
}

/* The verdict for the exact nearest hit `nearest`, which was not reported. The tracer reported nothing before
 * `before` (infinite: a miss). */
static verdict judge_skip(judge *j, const search_hit *nearest, double before) {
    oracle_ray ray = *j->ray;
    search_hit hit = *nearest;
    for (int trimmed = 0;; ++trimmed) {
        oracle_primitive p = primitive_of(j, &hit);
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

/* ---- reported hits ---- */

/* The exact intersection nearest to t; for a sphere, with the root that the tracer used. */
static void judge_ask(const judge *j, const oracle_primitive *p, double t, oracle_answer *out) {
    oracle_ask(j->ray, p, out);
    if (out->parallel || p->shape != ORACLE_SPHERE || !out->line) return;
    double here = value(out->t), other = value(out->other);
    if (fabs(t - here) <= fabs(t - other)) return;
    /* For the whole line, the oracle gives the smaller root. To get the larger one, reverse the direction. (A
     * float t_near between both roots may not exist.) */
    bool larger = other > here;
    oracle_ray ray = *j->ray;
    ray.t_near = -INFINITY, ray.t_far = INFINITY;
    if (larger) ray.dir = neg_f32(ray.dir);
    oracle_answer whole;
    oracle_ask(&ray, p, &whole);
    *out = whole;
    if (larger) {
        out->t = -whole.t, out->other = -whole.other;
        out->part = 1 - whole.part;
    }
    /* Check against the queried interval. */
    out->above_near = out->t - (real_f128)j->ray->t_near;
    out->below_far = (real_f128)j->ray->t_far - out->t;
    out->hit = out->above_near > 0 && out->below_far > 0;
}

/* The verdict for a hit of the primitive at t, by itself: AGREE if the exact ray hits, EDGE or RANGE if
 * rounding explains it, else WRONG. `a`: from judge_ask(). */
static verdict judge_meeting(const judge *j, const oracle_primitive *p, const oracle_answer *a, double t,
                             verdict_bound *bound) {
    /* A ray exactly in the plane misses, but rounding cannot distinguish it from one through the plane. */
    if (a->parallel) return verdict_in_plane(j->tracer, j->ray, p) ? VERDICT_EDGE : VERDICT_WRONG;
    *bound = verdict_bound_of(j->tracer, j->ray, p, a);
    if (!a->line && value(a->edge) < -bound->edge) return VERDICT_WRONG;
    if (fabs(t - value(a->t)) > verdict_reported(j->tracer, p, bound)) return VERDICT_WRONG;
    if (!a->line) return VERDICT_EDGE;
    if (a->hit) return VERDICT_AGREE;
    return value(a->above_near) > -bound->t && value(a->below_far) > -bound->t ? VERDICT_RANGE
                                                                               : VERDICT_WRONG;
}

/* ---- closest hit ---- */

static bool names_primitive(const world *w, const verdict_answer *a) {
    if (a->geometry == TRACE_PLANE) return a->primitive < w->planes.count;
    if (a->geometry >= w->geometries.count) return false;
    if (a->instance != FATHOM_NONE && a->instance >= w->instances.count) return false;
    uint32_t group = a->instance == FATHOM_NONE ? 0 : w->instances.items[a->instance].group;
    const world_group *g = &w->groups.items[group];
    return a->geometry - g->first < g->count && a->primitive < w->geometries.items[a->geometry].count;
}

/* The other root of a sphere is another hit, unless the roots are equal. */
static bool is_tie(const search_hit *hit, const verdict_answer *said, oracle_shape shape,
                   const oracle_answer *a) {
    bool same_root =
        shape != ORACLE_SPHERE || hit->answer.part == a->part || value(hit->answer.t) == value(a->t);
    return same_primitive(hit, said) && same_root;
}

static verdict judge_tie(const judge *j, const verdict_answer *a, double exact) {
    if (!same_primitive(&j->room->ties.items[0], a)) return VERDICT_TIE;
    bool close = fabs(a->t - exact) <= verdict_rounding(j->tracer, exact);
    return close ? VERDICT_AGREE : VERDICT_CONDITIONED;
}

/* Fathom's own shapes and plug-ins use the open interval; Embree's own shapes may include its ends. */
static bool in_interval(const judge *j, const oracle_primitive *p, const verdict_answer *said) {
    double near = (double)j->ray->t_near, far = (double)j->ray->t_far;
    if (!j->tracer->strict || j->tracer->seen >> p->shape & 1) return said->t >= near && said->t <= far;
    bool above = said->t > near || (said->t == near && said->t_low > 0);
    return above && (said->t < far || (said->t == far && said->t_low < 0));
}

static verdict judge_hit(judge *j, const verdict_answer *said, verdict_report *out) {
    const oracle_ray *ray = j->ray;
    if (!names_primitive(j->world, said)) return VERDICT_WRONG;
    oracle_primitive p = search_primitive(j->world, said->geometry, said->primitive, said->instance);
    if (!in_interval(j, &p, said)) return VERDICT_WRONG;
    oracle_answer a;
    verdict_bound bound = {.t = 0};
    judge_ask(j, &p, said->t, &a);
    out->measured = !a.parallel && a.line;
    if (out->measured) {
        out->exact_t = value(a.t),
        out->t_signed = (double)((real_f128)said->t + (real_f128)said->t_low - a.t);
        out->t_error = fabs(out->t_signed);
        out->condition = oracle_condition(ray, &p, &a, j->tracer->inverted);
        out->primitive = p, out->exact = a;
    }
    verdict met = judge_meeting(j, &p, &a, said->t, &bound);
    if (met == VERDICT_WRONG) {
        double t = a.parallel ? said->t : value(a.t);
        return verdict_beyond(j->tracer, j->world, ray, &p, t) ? VERDICT_BEYOND : VERDICT_WRONG;
    }
    (void)judge_nearest(j, ray);
    const search_result *ties = j->room;
    if (!ties->ties.count) return met;
    search_hit first = ties->ties.items[0];
    for (size_t i = 0; i < ties->ties.count && met == VERDICT_AGREE; ++i) {
        if (is_tie(&ties->ties.items[i], said, p.shape, &a)) return judge_tie(j, said, value(a.t));
    }
    oracle_primitive q = primitive_of(j, &first);
    verdict_bound nearer = verdict_bound_of(j->tracer, ray, &q, &first.answer);
    double reported = a.parallel ? said->t : value(a.t);
    if (value(first.answer.t) >= reported - bound.t - nearer.t) {
        if (met != VERDICT_AGREE) return met;
        return same_primitive(&first, said) ? VERDICT_CONDITIONED : VERDICT_TIE;
    }
    j->said = said;
    return judge_skip(j, &first, reported - bound.t);
}

static verdict judge_miss(judge *j) {
    (void)judge_nearest(j, j->ray);
    if (!j->room->ties.count) return VERDICT_AGREE;
    search_hit first = j->room->ties.items[0];
    return judge_skip(j, &first, (double)INFINITY);
}

bool verdict_closest(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                     const verdict_answer *answer, search_result *room, verdict_report *out) {
    judge j = {s, w, tracer, ray, room, false, false, NULL};
    *out = (verdict_report){.measured = false};
    out->verdict = answer->geometry == FATHOM_NONE ? judge_miss(&j) : judge_hit(&j, answer, out);
    return !j.failed;
}

/* ---- any hit, of all shapes that cast a shadow ---- */

/* The verdict if the tracer hit this primitive somewhere in the interval, although the exact ray does not.
 * Checks both ends of the interval, for both roots of a sphere. */
static verdict judge_candidate(const judge *j, const search_candidate *c) {
    oracle_primitive p = search_primitive(j->world, c->geometry, c->primitive, c->instance);
    const double ends[2] = {(double)j->ray->t_near, fmin((double)j->ray->t_far, (double)FLT_MAX)};
    verdict best = VERDICT_WRONG;
    for (int i = 0; i < 2; ++i) {
        oracle_answer a;
        verdict_bound bound;
        judge_ask(j, &p, ends[i], &a);
        verdict met = judge_meeting(j, &p, &a, (double)a.t, &bound);
        double t = (double)a.t, far = (double)j->ray->t_far;
        bool within = a.parallel || (t - ends[0] > -bound.t && far - t > -bound.t);
        if (met != VERDICT_WRONG && within) return met == VERDICT_AGREE ? VERDICT_RANGE : met;
        if (!a.parallel && a.line && verdict_beyond(j->tracer, j->world, j->ray, &p, t))
            best = VERDICT_BEYOND;
    }
    return best;
}

static bool casts(const world *w, const verdict_answer *a) {
    if (!names_primitive(w, a)) return false;
    unsigned flags = a->geometry == TRACE_PLANE ? w->planes.items[a->primitive].flags
                                                : w->geometries.items[a->geometry].flags;
    return !(flags & FATHOM_CASTS_NO_SHADOW);
}

/* True when this primitive casts a shadow and the exact ray hits it. */
static bool is_met(const judge *j, const verdict_answer *a) {
    if (!casts(j->world, a)) return false;
    oracle_primitive p = search_primitive(j->world, a->geometry, a->primitive, a->instance);
    oracle_answer answer;
    oracle_ask(j->ray, &p, &answer);
    return answer.hit;
}

/* The verdict for a reported hit that does not exist exactly. */
static verdict judge_phantom(judge *j, const verdict_answer *hint) {
    if (hint && casts(j->world, hint)) {
        search_candidate c = {hint->geometry, hint->primitive, hint->instance, 0};
        verdict one = judge_candidate(j, &c);
        if (one != VERDICT_WRONG) return one;
    }
    double aside = verdict_aside(j->tracer, j->world, j->ray, search_extent(j->search));
    if (!search_near(j->search, j->ray, aside, j->room)) {
        j->failed = true;
        return VERDICT_WRONG;
    }
    verdict best = VERDICT_WRONG;
    for (size_t i = 0; i < j->room->candidates.count; ++i) {
        verdict one = judge_candidate(j, &j->room->candidates.items[i]);
        if (one < best) best = one;
    }
    return best;
}

bool verdict_any(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                 bool met, const verdict_answer *hint, search_result *room, verdict *out) {
    judge j = {s, w, tracer, ray, room, true, false, NULL};
    *out = VERDICT_AGREE;
    if (met && hint && is_met(&j, hint)) return true; /* without a search */
    bool exact = isfinite(judge_nearest(&j, ray));
    if (exact && !met) {
        search_hit first = room->ties.items[0];
        *out = judge_skip(&j, &first, (double)INFINITY);
    } else if (met && !exact) {
        *out = judge_phantom(&j, hint);
    }
    return !j.failed;
}
