/* The origin of each group's float coordinates.
 *
 * A float coordinate at distance |c| from the origin has a rounding error of 2^-24 |c|. For an object of
 * radius r this is at most 2^-14 of its radius if |c| <= 2^10 r: a hundredth of a pixel for an object 160
 * pixels tall. Beyond that distance the object is far, and the origin moves to a far object: in the root to
 * the one nearest to the camera, where the error would be visible, in other groups to the first. Otherwise
 * the origin stays at zero, so that buffers are shared and no instance is needed. */
#include "scene/world/world_build.h"

#include <stdlib.h>

static const double far_ratio = 1024;

typedef struct origin_search {
    vec3_f64 eye;
    bool nearest; /* take the one nearest to the eye; else the first */
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

/* The origin of a mesh if it has one, so that the mesh needs no instance; else the centre of the bounds. */
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
        scene_bounds b = graph_object_bounds(scene, graph, id);
        if (!bounds_is_empty(&b)) consider(&search, &b, offered_origin(scene, id, &b));
        bounds_join(&of_group[group], &b);
    }
    for (uint32_t i = graph->instances.first[group]; i < graph->instances.first[group + 1]; ++i) {
        const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
        scene_bounds b = motion_bounds(instance, scene->camera.shutter, &of_group[instance->group]);
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
