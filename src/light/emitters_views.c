/* Regions of surfaces, each with a view of the finite lights: the factors that emitters_seen.c has found, and
 * a list of lights. A traversal from a list takes less time than one from a cut that is made for each point.
 */
#include "light/emitters_inner.h"

#include <stdlib.h>
#include <string.h>

/* The number of points of a region that gets a list. */
#define LEAST_POINTS 32u
#define MOST_POINTS 4096u
#define MOST_DEPTH 24u

const tree_view *emitters_find_view(const emitters *e, vec3_f32 p, vec3_f32 n) {
    const float at[6] = {p.x, p.y, p.z, n.x, n.y, n.z};
    return &e->views.items[region_find(e->views.splits.items, e->views.root, at, 1)];
}

void emitters_forget_views(emitters *e) {
    for (size_t k = 0; k < e->views.count; ++k) tree_view_destroy(&e->views.items[k]);
    array_free(&e->views);
    array_free(&e->views.splits);
}

/* Points and normals of scout paths in a region. */
typedef struct point_span {
    float (*at)[6];
    size_t count;
} point_span;

typedef struct view_pupil {
    emitters *e;
    float scales[6];
    bool fails; /* out of memory */
} view_pupil;

/* These return the region or its parts, as region_split.below. */

static uint32_t add_view(view_pupil *p, tree_view view) {
    emitter_views *views = &p->e->views;
    if (array_push(views, view)) return REGION_LEAF + (uint32_t)views->count - 1;
    tree_view_destroy(&view);
    p->fails = true;
    return REGION_LEAF;
}

static uint32_t add_split(view_pupil *p, region_split split) {
    if (array_push(&p->e->views.splits, split)) return (uint32_t)p->e->views.splits.count - 1;
    p->fails = true;
    return REGION_LEAF;
}

/* Halves a region until the lights of a list matter at all of its points. */
static uint32_t divide(view_pupil *p, point_span span, tree_factors factors, unsigned depth) {
    const tree *lights = &p->e->lights;
    tree_view view = {.factors = factors};
    if (lights->count > 1 && span.count >= LEAST_POINTS && span.count <= MOST_POINTS)
        p->fails |= !tree_view_list(lights, (const float(*)[6])span.at, span.count, &view);
    if (lights->count < 2 || view.near_count || p->fails || span.count < 2 * LEAST_POINTS ||
        depth == MOST_DEPTH)
        return add_view(p, view);
    const region_items items = {span.at, sizeof *span.at, span.count};
    region_split split = region_choose(&items, 6, p->scales);
    const size_t below = region_part(&items, &split);
    if (!below || below == span.count) return add_view(p, view);
    split.below = divide(p, (point_span){span.at, below}, factors, depth + 1);
    split.above = divide(p, (point_span){span.at + below, span.count - below}, factors, depth + 1);
    return add_split(p, split);
}

/* Follows the regions of factors. */
static uint32_t follow(view_pupil *p, point_span span, uint32_t at) {
    const emitter_seen *seen = &p->e->seen;
    if (at & REGION_LEAF) return divide(p, span, emitters_table(p->e, at & ~REGION_LEAF), 0);
    region_split split = seen->splits[at];
    const size_t below = region_part(&(region_items){span.at, sizeof *span.at, span.count}, &split);
    split.below = follow(p, (point_span){span.at, below}, split.below);
    split.above = follow(p, (point_span){span.at + below, span.count - below}, split.above);
    return add_split(p, split);
}

bool emitters_learn_views(emitters *e, const emitter_lesson *from) {
    view_pupil p = {.e = e};
    point_span all = {.count = from->glance_count};
    if (!all.count || (!e->seen.tables && e->lights.count < 2)) return true;
    all.at = malloc(all.count * sizeof *all.at);
    if (!all.at) return false;
    for (size_t k = 0; k < all.count; ++k) memcpy(all.at[k], from->glances[k].at, sizeof *all.at);
    region_scales(&(region_items){all.at, sizeof *all.at, all.count}, p.scales);
    e->views.root = follow(&p, all, e->seen.tables ? e->seen.root : REGION_LEAF);
    free(all.at);
    return !p.fails;
}
