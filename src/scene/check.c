/* What can only be checked once the scene is whole. */
#include "scene/graph.h"

fathom_status scene_check_cycles(const fathom_scene *scene) {
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status == FATHOM_OK) graph_destroy(&graph);
    return status;
}

/* Whether anything can be seen: an object in a group that the root reaches. */
static fathom_status check_presence(const fathom_scene *scene, const scene_graph *graph) {
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        uint32_t g = graph->order[k];
        if (graph->objects.first[g] < graph->objects.first[g + 1]) return FATHOM_OK;
    }
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
