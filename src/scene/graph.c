#include "scene/graph.h"

#include "scene/mesh/absent.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint32_t (*key_fn)(const fathom_scene *scene, size_t item);

static uint32_t object_group(const fathom_scene *scene, size_t i) { return scene->objects.items[i].group; }
static uint32_t instance_parent(const fathom_scene *scene, size_t i) {
    return scene->instances.items[i].parent;
}

/* A counting sort: items keep their order within a group. */
static bool make_lists(const fathom_scene *scene, size_t count, key_fn key, graph_lists *out) {
    size_t groups = scene->groups.count;
    out->first = calloc(groups + 2, sizeof *out->first);
    out->items = malloc((count ? count : 1) * sizeof *out->items);
    if (!out->first || !out->items) return false;
    /* The counts are one slot ahead: the last loop moves first[g + 1] to the end of g, which is the beginning
     * of g + 1. */
    for (size_t i = 0; i < count; ++i) ++out->first[key(scene, i) + 2];
    for (size_t g = 2; g <= groups + 1; ++g) out->first[g] += out->first[g - 1];
    for (size_t i = 0; i < count; ++i) out->items[out->first[key(scene, i) + 1]++] = (uint32_t)i;
    return true;
}

typedef struct walk_step {
    uint32_t group, next; /* next: position in the group's list of instances */
} walk_step;

static fathom_status report_cycle(const fathom_scene *scene, const walk_step *stack, size_t depth,
                                  uint32_t group) {
    char names[1024] = "";
    size_t begin = 0, used = 0;
    while (stack[begin].group != group) ++begin;
    for (size_t i = begin; i <= depth && used < sizeof names - 80; ++i) {
        uint32_t g = i < depth ? stack[i].group : group;
        const char *name = scene->groups.items[g], *arrow = i > begin ? " -> " : "";
        int length = name ? snprintf(names + used, 80, "%s\"%.60s\"", arrow, name)
                          : snprintf(names + used, 80, "%sunnamed group %u", arrow, g);
        used += (size_t)length;
    }
    return fail(scene->context, FATHOM_BAD_INPUT,
                "groups contain each other in a cycle: %s; a group cannot contain itself", names);
}

enum { UNSEEN, OPEN, DONE };

/* Depth-first search from `start`. Finished groups are written to `order` from its end, so that each group
 * comes before the groups in it. */
static fathom_status walk(const fathom_scene *scene, scene_graph *graph, uint32_t start, unsigned char *state,
                          walk_step *stack, uint32_t *place) {
    size_t depth = 1;
    stack[0] = (walk_step){start, graph->instances.first[start]};
    state[start] = OPEN;
    while (depth) {
        walk_step *top = &stack[depth - 1];
        if (top->next == graph->instances.first[top->group + 1]) {
            state[top->group] = DONE;
            graph->order[--*place] = top->group;
            --depth;
            continue;
        }
        uint32_t child = scene->instances.items[graph->instances.items[top->next++]].group;
        if (state[child] == OPEN) return report_cycle(scene, stack, depth, child);
        if (state[child] == UNSEEN) {
            state[child] = OPEN;
            stack[depth++] = (walk_step){child, graph->instances.first[child]};
        }
    }
    return FATHOM_OK;
}

/* Groups that the root does not reach are visited as well, after it, because a cycle among them is an error
 * too. */
static fathom_status sort_groups(const fathom_scene *scene, scene_graph *graph) {
    uint32_t groups = (uint32_t)scene->groups.count, place = groups;
    unsigned char *state = calloc(groups, 1);
    walk_step *stack = malloc(groups * sizeof *stack);
    graph->order = malloc(groups * sizeof *graph->order);
    fathom_status status = state && stack && graph->order ? FATHOM_OK : fail_memory(scene->context, groups);
    if (status == FATHOM_OK) status = walk(scene, graph, FATHOM_ROOT, state, stack, &place);
    const uint32_t first = place;
    for (uint32_t g = 0; g < groups && status == FATHOM_OK; ++g) {
        if (state[g] == UNSEEN) status = walk(scene, graph, g, state, stack, &place);
    }
    if (status == FATHOM_OK) {
        graph->order_count = groups - first;
        memmove(graph->order, graph->order + first, graph->order_count * sizeof *graph->order);
    }
    free(state);
    free(stack);
    return status;
}

fathom_status graph_create(const fathom_scene *scene, scene_graph *out) {
    *out = (scene_graph){.order = NULL};
    fathom_status status = FATHOM_OK;
    if (!make_lists(scene, scene->objects.count, object_group, &out->objects) ||
        !make_lists(scene, scene->instances.count, instance_parent, &out->instances)) {
        status = fail_memory(scene->context, scene->objects.count * sizeof(uint32_t));
    }
    if (status == FATHOM_OK) status = sort_groups(scene, out);
    if (status == FATHOM_OK) status = absent_find(scene, out, &out->absent);
    if (status != FATHOM_OK) graph_destroy(out);
    return status;
}

void graph_destroy(scene_graph *graph) {
    free(graph->objects.first);
    free(graph->objects.items);
    free(graph->instances.first);
    free(graph->instances.items);
    free(graph->order);
    free(graph->absent);
    *graph = (scene_graph){.order = NULL};
}

double graph_count_placements(const fathom_scene *scene, const scene_graph *graph, double *placements) {
    double total = 0;
    placements[FATHOM_ROOT] = 1;
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        uint32_t g = graph->order[k];
        total += placements[g];
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            placements[scene->instances.items[graph->instances.items[i]].group] += placements[g];
        }
    }
    return total;
}

/* ---- checks that need the whole scene ---- */

fathom_status scene_check_cycles(const fathom_scene *scene) {
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status == FATHOM_OK) graph_destroy(&graph);
    return status;
}

/* FATHOM_OK if there is an object in a group that the root reaches. Frames of an animation may hide all, if
 * the camera does not depend on what there is to see. */
static fathom_status check_presence(const fathom_scene *scene, const scene_graph *graph) {
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        uint32_t g = graph->order[k];
        if (graph->objects.first[g] < graph->objects.first[g + 1]) return FATHOM_OK;
    }
    if (scene->hides && scene->has_camera) return FATHOM_OK;
    if (scene->hides)
        return fail(
            scene->context, FATHOM_BAD_INPUT,
            "everything is hidden or scaled to nothing, so that there is nothing to point a camera at; "
            "expected a camera, or a time at which something is shown");
    return fail(scene->context, FATHOM_BAD_INPUT,
                "the scene holds no geometry: expected at least one object that is placed in "
                "the world");
}

fathom_status fathom_scene_check(const fathom_scene *scene) {
    if (!scene) return FATHOM_BAD_USAGE;
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    status = check_presence(scene, &graph);
    graph_destroy(&graph);
    if (status == FATHOM_OK) status = scene_check_settings(scene->context, &scene->settings);
    return status;
}
