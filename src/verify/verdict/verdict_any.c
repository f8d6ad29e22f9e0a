/* Any hit: yes or no, against everything that casts a shadow. */
#include "trace/trace.h"
#include "verify/verdict/verdict_judge.h"

#include <float.h>

/* Whether the primitive may be met anywhere in the interval, though exactly it is not: a sphere's roots lie
 * at either end. */
static verdict judge_candidate(const judge *j, const search_candidate *c) {
    oracle_primitive p = search_primitive(j->world, c->geometry, c->primitive, c->instance);
    const double ends[2] = {(double)j->ray->t_near, fmin((double)j->ray->t_far, (double)FLT_MAX)};
    verdict best = VERDICT_WRONG;
    for (int i = 0; i < 2; ++i) {
        oracle_answer a;
        verdict_bound bound;
        judge_ask(j, &p, ends[i], &a);
        verdict met = judge_meeting(j, &p, &a, (double)a.t.value, &bound);
        double t = (double)a.t.value, far = (double)j->ray->t_far;
        bool within = a.parallel || (t - ends[0] >= -bound.t && far - t >= -bound.t);
        if (met != VERDICT_WRONG && within) return met == VERDICT_AGREE ? VERDICT_RANGE : met;
        if (!a.parallel && a.line && verdict_beyond(j->tracer, j->world, j->ray, &p, t))
            best = VERDICT_BEYOND;
    }
    return best;
}

static bool casts(const world *w, const verdict_answer *a) {
    if (!verdict_names_primitive(w, a)) return false;
    unsigned flags = a->geometry == TRACE_PLANE ? w->planes.items[a->primitive].flags
                                                : w->geometries.items[a->geometry].flags;
    return !(flags & FATHOM_CASTS_NO_SHADOW);
}

/* Something is met, they say, and nothing is. */
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
    bool exact = isfinite(judge_nearest(&j, ray));
    *out = VERDICT_AGREE;
    if (exact && !met) {
        search_hit first = room->ties.items[0];
        *out = judge_skip(&j, &first, (double)INFINITY);
    } else if (met && !exact) {
        *out = judge_phantom(&j, hint);
    }
    return !j.failed;
}
