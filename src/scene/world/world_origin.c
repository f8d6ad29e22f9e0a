/* The origin of each group's float coordinates.
 *
 * A float coordinate at distance |c| from the origin has a rounding error of 2^-24 |c|. For an object of
 * radius r this is at most 2^-14 of its radius if |c| <= 2^10 r: a hundredth of a pixel for an object 160
 * pixels tall. Beyond that distance the object is far, and the origin moves to a far object: in the root to
 * the one nearest to the camera, where the error would be visible, in other groups to the first. Otherwise
 * the origin stays at zero, so that buffers are shared and no instance is needed. */
#include "scene/world/world_build.h"

static const double far_ratio = 1024;

typedef struct origin_search {
    const fathom_scene *scene;
    vec3_f64 *origins; /* by group */
    uint32_t group;    /* the one of the last object */
    bool found;        /* a far object in this group, */
    double distance;   /* so far from the camera */
} origin_search;

/* The origin of a mesh if it has one, so that the mesh needs no instance; else the centre of the bounds. */
static vec3_f64 offered_origin(const fathom_scene *scene, fathom_id id, vec3_f64 center) {
    const scene_object object = scene->objects.items[id];
    if (object.kind != SCENE_MESH) return center;
    const vec3_f64 own = load_f64(scene->meshes.items[object.index].origin);
    return length_f64(own) > 0 ? own : center;
}

static void consider(void *user, uint32_t group, fathom_id object, const scene_bounds *bounds) {
    origin_search *search = user;
    const vec3_f64 center = bounds_center(bounds), eye = load_f64(search->scene->camera.origin);
    const double distance = length_f64(sub_f64(center, eye));
    if (search->group != group) search->group = group, search->found = false;
    if (!(length_f64(center) > far_ratio * bounds_radius(bounds))) return;
    if (search->found && !(group == FATHOM_ROOT && distance < search->distance)) return;
    search->found = true, search->distance = distance;
    search->origins[group] = object == FATHOM_NONE ? center : offered_origin(search->scene, object, center);
}

fathom_status world_choose_origins(const fathom_scene *scene, const scene_graph *graph, vec3_f64 *origins,
                                   scene_bounds **bounds) {
    origin_search search = {.scene = scene, .origins = origins, .group = FATHOM_NONE};
    return graph_bounds(scene, graph, scene_object_bounds, consider, &search, bounds);
}
