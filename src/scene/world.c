#include "scene/world.h"

#include "base/threads.h"
#include "scene/world_build.h"

#include <float.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* ---- shapes of one group, as geometries ---- */

static vec3_f32 relative(const double p[3], vec3_f64 origin) { return narrow(sub_f64(load_f64(p), origin)); }

/* Extends the last geometry when it is of this kind and its flags fit, else begins one. */
static world_geometry *open_run(world *w, world_kind kind, uint32_t first_of_group, uint32_t next,
                                unsigned flags) {
    if (w->geometries.count > first_of_group) {
        world_geometry *last = &w->geometries.items[w->geometries.count - 1];
        if (last->kind == kind && last->flags == flags) return last;
    }
    world_geometry fresh = {.kind = kind, .first = next, .flags = flags, .instance = FATHOM_NONE};
    return array_push(&w->geometries, fresh) ? &w->geometries.items[w->geometries.count - 1] : NULL;
}

/* What x loses as a float, as one that tracers do not flush to zero. */
static float rest_of(double x) {
    float rest = (float)(x - (double)(float)x);
    return fabsf(rest) < FLT_MIN ? 0 : rest;
}

/* Where a sphere passes by the origin at a distance g, float tells things of 2^-24 g apart, and the view may
 * show what is 2^-12 g large, a pixel. A planet's centre and radius, rounded to half a metre, would bury or
 * lift all that stands on it. So what rounding takes from them is kept where it is more than 2^-16 g, a
 * sixteenth of such a pixel: for spheres at least some 2^7 times larger than g. Others are the floats that
 * all tracers share, Embree's own spheres too: more digits would not show. */
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

static bool add_mesh(world *w, const fathom_mesh *mesh, fathom_id object) {
    world_geometry geometry = {.kind = WORLD_MESH,
                               .first = (uint32_t)w->meshes.count,
                               .count = mesh->triangle_count,
                               .flags = mesh->flags,
                               .smooth = mesh->normals != NULL,
                               .instance = FATHOM_NONE};
    return array_push(&w->geometries, geometry) && array_push(&w->meshes, *mesh) &&
           array_push(&w->mesh_objects, object);
}

static bool same_point(const double p[3], vec3_f64 q) { return p[0] == q.x && p[1] == q.y && p[2] == q.z; }

/* All of kind `kind` in the group, so that runs of spheres and of quads are as long as can be. */
static bool add_kind(world *w, const scene_graph *graph, uint32_t group, scene_kind kind, uint32_t first,
                     vec3_f64 origin) {
    const fathom_scene *scene = w->scene;
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        fathom_id id = graph->objects.items[i];
        scene_object object = scene->objects.items[id];
        if (object.kind != kind) continue;
        bool added = true;
        switch (kind) {
        case SCENE_SPHERE:
            added = add_sphere(w, &scene->spheres.items[object.index], id, first, origin);
            break;
        case SCENE_QUAD: added = add_quad(w, &scene->quads.items[object.index], id, first, origin); break;
        case SCENE_MESH: {
            const fathom_mesh *mesh = &scene->meshes.items[object.index];
            if (same_point(mesh->origin, origin)) added = add_mesh(w, mesh, id);
            break;
        }
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

bool world_add_lone_mesh(world *w, fathom_id object) {
    return add_mesh(w, &w->scene->meshes.items[w->scene->objects.items[object].index], object);
}

/* ---- what tracers are told about primitives ---- */

typedef struct survey {
    const fathom_mesh *mesh;
    _Atomic uint64_t flat, beyond;
    _Atomic uint32_t largest; /* bits of a float of at least 0, which order as it does */
} survey;

static vec3_f32 vertex(const fathom_mesh *m, uint32_t i) {
    return load_f32(
        (const float *)(const void *)((const char *)m->positions + (size_t)i * m->position_stride));
}

static float larger(float a, float b) { return a > b ? a : b; }

/* NaN for a NaN. */
static float reach_of(vec3_f32 p) {
    return larger(fabsf(p.x), larger(fabsf(p.y), fabsf(p.z))) + (p.x * 0 + p.y * 0 + p.z * 0);
}

static void raise_to(_Atomic uint32_t *to, float value) {
    uint32_t bits, old = atomic_load(to);
    memcpy(&bits, &value, sizeof bits);
    while (old < bits && !atomic_compare_exchange_weak(to, &old, bits)) continue;
}

static void survey_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    survey *all = user;
    const fathom_mesh *m = all->mesh;
    uint64_t flat = 0, beyond = 0;
    float largest = 0;
    for (size_t i = begin; i < end; ++i) {
        const uint32_t *t = &m->indices[3 * i];
        vec3_f32 a = vertex(m, t[0]), b = vertex(m, t[1]), c = vertex(m, t[2]);
        vec3_f64 ab = sub_f64(widen(b), widen(a)), ac = sub_f64(widen(c), widen(a)), n = cross_f64(ab, ac);
        flat += n.x == 0 && n.y == 0 && n.z == 0;
        float x = reach_of(a), y = reach_of(b), z = reach_of(c), reach = larger(x, larger(y, z));
        bool within = x < (float)WORLD_REACH && y < (float)WORLD_REACH && z < (float)WORLD_REACH;
        beyond += !within;
        largest = within ? larger(largest, reach) : largest;
    }
    atomic_fetch_add(&all->flat, flat);
    atomic_fetch_add(&all->beyond, beyond);
    raise_to(&all->largest, largest);
}

static void survey_mesh(world *w, world_geometry *geometry) {
    survey all = {.mesh = &w->meshes.items[geometry->first]};
    loop_parallel(fathom_context_threads(w->scene->context), all.mesh->triangle_count, 1u << 15, survey_run,
                  &all);
    uint32_t bits = atomic_load(&all.largest);
    memcpy(&geometry->largest, &bits, sizeof bits);
    geometry->flat = (uint32_t)atomic_load(&all.flat);
    w->degenerate_triangles += geometry->flat;
    w->beyond_reach += atomic_load(&all.beyond);
}

/* Takes one primitive into the counts; reach: of its largest coordinate. */
static void survey_one(world *w, world_geometry *geometry, float reach, bool flat) {
    bool within = reach < (float)WORLD_REACH;
    w->beyond_reach += !within;
    geometry->flat += flat;
    if (within) geometry->largest = larger(geometry->largest, reach);
}

static void survey_sphere(world *w, world_geometry *geometry, const world_sphere *s) {
    survey_one(w, geometry, reach_of(s->center) + fabsf(s->radius), !(s->radius > 0));
}

static void survey_quad(world *w, world_geometry *geometry, const world_quad *quad) {
    float reach = 0;
    for (int i = 0; i < 4; ++i) {
        float corner = reach_of(quad->corner[i]);
        reach = corner <= reach ? reach : corner; /* NaN too */
        if (!(reach < INFINITY)) break;
    }
    vec3_f64 a = widen(quad->corner[0]), b = widen(quad->corner[1]), c = widen(quad->corner[2]),
             d = widen(quad->corner[3]);
    vec3_f64 m = cross_f64(sub_f64(b, a), sub_f64(d, a)), n = cross_f64(sub_f64(d, c), sub_f64(b, c));
    bool area = (m.x != 0 || m.y != 0 || m.z != 0) && (n.x != 0 || n.y != 0 || n.z != 0);
    survey_one(w, geometry, reach, !area);
}

static void survey_geometry(world *w, world_geometry *geometry) {
    geometry->flat = 0, geometry->largest = 0;
    switch (geometry->kind) {
    case WORLD_SPHERES:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_sphere(w, geometry, &w->spheres.items[geometry->first + i]);
        break;
    case WORLD_QUADS:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_quad(w, geometry, &w->quads.items[geometry->first + i]);
        break;
    case WORLD_MESH: survey_mesh(w, geometry); break;
    }
}

void world_survey(world *w) {
    w->degenerate_triangles = w->beyond_reach = 0;
    for (size_t i = 0; i < w->geometries.count; ++i) survey_geometry(w, &w->geometries.items[i]);
}

/* Some triangles without area are rendered around; a scene of nothing else shows nothing. */
static fathom_status check_area(const world *w) {
    uint64_t triangles = 0;
    for (size_t i = 0; i < w->meshes.count; ++i) triangles += w->meshes.items[i].triangle_count;
    if (w->spheres.count || w->quads.count || w->planes.count || w->degenerate_triangles < triangles ||
        !triangles)
        return FATHOM_OK;
    return fail(w->scene->context, FATHOM_BAD_INPUT,
                "the scene holds no geometry with an area: its triangles (%llu) are all degenerate",
                (unsigned long long)triangles);
}

/* Farther out no ray of the camera could be traced, nor float tell one pixel's ray from the next. */
static fathom_status check_camera(const world *w) {
    vec3_f64 eye = sub_f64(load_f64(w->scene->camera.origin), w->origin);
    if (fabs(eye.x) < WORLD_REACH && fabs(eye.y) < WORLD_REACH && fabs(eye.z) < WORLD_REACH) return FATHOM_OK;
    return fail(w->scene->context, FATHOM_BAD_INPUT,
                "camera: it stands %g from the scene; expected less than %g", length_f64(eye), WORLD_REACH);
}

fathom_status world_check(const world *w) {
    fathom_status status = check_area(w);
    return status == FATHOM_OK ? check_camera(w) : status;
}

/* ---- the whole ---- */

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
        status = world_place(w, &graph, origin);
    } else {
        status = fail_memory(scene->context, sizeof *w);
    }
    graph_destroy(&graph);
    if (status != FATHOM_OK) {
        world_destroy(w);
        return status;
    }
    world_survey(w);
    *out = w;
    return FATHOM_OK;
}

void world_destroy(world *w) {
    if (!w) return;
    array_free(&w->spheres);
    array_free(&w->sphere_objects);
    array_free(&w->quads);
    array_free(&w->quad_objects);
    array_free(&w->planes);
    array_free(&w->meshes);
    array_free(&w->mesh_objects);
    array_free(&w->geometries);
    array_free(&w->groups);
    array_free(&w->instances);
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

fathom_id world_material(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance) {
    if (instance != FATHOM_NONE && w->instances.items[instance].material != FATHOM_NONE) {
        return w->instances.items[instance].material;
    }
    return scene_object_material(w->scene, world_object(w, geometry, primitive));
}
