/* Facts about primitives that tracers need, and checks of the whole world. */
#include "math/rgb.h"
#include "scene/world/world_build.h"

static float larger(float a, float b) { return a > b ? a : b; }

/* Adds one primitive to the counts. reach: the magnitude of its largest coordinate. */
static void survey_one(world *w, world_geometry *geometry, float reach, bool flat) {
    bool within = reach < (float)WORLD_REACH;
    w->beyond_reach += !within;
    geometry->flat += flat;
    if (within) geometry->largest = larger(geometry->largest, reach);
}

static void survey_sphere(world *w, world_geometry *geometry, const world_sphere *s) {
    survey_one(w, geometry, world_reach_of(s->center) + fabsf(s->radius), !(s->radius > 0));
}

static void survey_quad(world *w, world_geometry *geometry, const world_quad *quad) {
    float reach = 0;
    for (int i = 0; i < 4; ++i) {
        float corner = world_reach_of(quad->corner[i]);
        reach = corner <= reach ? reach : corner; /* keeps NaN */
        if (!(reach < INFINITY)) break;
    }
    vec3_f64 a = widen(quad->corner[0]), b = widen(quad->corner[1]), c = widen(quad->corner[2]),
             d = widen(quad->corner[3]);
    vec3_f64 m = cross_f64(sub_f64(b, a), sub_f64(d, a)), n = cross_f64(sub_f64(d, c), sub_f64(b, c));
    bool area = (m.x != 0 || m.y != 0 || m.z != 0) && (n.x != 0 || n.y != 0 || n.z != 0);
    survey_one(w, geometry, reach, !area);
}

static void survey_mesh(world *w, world_geometry *geometry) {
    const mesh_facts *facts = &w->mesh_facts.items[geometry->first];
    geometry->largest = facts->largest, geometry->flat = facts->flat;
    w->degenerate_triangles += facts->flat;
    w->beyond_reach += facts->beyond;
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

void world_count(world *w) {
    w->degenerate_triangles = w->beyond_reach = 0;
    for (size_t i = 0; i < w->geometries.count; ++i) survey_geometry(w, &w->geometries.items[i]);
}

fathom_status world_survey(world *w) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < w->meshes.count && status == FATHOM_OK; ++i) {
        status = mesh_look_at_triangles(w->scene->context, "indices", &w->meshes.items[i],
                                        &w->mesh_facts.items[i]);
    }
    if (status == FATHOM_OK) world_count(w);
    return status;
}

/* ---- lights in spheres: they light nothing outside, which is mostly a mistake ---- */

/* The maximum number of pairs of a light and a sphere to check: a few hundredths of a second. */
#define PAIRS_MOST ((size_t)1 << 22)

typedef struct light_search {
    const world *w;
    size_t pairs, found;
    size_t light;     /* the first that was found, */
    fathom_id object; /* and the sphere around it */
} light_search;

static bool holds(const world_sphere *s, vec3_f64 p) {
    return length_f64(sub_f64(p, world_sphere_center(s))) < world_sphere_radius(s);
}

static vec3_f64 carried(const light_search *s, const affine_f64 *to_object, const double point[3]) {
    return affine_point(to_object, sub_f64(load_f64(point), s->w->origin));
}

/* Light samples pass it: clear thin walls, holes, and glass that does not refract. */
static bool lets_out(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC) return m->ior == 1 && rgb_any(m->k_t);
    return m->opacity < 1 || (m->transmission > 0 && !(m->thickness > 0) && !(m->roughness > 0));
}

/* Part of the lamp's own sphere lies outside. */
static bool reaches_out(const world_sphere *around, const fathom_light *light, vec3_f64 p,
                        const affine_f64 *to_object) {
    const double reach = length_f64(affine_vector(to_object, vec_f64((double)light->radius, 0, 0)));
    return length_f64(sub_f64(p, world_sphere_center(around))) + reach > world_sphere_radius(around);
}

/* If the camera is inside the sphere too (a room, a sky), the light is there on purpose. */
static void look_in_sphere(light_search *s, size_t sphere, const affine_f64 *to_object, fathom_id material) {
    const fathom_scene *scene = s->w->scene;
    const world_sphere *around = &s->w->spheres.items[sphere];
    if (lets_out(&scene->materials.items[material].value)) return;
    if (scene->has_camera && holds(around, carried(s, to_object, scene->camera.origin))) return;
    for (size_t i = 0; i < scene->lights.count; ++i, ++s->pairs) {
        const fathom_light *light = &scene->lights.items[i];
        const vec3_f64 at = carried(s, to_object, light->position);
        if (light->type == FATHOM_LIGHT_DIRECTIONAL || !holds(around, at) ||
            reaches_out(around, light, at, to_object))
            continue;
        if (!s->found++) s->light = i, s->object = s->w->sphere_objects.items[sphere];
    }
}

static void look_in_group(light_search *s, const world_group *group, uint32_t instance,
                          const affine_f64 *to_object) {
    for (uint32_t k = group->first; k < group->first + group->count; ++k) {
        const world_geometry *g = &s->w->geometries.items[k];
        if (g->kind != WORLD_SPHERES || g->flags & FATHOM_CASTS_NO_SHADOW) continue;
        for (uint32_t i = 0; i < g->count && s->pairs < PAIRS_MOST; ++i)
            look_in_sphere(s, g->first + i, to_object, world_material(s->w, k, i, instance));
    }
}

static void warn_of_lights(const world *w) {
    light_search s = {.w = w};
    affine_f64 to_object = affine_identity();
    if (!w->scene->lights.count) return;
    look_in_group(&s, &w->groups.items[0], FATHOM_NONE, &to_object);
    for (size_t k = 0; k < w->instances.count && s.pairs < PAIRS_MOST; ++k, ++s.pairs) {
        const world_instance *instance = &w->instances.items[k];
        to_object = affine_widen(instance->to_object);
        look_in_group(&s, &w->groups.items[instance->group], (uint32_t)k, &to_object);
    }
    if (!s.found) return;
    const double *p = w->scene->lights.items[s.light].position;
    warn(w->scene->context,
         "lights[%zu] at (%g, %g, %g) lies inside a sphere (object %u), which its light does not leave; "
         "move it, or let the sphere cast no shadow%s",
         s.light, p[0], p[1], p[2], s.object, s.found > 1 ? " (and so for others)" : "");
}

static void warn_of_motion(const world *w) {
    if (!(w->motion_error > 0)) return;
    const fathom_id id = w->motion_error_of;
    const fathom_place *place = scene_origin_find(w->scene, SCENE_PART_MOVED, id);
    warn(w->scene->context,
         "instance %u%s%s moves along a curve that %u straight pieces miss by up to %g; shorten the shutter",
         id, place && place->field ? ", of " : "", place && place->field ? place->field : "",
         WORLD_STEPS_MOST - 1, w->motion_error);
}

/* ---- errors of a world as a whole ---- */

/* A scene with only degenerate triangles shows nothing. That is an error, unless it has animations: then
 * they may be degenerate only at this time. */
static fathom_status check_area(const world *w) {
    uint64_t triangles = 0;
    for (size_t i = 0; i < w->meshes.count; ++i) triangles += w->meshes.items[i].triangle_count;
    if (w->spheres.count || w->quads.count || w->planes.count || w->degenerate_triangles < triangles ||
        !triangles || w->scene->has_animations)
        return FATHOM_OK;
    return fail(w->scene->context, FATHOM_BAD_INPUT,
                "the scene holds no geometry with an area: its triangles (%llu) are all degenerate",
                (unsigned long long)triangles);
}

/* Farther out, rays of the camera could not be traced, and float could not separate the rays of neighbouring
 * pixels. */
static fathom_status check_camera(const world *w) {
    vec3_f64 eye = sub_f64(load_f64(w->scene->camera.origin), w->origin);
    if (fabs(eye.x) < WORLD_REACH && fabs(eye.y) < WORLD_REACH && fabs(eye.z) < WORLD_REACH) return FATHOM_OK;
    return fail(w->scene->context, FATHOM_BAD_INPUT,
                "camera: it stands %g from the scene; expected less than %g",
                hypot(hypot(eye.x, eye.y), eye.z), WORLD_REACH);
}

bool world_casts_all_shadows(const world *w) {
    unsigned flags = 0;
    for (size_t i = 0; i < w->geometries.count; ++i) flags |= w->geometries.items[i].flags;
    for (size_t i = 0; i < w->planes.count; ++i) flags |= w->planes.items[i].flags;
    return !(flags & FATHOM_CASTS_NO_SHADOW);
}

fathom_status world_check(const world *w) {
    fathom_status status = check_area(w);
    if (status == FATHOM_OK) status = check_camera(w);
    if (status == FATHOM_OK) warn_of_lights(w);
    if (status == FATHOM_OK) warn_of_motion(w);
    return status;
}
