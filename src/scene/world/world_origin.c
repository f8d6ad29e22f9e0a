/* Where each group's float coordinates are counted from.
 *
 * A float coordinate at distance |c| from the origin is good to 2^-24 |c|. An object of radius r there keeps
 * 2^-14 of its radius as long as |c| <= 2^10 r: a hundredth of a pixel for an object 160 pixels tall. Beyond
 * that it is far, and the origin moves to a far object: in the root to the one nearest to the camera, where
 * loss would be seen, in other groups to the first. An origin that need not move stays at zero: then buffers
 * are shared and no frame is needed. */
#include "scene/world/world_build.h"

#include <stdlib.h>

static const double far_ratio = 1024;

typedef struct origin_search {
    vec3_f64 eye;
    bool nearest; /* to the eye; else the first */
    bool found;
    double distance;
    vec3_f64 origin;
} origin_search;

static void consider(origin_search *search, const scene_bounds *bounds, vec3_f64 origin) {
    if (bounds_is_empty(bounds)) return;
    vec3_f64 center = bounds_center(bounds);
    if (!(length_f64(center) > far_ratio * bounds_radius(bounds))) return;
    double distance = length_f64(sub_f64(center, search->eye));
    if (search->found && !(search->nearest && distance < search->distance)) return;
    search->found = true;
    search->distance = distance;
    search->origin = origin;
}

/* A mesh that has an origin of its own offers that one: taking it spares the mesh a frame. */
static vec3_f64 offered_origin(const fathom_scene *scene, fathom_id id, const scene_bounds *bounds) {
    scene_object object = scene->objects.items[id];
    if (object.kind == SCENE_MESH) {
        vec3_f64 own = load_f64(scene->meshes.items[object.index].origin);
        if (length_f64(own) > 0) return own;
    }
    return bounds_center(bounds);
}

static vec3_f64 choose(const fathom_scene *scene, const scene_graph *graph, uint32_t group,
                       scene_bounds *of_group) {
    origin_search search = {.eye = load_f64(scene->camera.origin), .nearest = group == FATHOM_ROOT};
    of_group[group] = bounds_empty();
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        fathom_id id = graph->objects.items[i];
        scene_bounds b = scene_object_bounds(scene, id);
        if (!bounds_is_empty(&b)) consider(&search, &b, offered_origin(scene, id, &b));
        bounds_join(&of_group[group], &b);
    }
    for (uint32_t i = graph->instances.first[group]; i < graph->instances.first[group + 1]; ++i) {
        const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
        affine_f64 map;
        affine_load(&map, instance->transform);
        scene_bounds b = bounds_transformed(&of_group[instance->group], &map);
        if (!bounds_is_empty(&b)) consider(&search, &b, bounds_center(&b));
        bounds_join(&of_group[group], &b);
    }
    return search.found ? search.origin : (vec3_f64){0, 0, 0};
}

fathom_status world_choose_origins(const fathom_scene *scene, const scene_graph *graph, vec3_f64 *of_group) {
    scene_bounds *bounds = malloc(scene->groups.count * sizeof *bounds);
    if (!bounds) return fail_memory(scene->context, scene->groups.count * sizeof *bounds);
    for (uint32_t k = graph->order_count; k-- > 0;) {
        uint32_t g = graph->order[k];
        of_group[g] = choose(scene, graph, g, bounds);
    }
    free(bounds);
    return FATHOM_OK;
}
