#include "scene/world/world.h"

#include "scene/world/world_build.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* ---- shapes of one group, as geometries ---- */

static vec3_f32 relative(const double p[3], vec3_f64 origin) { return narrow(sub_f64(load_f64(p), origin)); }

/* Returns the last geometry of the group if its kind and flags fit, to be extended, else a new one. NULL when
 * out of memory. */
static world_geometry *open_run(world *w, world_kind kind, uint32_t first_of_group, uint32_t next,
                                unsigned flags) {
    if (w->geometries.count > first_of_group) {
        world_geometry *last = &w->geometries.items[w->geometries.count - 1];
        if (last->kind == kind && last->flags == flags && !last->cloud) return last;
    }
    world_geometry fresh = {
        .kind = kind, .first = next, .flags = flags, .instance = FATHOM_NONE, .material = FATHOM_NONE};
    return array_push(&w->geometries, fresh) ? &w->geometries.items[w->geometries.count - 1] : NULL;
}

/* The rounding error of x as a float, or 0 if tracers would flush it to zero. */
static float rest_of(double x) {
    float rest = (float)(x - (double)(float)x);
    return fabsf(rest) < FLT_MIN ? 0 : rest;
}

/* If the surface of a sphere passes the origin at a distance g, float coordinates there resolve 2^-24 g, and
 * the view may show details of 2^-12 g, the size of a pixel. If a planet's centre and radius were rounded to
 * half a metre, everything on it would sink or float. So their rounding errors are kept if they exceed 2^-16
 * g, a sixteenth of such a pixel: for spheres at least about 2^7 times larger than g. Other spheres have
 * plain floats, as in all tracers, including Embree's own spheres: more digits would not be visible. */
static world_sphere sphere_of(vec3_f64 center, double radius) {
    world_sphere sphere = {.center = narrow(center), .radius = (float)radius};
    vec3_f32 rest = {rest_of(center.x), rest_of(center.y), rest_of(center.z)};
    float radius_rest = rest_of(radius);
    double lost = length_f64(widen(rest)) + fabs((double)radius_rest);
    if (!(lost > 0x1p-16 * fabs(length_f64(center) - radius)) || !isfinite(lost)) return sphere;
    sphere.center_rest = rest, sphere.radius_rest = radius_rest;
    return sphere;
}

static bool add_sphere(world *w, const fathom_sphere *s, fathom_id object, uint32_t first_of_group,
                       vec3_f64 origin) {
    world_sphere sphere = sphere_of(sub_f64(load_f64(s->center), origin), s->radius);
    world_geometry *run = open_run(w, WORLD_SPHERES, first_of_group, (uint32_t)w->spheres.count, s->flags);
    if (!run || !array_push(&w->spheres, sphere) || !array_push(&w->sphere_objects, object)) return false;
    ++run->count;
    return true;
}

static bool add_quad(world *w, const fathom_quad *q, fathom_id object, uint32_t first_of_group,
                     vec3_f64 origin) {
    world_quad quad;
    for (int i = 0; i < 4; ++i) quad.corner[i] = relative(q->corners[i], origin);
    world_geometry *run = open_run(w, WORLD_QUADS, first_of_group, (uint32_t)w->quads.count, q->flags);
    if (!run || !array_push(&w->quads, quad) || !array_push(&w->quad_objects, object)) return false;
    ++run->count;
    return true;
}

/* The spheres use the float coordinates of the mesh as they are. */
static bool add_cloud(world *w, const fathom_mesh *mesh, fathom_id object) {
    const world_geometry geometry = {.kind = WORLD_SPHERES,
                                     .first = (uint32_t)w->spheres.count,
                                     .count = mesh->vertex_count,
                                     .flags = mesh->flags,
                                     .instance = FATHOM_NONE,
                                     .material = FATHOM_NONE,
                                     .cloud = (uint32_t)w->meshes.count};
    if (w->spheres.count + mesh->vertex_count > UINT32_MAX || !array_push(&w->geometries, geometry) ||
        !array_room(&w->spheres, mesh->vertex_count) || !array_room(&w->sphere_objects, mesh->vertex_count))
        return false;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const world_sphere sphere = {.center = load_f32(mesh_vertex(mesh, i)), .radius = mesh->point_radius};
        w->spheres.items[w->spheres.count++] = sphere;
        w->sphere_objects.items[w->sphere_objects.count++] = object;
    }
    return true;
}

bool world_add_mesh(world *w, fathom_id object, const fathom_mesh *from, const mesh_facts *facts) {
    fathom_mesh mesh = *from;
    mesh_facts known = *facts;
    world_geometry geometry = {.kind = WORLD_MESH,
                               .first = (uint32_t)w->meshes.count,
                               .count = mesh.triangle_count,
                               .flags = mesh.flags,
                               .smooth = mesh.normals != NULL,
                               .instance = FATHOM_NONE,
                               .material = FATHOM_NONE};
    if (mesh.key_count && !world_add_vertex_motion(w, &geometry, &mesh, &known)) return false;
    if (!array_push(&w->meshes, mesh) || !array_push(&w->mesh_facts, known) ||
        !array_push(&w->mesh_objects, object))
        return false;
    return mesh.point_radius > 0 ? add_cloud(w, &mesh, object) : array_push(&w->geometries, geometry);
}

bool world_add_lone_mesh(world *w, fathom_id object) {
    const uint32_t index = w->scene->objects.items[object].index;
    return world_add_mesh(w, object, &w->scene->meshes.items[index], &w->scene->mesh_facts.items[index]);
}

static bool same_point(const double p[3], vec3_f64 q) { return p[0] == q.x && p[1] == q.y && p[2] == q.z; }

/* Adds all shapes of one kind in the group, so that runs of spheres and of quads are as long as possible. */
static bool add_kind(world *w, const scene_graph *graph, uint32_t group, scene_kind kind, uint32_t first,
                     vec3_f64 origin) {
    const fathom_scene *scene = w->scene;
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        fathom_id id = graph->objects.items[i];
        scene_object object = scene->objects.items[id];
        if (object.kind != kind || graph->absent[id]) continue;
        bool added = true;
        switch (kind) {
        case SCENE_SPHERE:
            added = add_sphere(w, &scene->spheres.items[object.index], id, first, origin);
            break;
        case SCENE_QUAD: added = add_quad(w, &scene->quads.items[object.index], id, first, origin); break;
        case SCENE_MESH:
            if (same_point(scene->meshes.items[object.index].origin, origin))
                added = world_add_lone_mesh(w, id);
            break;
        case SCENE_PLANE: break;
        }
        if (!added) return false;
    }
    return true;
}

bool world_add_geometries(world *w, const scene_graph *graph, uint32_t group, vec3_f64 origin) {
    uint32_t first = (uint32_t)w->geometries.count;
    return add_kind(w, graph, group, SCENE_SPHERE, first, origin) &&
           add_kind(w, graph, group, SCENE_QUAD, first, origin) &&
           add_kind(w, graph, group, SCENE_MESH, first, origin);
}

/* ---- the whole world ---- */

static bool any_one_sided(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->materials.count; ++i)
        if (material_is_one_sided(&scene->materials.items[i].value)) return true;
    return false;
}

fathom_status world_create(const fathom_scene *scene, world **out) {
    return world_create_from(scene, NULL, out);
}

fathom_status world_create_from(const fathom_scene *scene, const vec3_f64 *origin, world **out) {
    *out = NULL;
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    world *w = calloc(1, sizeof *w);
    if (w) {
        w->scene = scene;
        w->one_sided = any_one_sided(scene);
        status = world_place(w, &graph, origin);
        w->absent = graph.absent, graph.absent = NULL;
    } else {
        status = fail_memory(scene->context, sizeof *w);
    }
    graph_destroy(&graph);
    if (status != FATHOM_OK) {
        world_destroy(w);
        return status;
    }
    world_count(w);
    *out = w;
    return FATHOM_OK;
}

void world_destroy(world *w) {
    if (!w) return;
    free(w->absent);
    array_free(&w->spheres);
    array_free(&w->sphere_objects);
    array_free(&w->quads);
    array_free(&w->quad_objects);
    array_free(&w->planes);
    array_free(&w->meshes);
    array_free(&w->mesh_facts);
    array_free(&w->mesh_objects);
    array_free(&w->geometries);
    array_free(&w->groups);
    array_free(&w->instances);
    world_motion_destroy(w);
    free(w);
}

fathom_id world_object(const world *w, uint32_t geometry, uint32_t primitive) {
    const world_geometry *g = &w->geometries.items[geometry];
    switch (g->kind) {
    case WORLD_SPHERES: return w->sphere_objects.items[g->first + primitive];
    case WORLD_QUADS: return w->quad_objects.items[g->first + primitive];
    case WORLD_MESH: return w->mesh_objects.items[g->first];
    }
    return FATHOM_NONE;
}

uint32_t world_primitive(const world *w, uint32_t geometry, uint32_t primitive) {
    const world_geometry *g = &w->geometries.items[geometry];
    return g->kind == WORLD_MESH || g->cloud ? primitive : 0;
}

fathom_id world_material(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance) {
    const fathom_id given = instance == FATHOM_NONE ? w->geometries.items[geometry].material
                                                    : w->instances.items[instance].material;
    return given != FATHOM_NONE ? given
                                : scene_object_material(w->scene, world_object(w, geometry, primitive));
}

bool world_material_passes(const world *w, fathom_id material) {
    return material != FATHOM_NONE && material_may_pass(&w->scene->materials.items[material].value);
}

static bool geometry_may_pass(const world *w, uint32_t geometry) {
    const world_geometry *g = &w->geometries.items[geometry];
    if (g->kind == WORLD_MESH)
        return w->meshes.items[g->first].color_channels >= 4 ||
               world_material_passes(w, world_material(w, geometry, 0, FATHOM_NONE));
    for (uint32_t i = 0; i < g->count; ++i)
        if (world_material_passes(w, world_material(w, geometry, i, FATHOM_NONE))) return true;
    return false;
}

uint8_t *world_passing(const world *w) {
    uint8_t *out = calloc(w->geometries.count + 1, 1);
    for (uint32_t i = 0; out && i < w->geometries.count; ++i) out[i] = geometry_may_pass(w, i);
    for (size_t k = 0; out && k < w->instances.count; ++k) {
        const world_group *group = &w->groups.items[w->instances.items[k].group];
        if (world_material_passes(w, w->instances.items[k].material))
            memset(out + group->first, 1, group->count);
    }
    return out;
}
