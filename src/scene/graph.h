/* The scene's groups as a graph. */
#pragma once

#include "scene/scene.h"

/* Items of group g: items[first[g]] up to items[first[g + 1]]. */
typedef struct graph_lists {
    uint32_t *first; /* groups + 1 */
    uint32_t *items;
} graph_lists;

typedef struct scene_graph {
    graph_lists objects;   /* object ids by group */
    graph_lists instances; /* instance ids by parent */
    uint32_t *order;       /* groups that the root reaches, each before the groups in it; the root first */
    uint32_t order_count;
    bool *absent; /* by object: it is in no geometry; see mesh/absent.h */
} scene_graph;

/* FATHOM_BAD_INPUT on a cycle; the message names its groups. Release with graph_destroy(). */
fathom_status graph_create(const fathom_scene *scene, scene_graph *out);
void graph_destroy(scene_graph *graph);

/* Gets the bounds, unless they are empty, of an object of the group, or of an instance: FATHOM_NONE. */
typedef void (*graph_met_fn)(void *user, uint32_t group, fathom_id object, const scene_bounds *bounds);
/* The bounds of each group that the root reaches, in the group's own coordinates; release with free(). Absent
 * objects have none. `of`: scene_object_bounds() or scene_framed_bounds(). Unless it is NULL, met() is called
 * for what is in each group, one group after the other. */
fathom_status graph_bounds(const fathom_scene *scene, const scene_graph *graph,
                           scene_bounds (*of)(const fathom_scene *scene, fathom_id object), graph_met_fn met,
                           void *user, scene_bounds **out);

/* Counts the paths from the root to each group, and returns their sum. `placements` has one entry per group,
 * all 0 at first. The counts are double, so that huge ones do not wrap. */
double graph_count_placements(const fathom_scene *scene, const scene_graph *graph, double *placements);
