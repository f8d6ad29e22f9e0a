/* Estimates how much light the emissive surfaces of a model give to the model itself: the irradiance that a
 * quarter of the other surfaces reaches, from points distributed uniformly by area over both. A mean would be
 * high next to a single bright part, and the model around it dark. Occlusion is ignored, but a
 * surface is lit on one side only. This is its front: the display of a telephone does not light the
 * telephone, because its other surfaces all face away from the display. If the scene's own camera stands
 * among the surfaces, it is the side that the camera sees, because some programs let the walls of rooms face
 * outwards. */
#include "scene/camera/camera.h"

#include "scene/graph.h"
#include "scene/motion/motion.h"

#include <stdlib.h>

/* Maxima: points on emissive and on other surfaces each, triangles read of one mesh, triangles read in all,
 * groups entered. */
enum { PATCHES = 256, TRIANGLES_OF_MESH = 4096, TRIANGLES_MOST = 1 << 22, PLACES_MOST = 1 << 16 };

typedef struct surface {
    double radiance;
    double front; /* 1; -1 if its transform mirrors it */
    bool both;    /* light counts on both sides */
} surface;

typedef struct patch {
    vec3_f64 at, normal;
    surface of;
} patch;

typedef struct patches {
    patch items[PATCHES];
    uint32_t count;
    double area, passed; /* the total, and the part that the second walk has passed */
} patches;

typedef struct place {
    uint32_t group;
    affine_f64 to_world;
    fathom_id material; /* replaces those inside; or FATHOM_NONE */
} place;

typedef struct lamp_walk {
    const fathom_scene *scene;
    const scene_graph *graph;
    ARRAY(place) stack;
    uint32_t triangles, places; /* that may still be read, and entered */
    bool spreads;               /* the second walk: puts the points where the first found area */
    patches lamps, others;
    bool inside; /* the camera is within the bounds of the points of `others` */
} lamp_walk;

/* A surface that shows a colour whatever the light, as glTF's unlit materials do: it reflects nothing, and
 * emits no more than a white surface would reflect. */
static bool is_unlit(const fathom_material *m) {
    bool dim = m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && material_only_emits(m);
    for (int c = 0; c < 3; ++c) dim &= m->emissive_strength * m->emissive[c] <= 1;
    return dim;
}

/* The emitted radiance as luminance. A texture of emission is a display or a signal on most models: it does
 * not count. */
static double radiance_of(const fathom_material *m) {
    if (m->maps[FATHOM_MAP_EMISSIVE].texture != FATHOM_NONE || is_unlit(m)) return 0;
    const bool classic = m->model == FATHOM_MODEL_CLASSIC;
    const float *rgb = classic ? m->k_e : m->emissive;
    const double luminance = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
    return classic ? luminance : luminance * (double)m->emissive_strength * (double)material_opacity(m);
}

/* ---- points ---- */

/* Puts a point in the triangle: the low-discrepancy sequence of Roberts, folded from the square. */
static void put_patch(patches *list, const surface *of, vec3_f64 normal, const vec3_f64 corner[3]) {
    const double i = list->count + 1.0;
    double u = fmod(0.7548776662466927 * i, 1), v = fmod(0.5698402909980532 * i, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const vec3_f64 at =
        madd_f64(madd_f64(corner[0], u, sub_f64(corner[1], corner[0])), v, sub_f64(corner[2], corner[0]));
    list->items[list->count++] = (patch){at, scale_f64(of->front, normal), *of};
}

/* Adds a triangle that represents `weight` triangles like it. */
static void add_triangle(lamp_walk *w, const vec3_f64 corner[3], double weight, const surface *of) {
    patches *list = of->radiance > 0 ? &w->lamps : &w->others;
    const vec3_f64 n = cross_f64(sub_f64(corner[1], corner[0]), sub_f64(corner[2], corner[0]));
    const double area = 0.5 * length_f64(n) * weight, step = list->area / PATCHES;
    if (!(area > 0) || isinf(area)) return;
    if (!w->spreads) {
        list->area += area;
        return;
    }
    list->passed += area;
    while (list->count < PATCHES && (list->count + 0.5) * step < list->passed)
        put_patch(list, of, normalize_f64(n), corner);
}

/* ---- shapes ---- */

static void add_placed(lamp_walk *w, const affine_f64 *map, const vec3_f64 corner[3], double weight,
                       const surface *of) {
    const vec3_f64 moved[3] = {affine_point(map, corner[0]), affine_point(map, corner[1]),
                               affine_point(map, corner[2])};
    add_triangle(w, moved, weight, of);
}

enum { SQUARES = 16 };

/* Adds a sphere as tangent squares with the same total area. It represents `weight` spheres like it. */
static void add_sphere(lamp_walk *w, const affine_f64 *map, vec3_f64 center, double radius, double weight,
                       const surface *of) {
    const double side = sqrt(4 * 3.14159265358979324 / SQUARES) * radius;
    for (int i = 0; i < SQUARES; ++i) {
        const double z = 1 - (2 * i + 1.0) / SQUARES, r = sqrt(1 - z * z), turn = 2.39996322972865332 * i;
        const vec3_f64 n = {r * cos(turn), r * sin(turn), z};
        const frame_f64 f = frame_from(n, n, (vec3_f64){0, 1, 0});
        const vec3_f64 across = scale_f64(side, f.x), up = scale_f64(side, f.y),
                       middle = madd_f64(center, radius, n),
                       first = madd_f64(madd_f64(middle, -0.5, across), -0.5, up),
                       last = add_f64(add_f64(first, across), up);
        add_placed(w, map, (vec3_f64[]){first, add_f64(first, across), last}, weight, of);
        add_placed(w, map, (vec3_f64[]){first, last, add_f64(first, up)}, weight, of);
    }
}

/* Both sides count: authors of a quad do not care which side is its front. */
static void add_quad(lamp_walk *w, const affine_f64 *map, const fathom_quad *q, surface of) {
    of.both = true;
    const vec3_f64 c[4] = {load_f64(q->corners[0]), load_f64(q->corners[1]), load_f64(q->corners[2]),
                           load_f64(q->corners[3])};
    add_placed(w, map, (vec3_f64[]){c[0], c[1], c[2]}, 1, &of);
    add_placed(w, map, (vec3_f64[]){c[0], c[2], c[3]}, 1, &of);
}

static void add_mesh(lamp_walk *w, const affine_f64 *map, const fathom_mesh *mesh, const surface *of) {
    const uint32_t every = (mesh->triangle_count - 1) / TRIANGLES_OF_MESH + 1;
    for (uint32_t t = 0; t < mesh->triangle_count && w->triangles; t += every, --w->triangles) {
        vec3_f64 corner[3];
        for (int k = 0; k < 3; ++k)
            corner[k] = add_f64(load_f64(mesh->origin),
                                widen(load_f32(mesh_vertex(mesh, mesh->indices[3 * (size_t)t + (size_t)k]))));
        add_placed(w, map, corner, fmin(every, mesh->triangle_count - t), of);
    }
}

/* Reads at most POINTS points: they have as many triangles as are read of one mesh. */
static void add_cloud(lamp_walk *w, const affine_f64 *map, const fathom_mesh *mesh, const surface *of) {
    enum { TRIANGLES = 2 * SQUARES, POINTS = TRIANGLES_OF_MESH / TRIANGLES };
    const uint32_t every = (mesh->vertex_count - 1) / POINTS + 1;
    for (uint32_t i = 0; i < mesh->vertex_count && w->triangles >= TRIANGLES;
         i += every, w->triangles -= TRIANGLES) {
        const vec3_f64 at = add_f64(load_f64(mesh->origin), widen(load_f32(mesh_vertex(mesh, i))));
        add_sphere(w, map, at, (double)mesh->point_radius, fmin(every, mesh->vertex_count - i), of);
        if (mesh->vertex_count - i <= every) return;
    }
}

static void add_object(lamp_walk *w, const place *at, fathom_id id) {
    const scene_object object = w->scene->objects.items[id];
    const fathom_id material =
        at->material != FATHOM_NONE ? at->material : scene_object_material(w->scene, id);
    const surface of = {.front = affine_determinant(&at->to_world) < 0 ? -1 : 1,
                        .radiance = radiance_of(&w->scene->materials.items[material].value)};
    if (w->graph->absent[id]) return;
    switch (object.kind) {
    case SCENE_SPHERE: {
        const fathom_sphere *s = &w->scene->spheres.items[object.index];
        add_sphere(w, &at->to_world, load_f64(s->center), s->radius, 1, &of);
        break;
    }
    case SCENE_QUAD: add_quad(w, &at->to_world, &w->scene->quads.items[object.index], of); break;
    case SCENE_MESH: {
        const fathom_mesh *mesh = &w->scene->meshes.items[object.index];
        (mesh->point_radius > 0 ? add_cloud : add_mesh)(w, &at->to_world, mesh, &of);
        break;
    }
    case SCENE_PLANE: break;
    }
}

/* ---- the scene ---- */

static bool walk_all(lamp_walk *w, bool spreads) {
    const scene_graph *graph = w->graph;
    const place root = {FATHOM_ROOT, affine_identity(), FATHOM_NONE};
    w->spreads = spreads, w->triangles = TRIANGLES_MOST, w->places = PLACES_MOST;
    bool fine = array_push(&w->stack, root);
    while (fine && w->stack.count) {
        const place at = w->stack.items[--w->stack.count];
        for (uint32_t i = graph->objects.first[at.group]; i < graph->objects.first[at.group + 1]; ++i)
            add_object(w, &at, graph->objects.items[i]);
        for (uint32_t i = graph->instances.first[at.group];
             fine && w->places && i < graph->instances.first[at.group + 1]; ++i, --w->places) {
            const fathom_instance *instance = &w->scene->instances.items[graph->instances.items[i]];
            const affine_f64 map = motion_place(instance, w->scene->camera.shutter[0]);
            const place inner = {instance->group, affine_compose(&at.to_world, &map),
                                 at.material != FATHOM_NONE ? at.material : instance->material};
            fine = array_push(&w->stack, inner);
        }
    }
    return fine;
}

static bool has_camera_inside(const lamp_walk *w) {
    const vec3_f64 eye = load_f64(w->scene->camera.origin);
    scene_bounds bounds = bounds_empty();
    for (uint32_t i = 0; i < w->others.count; ++i) bounds_add(&bounds, w->others.items[i].at);
    return w->scene->has_camera && !w->scene->made.camera && eye.x > bounds.lower.x &&
           eye.x < bounds.upper.x && eye.y > bounds.lower.y && eye.y < bounds.upper.y &&
           eye.z > bounds.lower.z && eye.z < bounds.upper.z;
}

/* The patch of a lamp counts as a disc of its area, seen along its axis, so the result is bounded even if the
 * points are close together. */
static double irradiance_at(const lamp_walk *w, const patch *to) {
    const double area = w->lamps.area / PATCHES;
    const bool behind =
        w->inside && dot_f64(sub_f64(load_f64(w->scene->camera.origin), to->at), to->normal) < 0;
    double sum = 0;
    for (uint32_t i = 0; i < w->lamps.count; ++i) {
        const patch *lamp = &w->lamps.items[i];
        const vec3_f64 way = sub_f64(lamp->at, to->at), d = normalize_f64(way);
        const double met = dot_f64(d, behind ? neg_f64(to->normal) : to->normal),
                     square = dot_f64(way, way) + area / 3.14159265358979324;
        const double share = to->of.both ? fabs(met) : fmax(met, 0);
        sum += lamp->of.radiance * area * fabs(dot_f64(d, lamp->normal)) * share / square;
    }
    return sum;
}

static bool any_lamp(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->materials.count; ++i) {
        if (radiance_of(&scene->materials.items[i].value) > 0) return true;
    }
    return false;
}

static int by_value(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double upper_quartile(const lamp_walk *w) {
    double irradiance[PATCHES];
    if (!w->others.count) return 0;
    for (uint32_t i = 0; i < w->others.count; ++i) irradiance[i] = irradiance_at(w, &w->others.items[i]);
    qsort(irradiance, w->others.count, sizeof *irradiance, by_value);
    return irradiance[w->others.count - 1 - w->others.count / 4];
}

fathom_status scene_measure_lamps(const fathom_scene *scene, double *out) {
    scene_graph graph;
    *out = 0;
    if (!any_lamp(scene)) return FATHOM_OK;
    if (scene->planes.count) {
        *out = INFINITY;
        return FATHOM_OK;
    }
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    lamp_walk w = {.scene = scene, .graph = &graph};
    if (!walk_all(&w, false) || !walk_all(&w, true))
        status = fail_memory(scene->context, sizeof *w.stack.items);
    w.inside = has_camera_inside(&w);
    *out = upper_quartile(&w);
    array_free(&w.stack);
    graph_destroy(&graph);
    return status;
}
