/* What can only be checked once the scene is whole. */
#include "scene/graph.h"

fathom_status scene_check_cycles(const fathom_scene *scene) {
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status == FATHOM_OK) graph_destroy(&graph);
    return status;
}

static bool inside(const fathom_sphere *sphere, const double point[3]) {
    return length_f64(sub_f64(load_f64(point), load_f64(sphere->center))) < sphere->radius;
}

/* Pairs of a light and a sphere that are looked at: a few hundredths of a second. The check is for slips of
 * the hand; scenes of so many of both are made by programs. */
#define PAIRS_MOST ((size_t)1 << 22)

static fathom_status check_lights_in(const fathom_scene *scene, const fathom_sphere *sphere) {
    for (size_t i = 0; i < scene->lights.count; ++i) {
        const fathom_light *light = &scene->lights.items[i];
        if (light->type == FATHOM_LIGHT_DIRECTIONAL || !inside(sphere, light->position)) continue;
        return fail(scene->context, FATHOM_BAD_INPUT,
                    "lights[%zu]: it lies inside the sphere at (%g, %g, %g) of radius %g, which no light "
                    "leaves; move it, "
                    "or let the sphere cast no shadow",
                    i, sphere->center[0], sphere->center[1], sphere->center[2], sphere->radius);
    }
    return FATHOM_OK;
}

/* A light shut inside an opaque sphere lights nothing outside. Meant as such only when the camera is in there
 * too (a room, a sky). Spheres in other groups are left to the eye: they may be placed anywhere. */
static fathom_status check_lights(const fathom_scene *scene) {
    size_t pairs = 0;
    for (size_t k = 0; k < scene->objects.count && scene->lights.count; ++k) {
        scene_object object = scene->objects.items[k];
        if (object.kind != SCENE_SPHERE || object.group != FATHOM_ROOT) continue;
        const fathom_sphere *sphere = &scene->spheres.items[object.index];
        if (sphere->flags & FATHOM_CASTS_NO_SHADOW) continue;
        if (scene->has_camera && inside(sphere, scene->camera.origin)) continue;
        if (pairs > PAIRS_MOST) return FATHOM_OK;
        fathom_status status = check_lights_in(scene, sphere);
        if (status != FATHOM_OK) return status;
        pairs += scene->lights.count;
    }
    return FATHOM_OK;
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
    if (status == FATHOM_OK) status = check_lights(scene);
    if (status == FATHOM_OK) status = scene_check_settings(scene->context, &scene->settings);
    return status;
}
