/* The smooth objects of a scene, and a few spheres around them. */
#include "integrate/caustics/caustics.h"
#include "math/rgb.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Takes a tenth of a second. */
#define MOST_VERTICES ((size_t)1 << 24)

typedef struct caster_list {
    caustic_caster *of;
    uint32_t count;
    const bool *smooth; /* by material */
    size_t vertices;    /* that may still be read to make spheres smaller */
} caster_list;

/* The lobes that are not smooth. */
#define SCATTERING                                                                                           \
    (SHADER_DIFFUSE | SHADER_HIGHLIGHT | SHADER_GGX | SHADER_THIN | SHADER_REFRACT | SHADER_COAT |           \
     SHADER_SHEEN | SHADER_LEAF | SHADER_BEHIND)

/* The material without images. It is the plan's unless images vary it: some materials take long to prepare.
 */
static const shader *plain_shader(const render_plan *plan, size_t k, shader *room) {
    const fathom_material *value = &plan->scene->materials.items[k].value;
    fathom_material between;
    mapped_between(value, &between);
    if (!memcmp(&between, value, sizeof between)) return &plan->shaders[k];
    shader_prepare(value, room);
    return room;
}

/* Clear walls bend no light. An image of the roughness rarely makes a surface smooth. */
static bool judge_materials(const render_plan *plan, bool *smooth, bool *ends) {
    for (size_t k = 0; smooth && ends && k < plan->scene->materials.count; ++k) {
        shader room;
        const shader *s = plain_shader(plan, k, &room);
        smooth[k] = (s->lobes & (SHADER_MIRROR | SHADER_PASS | SHADER_CLASSIC)) && !plan->shaders[k].clear;
        ends[k] = ((s->lobes | plan->shaders[k].lobes) & SCATTERING) != 0;
    }
    return smooth && ends;
}

/* Facets and refraction as in shader.h, without the tables of rough materials. */
static bool may_be_smooth(const fathom_material *m) {
    if (m->model == FATHOM_MODEL_CLASSIC) return rgb_any(m->k_r) || rgb_any(m->k_t);
    const float alpha = m->roughness * m->roughness, bend = fminf(fabsf(m->ior - 1), 1),
                coat = m->clearcoat_roughness * m->clearcoat_roughness;
    return alpha < SHADER_SMOOTH_ALPHA || (m->transmission > 0 && alpha * bend < SHADER_SMOOTH_ALPHA) ||
           (m->clearcoat > 0 && coat < SHADER_SMOOTH_ALPHA);
}

bool caustic_smooth_materials(const fathom_scene *scene) {
    for (size_t k = 0; k < scene->materials.count; ++k) {
        fathom_material m;
        mapped_between(&scene->materials.items[k].value, &m);
        if (may_be_smooth(&m)) return true;
    }
    return false;
}

/* The smallest sphere around two spheres. */
static caustic_caster join(const caustic_caster *a, const caustic_caster *b) {
    const vec3_f64 way = sub_f64(b->center, a->center);
    const double apart = length_f64(way);
    if (apart + b->radius <= a->radius) return *a;
    if (apart + a->radius <= b->radius) return *b;
    const double radius = 0.5 * (apart + a->radius + b->radius);
    return (caustic_caster){madd_f64(a->center, (radius - a->radius) / apart, way), radius, 0, 0};
}

static bool overlap(const caustic_caster *a, const caustic_caster *b) {
    return length_f64(sub_f64(b->center, a->center)) < a->radius + b->radius;
}

static void drop(caster_list *list, uint32_t k) { list->of[k] = list->of[--list->count]; }

/* Joins the two spheres whose joint sphere is larger than both by the least. */
static void join_nearest(caster_list *list) {
    double least = INFINITY;
    uint32_t best[2] = {0, 1};
    for (uint32_t a = 0; a < list->count; ++a) {
        for (uint32_t b = a + 1; b < list->count; ++b) {
            const caustic_caster both = join(&list->of[a], &list->of[b]);
            const double more = both.radius - fmax(list->of[a].radius, list->of[b].radius);
            if (!(more < least)) continue;
            least = more, best[0] = a, best[1] = b;
        }
    }
    list->of[best[0]] = join(&list->of[best[0]], &list->of[best[1]]);
    drop(list, best[1]);
}

/* Rays would belong to one of two spheres that overlap, and photons of the other would be lost. */
static void join_overlapping(caster_list *list) {
    for (uint32_t a = 0; a < list->count; ++a) {
        for (uint32_t b = a + 1; b < list->count; ++b) {
            if (!overlap(&list->of[a], &list->of[b])) continue;
            list->of[a] = join(&list->of[a], &list->of[b]);
            drop(list, b);
            a = UINT32_MAX; /* the larger sphere may overlap others: again from the first */
            break;
        }
    }
}

static void add(caster_list *list, vec3_f64 center, double radius) {
    const caustic_caster more = {center, radius * (1 + 0x1p-20), 0, 0};
    if (!(radius > 0 && radius < WORLD_REACH)) return;
    for (uint32_t k = 0; k < list->count; ++k)
        if (length_f64(sub_f64(center, list->of[k].center)) + more.radius <= list->of[k].radius) return;
    list->of[list->count++] = more;
    if (list->count > CAUSTIC_CASTERS) join_nearest(list);
}

/* The place of an instance when the shutter opens and when it closes. */
static scene_bounds placed(const world *w, uint32_t instance, const scene_bounds *inside) {
    scene_bounds out = bounds_empty();
    for (int end = 0; end < 2; ++end) {
        world_instance moved;
        const affine_f64 map = affine_widen(world_instance_when(w, instance, (float)end, &moved)->to_world);
        const scene_bounds there = bounds_transformed(inside, &map);
        bounds_join(&out, &there);
    }
    return out;
}

static scene_bounds bounds_of_sphere(const world_sphere *s) {
    const double radius = world_sphere_radius(s);
    const vec3_f64 c = world_sphere_center(s), r = {radius, radius, radius};
    return (scene_bounds){sub_f64(c, r), add_f64(c, r)};
}

/* The bounds of a mesh, or of primitive k of another geometry, in its group's space. */
static scene_bounds bounds_of(const world *w, const world_geometry *g, uint32_t k) {
    scene_bounds out = bounds_empty();
    const mesh_facts *facts;
    switch (g->kind) {
    case WORLD_SPHERES: return bounds_of_sphere(&w->spheres.items[g->first + k]);
    case WORLD_QUADS:
        for (int c = 0; c < 4; ++c) bounds_add(&out, widen(w->quads.items[g->first + k].corner[c]));
        return out;
    case WORLD_MESH:
        facts = &w->mesh_facts.items[g->first];
        return (scene_bounds){widen(load_f32(facts->lower)), widen(load_f32(facts->upper))};
    }
    return out;
}

/* The distance of the farthest vertex of a mesh that rests. */
static double reach_of(const world *w, uint32_t geometry, uint32_t instance, vec3_f64 center) {
    const fathom_mesh *mesh = world_mesh(w, geometry);
    const affine_f64 map =
        instance == FATHOM_NONE ? affine_identity() : affine_widen(w->instances.items[instance].to_world);
    double most = 0;
    for (uint32_t k = 0; k < mesh->vertex_count; ++k) {
        const float *at = (const float *)((const char *)mesh->positions + k * mesh->position_stride);
        const vec3_f64 way = sub_f64(affine_point(&map, widen(load_f32(at))), center);
        most = fmax(most, dot_f64(way, way));
    }
    return sqrt(most);
}

static double radius_of(const world *w, uint32_t geometry, uint32_t k, uint32_t instance,
                        const scene_bounds *b, caster_list *list) {
    const world_geometry *g = &w->geometries.items[geometry];
    const bool rests = instance == FATHOM_NONE || !w->instances.items[instance].moving;
    const double radius = bounds_radius(b);
    if (g->kind == WORLD_SPHERES && instance == FATHOM_NONE)
        return world_sphere_radius(&w->spheres.items[g->first + k]);
    if (g->kind != WORLD_MESH || g->moving || !rests) return radius;
    const uint32_t vertices = world_mesh(w, geometry)->vertex_count;
    if (vertices > list->vertices) return radius;
    list->vertices -= vertices;
    return fmin(radius, reach_of(w, geometry, instance, bounds_center(b)));
}

static void add_geometry(const render_plan *plan, uint32_t geometry, uint32_t instance, caster_list *list) {
    const world *w = plan->world;
    const world_geometry *g = &w->geometries.items[geometry];
    const uint32_t step = g->kind == WORLD_MESH ? g->count : 1;
    for (uint32_t k = 0; k < g->count; k += step) {
        const fathom_id material = world_material(w, geometry, k, instance);
        if (material == FATHOM_NONE || !list->smooth[material]) continue;
        scene_bounds b = bounds_of(w, g, k);
        if (instance != FATHOM_NONE) b = placed(w, instance, &b);
        add(list, bounds_center(&b), radius_of(w, geometry, k, instance, &b, list));
    }
}

static void add_group(const render_plan *plan, const world_group *group, uint32_t instance,
                      caster_list *list) {
    for (uint32_t k = 0; k < group->count; ++k) add_geometry(plan, group->first + k, instance, list);
}

bool caustic_casters_find(const render_plan *plan, caustics *out) {
    const world *w = plan->world;
    caustic_caster room[CAUSTIC_CASTERS + 1];
    bool *smooth = calloc(plan->scene->materials.count + 1, sizeof *smooth);
    caster_list list = {room, 0, smooth, MOST_VERTICES};
    out->ends = calloc(plan->scene->materials.count + 1, sizeof *out->ends);
    if (!judge_materials(plan, smooth, out->ends)) {
        free(smooth);
        return false;
    }
    add_group(plan, &w->groups.items[0], FATHOM_NONE, &list);
    for (size_t k = 0; k < w->instances.count; ++k)
        add_group(plan, &w->groups.items[w->instances.items[k].group], (uint32_t)k, &list);
    join_overlapping(&list);
    free(smooth);
    for (uint32_t k = 0; k < list.count; ++k) out->casters[k] = list.of[k];
    out->count = list.count;
    return true;
}
