#include "verify/verdict/verdict.h"
#include "trace/trace.h"
#include "verify/verdict/verdict_judge.h"

const char *verdict_name(verdict v) {
    static const char *const names[VERDICT_COUNT] = {"agree",       "tie",    "edge", "range",
                                                     "conditioned", "beyond", "leak", "wrong"};
    return names[v];
}

/* The textbook's forms round each triangle's edges by itself, so rays pass between neighbours. */
verdict_tracer verdict_tracer_of(const trace_spec *spec, double unit) {
    bool embree = spec->kind == TRACE_EMBREE;
    bool textbook = spec->kind == TRACE_LINEAR && spec->form == TRACE_TEXTBOOK;
    bool own = embree && spec->shapes != TRACE_SHAPES_USER;
    bool quads = own && (spec->shapes == TRACE_SHAPES_QUAD || spec->flags == TRACE_SCENE_ROBUST);
    unsigned seen = (own ? 1u << ORACLE_TRIANGLE : 0) | (quads ? 1u << ORACLE_QUAD : 0);
    return (verdict_tracer){.unit = unit,
                            .seen = seen,
                            .inverted = embree,
                            .leaks = embree || textbook,
                            .textbook = textbook,
                            .clamped = embree ? 1e-18 : 0,
                            .largest = embree ? 1.844e18 / 2 : 0};
}

static double value(ball b) { return (double)b.value; }

bool verdict_names_primitive(const world *w, const verdict_answer *a) {
    if (a->geometry == TRACE_PLANE) return a->primitive < w->planes.count;
    if (a->geometry >= w->geometries.count) return false;
    if (a->instance != FATHOM_NONE && a->instance >= w->instances.count) return false;
    uint32_t group = a->instance == FATHOM_NONE ? 0 : w->instances.items[a->instance].group;
    const world_group *g = &w->groups.items[group];
    return a->geometry - g->first < g->count && a->primitive < w->geometries.items[a->geometry].count;
}

static bool same_primitive(const search_hit *hit, const verdict_answer *a) {
    return hit->geometry == a->geometry && hit->primitive == a->primitive && hit->instance == a->instance;
}

/* A sphere's other root is another hit, unless they coincide. */
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

static verdict judge_hit(judge *j, const verdict_answer *said, verdict_report *out) {
    const oracle_ray *ray = j->ray;
    if (!verdict_names_primitive(j->world, said)) return VERDICT_WRONG;
    if (!(said->t >= (double)ray->t_near && said->t <= (double)ray->t_far)) return VERDICT_WRONG;
    oracle_primitive p = search_primitive(j->world, said->geometry, said->primitive, said->instance);
    oracle_answer a;
    verdict_bound bound = {0, 0, 0};
    judge_ask(j, &p, said->t, &a);
    out->measured = !a.parallel && a.line;
    if (out->measured) {
        out->exact_t = value(a.t),
        out->t_error = fabs((double)(a.t.value - said->t - (real_f128)said->t_low));
        out->condition = j->tracer->inverted ? a.inverted.t : a.condition.t;
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
    oracle_primitive q = search_primitive(j->world, first.geometry, first.primitive, first.instance);
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
