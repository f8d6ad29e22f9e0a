/* Lights in spheres, which light nothing outside: mostly a slip of the hand. */
#include "scene/world/world.h"

/* Pairs of a light and a sphere that are looked at, a few hundredths of a second. Scenes of more are made by
 * programs. */
#define PAIRS_MOST ((size_t)1 << 22)

typedef struct search {
    const world *w;
    size_t pairs, found;
    size_t light;     /* the first that was found, */
    fathom_id object; /* and the sphere around it */
} search;

static bool holds(const world_sphere *s, vec3_f64 p) {
    return length_f64(sub_f64(p, world_sphere_center(s))) < world_sphere_radius(s);
}

static vec3_f64 carried(const search *s, const affine_f64 *to_object, const double point[3]) {
    return affine_point(to_object, sub_f64(load_f64(point), s->w->origin));
}

/* Meant as such only when the camera is in there too (a room, a sky). */
static void look_in_sphere(search *s, size_t sphere, const affine_f64 *to_object) {
    const fathom_scene *scene = s->w->scene;
    const world_sphere *around = &s->w->spheres.items[sphere];
    if (scene->has_camera && holds(around, carried(s, to_object, scene->camera.origin))) return;
    for (size_t i = 0; i < scene->lights.count; ++i, ++s->pairs) {
        const fathom_light *light = &scene->lights.items[i];
        if (light->type == FATHOM_LIGHT_DIRECTIONAL || !holds(around, carried(s, to_object, light->position)))
            continue;
        if (!s->found++) s->light = i, s->object = s->w->sphere_objects.items[sphere];
    }
}

static void look_in_group(search *s, const world_group *group, const affine_f64 *to_object) {
    for (uint32_t k = group->first; k < group->first + group->count; ++k) {
        const world_geometry *g = &s->w->geometries.items[k];
        if (g->kind != WORLD_SPHERES || g->flags & FATHOM_CASTS_NO_SHADOW) continue;
        for (uint32_t i = 0; i < g->count && s->pairs < PAIRS_MOST; ++i)
            look_in_sphere(s, g->first + i, to_object);
    }
}

void world_warn_of_lights(const world *w) {
    search s = {.w = w};
    affine_f64 to_object = affine_identity();
    if (!w->scene->lights.count) return;
    look_in_group(&s, &w->groups.items[0], &to_object);
    for (size_t k = 0; k < w->instances.count && s.pairs < PAIRS_MOST; ++k, ++s.pairs) {
        const world_instance *instance = &w->instances.items[k];
        for (int i = 0; i < 12; ++i) to_object.m[i / 4][i % 4] = (double)instance->to_object[i / 4][i % 4];
        look_in_group(&s, &w->groups.items[instance->group], &to_object);
    }
    if (!s.found) return;
    const double *p = w->scene->lights.items[s.light].position;
    warn(w->scene->context,
         "lights[%zu] at (%g, %g, %g) lies inside a sphere (object %u), which its light does not leave, "
         "whatever the material; move it, or let the sphere cast no shadow%s",
         s.light, p[0], p[1], p[2], s.object, s.found > 1 ? " (and so for others)" : "");
}
