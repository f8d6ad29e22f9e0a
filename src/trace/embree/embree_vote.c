#include "trace/embree/embree_vote.h"

#include <string.h>

void embree_vote_begin(embree_vote *vote, const embree_tracer *tracer, const trace_rays *rays, unsigned lane,
                       float t_far) {
    vote->tracer = tracer;
    search_begin_f32(&vote->search, tracer->base.world, rays, lane, false);
    vote->search.t_max = t_far;
    vote->met.any = vote->offered.any = false;
}

/* True if the primitive is the best so far. */
static bool try_primitive(search_f32 *s, const uint32_t ids[3]) {
    const world_geometry *geometry = &s->world->geometries.items[ids[1]];
    search_enter_f32(s, ids[0]);
    s->at[1] = ids[1];
    search_primitive_f32(s, geometry, ids[2]);
    return s->met && memcmp(s->best_ids, ids, sizeof s->best_ids) == 0;
}

bool embree_vote_reference(const embree_tracer *tracer, const trace_rays *rays, unsigned lane, float t_far,
                           const uint32_t ids[3], float *t) {
    search_f32 search;
    search_begin_f32(&search, tracer->base.world, rays, lane, false);
    search.t_max = t_far;
    if (!try_primitive(&search, ids)) return false;
    *t = search.best.t;
    return true;
}

/* True when the reference intersector hits a sphere well before Embree's t. Then Embree's rounding has put
 * the near root before the interval's start, and it reports the far root, which is a different hit. */
static bool is_far_root(const embree_vote *vote, const embree_offered *c) {
    return vote->tracer->base.world->geometries.items[c->ids[1]].kind == WORLD_SPHERES &&
           vote->search.best.t * EMBREE_HALF_WINDOW < c->t;
}

static void put_to_reference(embree_vote *vote, const embree_offered *c) {
    const search_f32 before = vote->search;
    if (!try_primitive(&vote->search, c->ids)) return;
    if (is_far_root(vote, c))
        vote->search = before;
    else
        vote->met = *c;
}

/* On equal t the first in world order, so that the order of visits does not matter. */
static bool is_nearer(const embree_offered *a, const embree_offered *b) {
    if (a->t != b->t) return a->t < b->t;
    return search_comes_before_f32(a->ids, b->ids) ||
           (memcmp(a->ids, b->ids, sizeof a->ids) == 0 && a->half < b->half);
}

void embree_vote_consider(embree_vote *vote, const float *hit, unsigned n, float t) {
    const uint32_t *id = (const uint32_t *)(const void *)hit;
    embree_offered c = {
        .any = true,
        .t = t,
        .normal = {hit[EMBREE_ROW_NG * n], hit[(EMBREE_ROW_NG + 1) * n], hit[(EMBREE_ROW_NG + 2) * n]},
        .u = hit[EMBREE_ROW_U * n],
        .v = hit[EMBREE_ROW_V * n],
        .ids = {id[EMBREE_ROW_INSTANCE * n], id[EMBREE_ROW_GEOMETRY * n], id[EMBREE_ROW_PRIMITIVE * n]}};
    embree_world_ids(vote->tracer->base.world, 0, &c.ids[0], &c.ids[1]);
    c.half = embree_join_half(vote->tracer, c.ids[1], &c.ids[2], &c.u, &c.v);
    if (!vote->offered.any || is_nearer(&c, &vote->offered)) vote->offered = c;
    /* Embree may report both halves of a quad. */
    bool farther =
        vote->met.any && memcmp(vote->met.ids, c.ids, sizeof c.ids) == 0 && !is_nearer(&c, &vote->met);
    if (!farther) put_to_reference(vote, &c);
}
