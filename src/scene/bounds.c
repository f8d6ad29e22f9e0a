#include "scene/graph.h"
#include "scene/kernels.h"
#include "scene/motion/motion.h"

#include <stdlib.h>
#include <string.h>

scene_bounds bounds_empty(void) {
    return (scene_bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

bool bounds_is_empty(const scene_bounds *b) { return !(b->lower.x <= b->upper.x); }

void bounds_add(scene_bounds *b, vec3_f64 p) {
    b->lower = (vec3_f64){fmin(b->lower.x, p.x), fmin(b->lower.y, p.y), fmin(b->lower.z, p.z)};
    b->upper = (vec3_f64){fmax(b->upper.x, p.x), fmax(b->upper.y, p.y), fmax(b->upper.z, p.z)};
}

void bounds_join(scene_bounds *b, const scene_bounds *other) {
    if (bounds_is_empty(other)) return;
    bounds_add(b, other->lower);
    bounds_add(b, other->upper);
}

scene_bounds bounds_transformed(const scene_bounds *b, const affine_f64 *map) {
    scene_bounds out = bounds_empty();
    for (int i = 0; i < 8 && !bounds_is_empty(b); ++i)
        bounds_add(&out, affine_point(map, bounds_corner(b, i)));
    return out;
}

vec3_f64 bounds_corner(const scene_bounds *b, int i) {
    return (vec3_f64){i & 1 ? b->upper.x : b->lower.x, i & 2 ? b->upper.y : b->lower.y,
                      i & 4 ? b->upper.z : b->lower.z};
}

vec3_f64 bounds_center(const scene_bounds *b) { return scale_f64(0.5, add_f64(b->lower, b->upper)); }

double bounds_radius(const scene_bounds *b) {
    return bounds_is_empty(b) ? 0 : 0.5 * length_f64(sub_f64(b->upper, b->lower));
}

/* The bounds of the vertices at a time, or larger ones between two keys: those of a mean of two lists of
 * vertices lie within the mean of their bounds. */
static scene_bounds vertices_at(const fathom_mesh *mesh, double time) {
    double u, part[2];
    const size_t points = 3 * (size_t)mesh->vertex_count;
    const uint32_t key = motion_key(mesh->key_times, mesh->key_count, time, &u);
    scene_bounds out = {.lower = {0, 0, 0}};
    part[0] = 1 - u, part[1] = u;
    for (uint32_t k = 0; k < 2 && part[k] > 0; ++k) {
        float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
        scene_kernels_best()->vectors(mesh->key_positions + points * (key + k), 3 * sizeof(float),
                                      mesh->vertex_count, lower, upper);
        out.lower = madd_f64(out.lower, part[k], widen(load_f32(lower)));
        out.upper = madd_f64(out.upper, part[k], widen(load_f32(upper)));
    }
    return out;
}

/* The facts are those of all keys, of which some may lie outside the shutter's time. */
static scene_bounds vertex_bounds(const fathom_mesh *mesh, const mesh_facts *facts, const double shutter[2]) {
    const double *times = mesh->key_times;
    const uint32_t count = mesh->key_count;
    if (!count || (times[0] >= shutter[0] && times[count - 1] <= shutter[1]))
        return (scene_bounds){widen(load_f32(facts->lower)), widen(load_f32(facts->upper))};
    scene_bounds out = vertices_at(mesh, shutter[0]);
    for (uint32_t k = 0; k <= count; ++k) {
        const double time = k < count ? times[k] : shutter[1];
        if (!(time > shutter[0] && time <= shutter[1])) continue;
        const scene_bounds there = vertices_at(mesh, time);
        bounds_join(&out, &there);
    }
    return out;
}

/* b: bounds of its vertices. */
static scene_bounds placed_bounds(const fathom_mesh *mesh, const scene_bounds *b) {
    const vec3_f64 origin = load_f64(mesh->origin);
    const double reach = (double)mesh->point_radius;
    const vec3_f64 around = {reach, reach, reach};
    return (scene_bounds){add_f64(origin, sub_f64(b->lower, around)),
                          add_f64(origin, add_f64(b->upper, around))};
}

static scene_bounds mesh_bounds(const fathom_scene *scene, uint32_t index) {
    const fathom_mesh *mesh = &scene->meshes.items[index];
    const scene_bounds b = vertex_bounds(mesh, &scene->mesh_facts.items[index], scene->camera.shutter);
    return placed_bounds(mesh, &b);
}

scene_bounds scene_object_bounds(const fathom_scene *scene, fathom_id id) {
    scene_object object = scene->objects.items[id];
    scene_bounds out = bounds_empty();
    switch (object.kind) {
    case SCENE_SPHERE: {
        const fathom_sphere *sphere = &scene->spheres.items[object.index];
        vec3_f64 center = load_f64(sphere->center), radius = {sphere->radius, sphere->radius, sphere->radius};
        bounds_add(&out, sub_f64(center, radius));
        bounds_add(&out, add_f64(center, radius));
        break;
    }
    case SCENE_QUAD:
        for (int i = 0; i < 4; ++i) bounds_add(&out, load_f64(scene->quads.items[object.index].corners[i]));
        break;
    case SCENE_MESH: out = mesh_bounds(scene, object.index); break;
    case SCENE_PLANE: break;
    }
    return out;
}

scene_bounds scene_framed_bounds(const fathom_scene *scene, fathom_id id) {
    const scene_object object = scene->objects.items[id];
    const mesh_facts *facts = object.kind == SCENE_MESH ? &scene->mesh_facts.items[object.index] : NULL;
    if (!facts || !facts->strays) return scene_object_bounds(scene, id);
    const scene_bounds core = {widen(load_f32(facts->core_lower)), widen(load_f32(facts->core_upper))};
    return placed_bounds(&scene->meshes.items[object.index], &core);
}

fathom_status graph_bounds(const fathom_scene *scene, const scene_graph *graph,
                           scene_bounds (*of)(const fathom_scene *scene, fathom_id object), graph_met_fn met,
                           void *user, scene_bounds **out) {
    scene_bounds *of_group = malloc(scene->groups.count * sizeof *of_group);
    *out = of_group;
    if (!of_group) return fail_memory(scene->context, scene->groups.count * sizeof *of_group);
    /* In reverse order, so that the bounds of groups inside a group are known first. */
    for (uint32_t k = graph->order_count; k-- > 0;) {
        uint32_t g = graph->order[k];
        of_group[g] = bounds_empty();
        for (uint32_t i = graph->objects.first[g]; i < graph->objects.first[g + 1]; ++i) {
            const fathom_id object = graph->objects.items[i];
            scene_bounds b = graph->absent[object] ? bounds_empty() : of(scene, object);
            bounds_join(&of_group[g], &b);
            if (met && !bounds_is_empty(&b)) met(user, g, object, &b);
        }
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph->instances.items[i]];
            scene_bounds b = motion_bounds(instance, scene->camera.shutter, &of_group[instance->group]);
            bounds_join(&of_group[g], &b);
            if (met && !bounds_is_empty(&b)) met(user, g, FATHOM_NONE, &b);
        }
    }
    return FATHOM_OK;
}

fathom_status scene_world_bounds(const fathom_scene *scene, scene_bounds *out) {
    *out = bounds_empty();
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    scene_bounds *of_group;
    status = graph_bounds(scene, &graph, scene_object_bounds, NULL, NULL, &of_group);
    if (status == FATHOM_OK) *out = of_group[FATHOM_ROOT];
    free(of_group);
    graph_destroy(&graph);
    return status;
}
