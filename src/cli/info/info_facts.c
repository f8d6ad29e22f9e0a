#include "cli/info/info_facts.h"

#include "base/memory.h"
#include "cli/render/left_out.h"
#include "film/film.h"
#include "image/image.h"
#include "material/material.h"
#include "scene/graph.h"
#include "scene/mesh/closed.h"
#include "scene/world/world.h"
#include "trace/embree/embree_limits.h"

#include <stdlib.h>

static uint64_t triangles_of_group(const fathom_scene *scene, const scene_graph *graph, uint32_t group) {
    uint64_t triangles = 0;
    for (uint32_t k = graph->objects.first[group]; k < graph->objects.first[group + 1]; ++k) {
        scene_object object = scene->objects.items[graph->objects.items[k]];
        if (object.kind == SCENE_MESH) triangles += scene->meshes.items[object.index].triangle_count;
    }
    return triangles;
}

/* How often each group appears follows from its parents, which come first in the graph's order. */
static fathom_status count_placed(const fathom_scene *scene, info_facts *out) {
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    uint64_t *placed = calloc(scene->groups.count, sizeof *placed);
    if (!placed) {
        graph_destroy(&graph);
        return fail_memory(scene->context, scene->groups.count * sizeof *placed);
    }
    placed[FATHOM_ROOT] = 1;
    for (uint32_t k = 0; k < graph.order_count; ++k) {
        uint32_t group = graph.order[k];
        out->placed_triangles += placed[group] * triangles_of_group(scene, &graph, group);
        for (uint32_t i = graph.instances.first[group]; i < graph.instances.first[group + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph.instances.items[i]];
            placed[instance->group] += placed[group];
        }
    }
    free(placed);
    graph_destroy(&graph);
    return FATHOM_OK;
}

static void add_feature(info_facts *out, bool used, const char *name) {
    if (used && out->feature_count < INFO_FEATURES_MAX) out->features[out->feature_count++] = name;
}

typedef struct material_uses {
    unsigned bits;
    bool phong, blinn, fresnel, lit_from_behind;
} material_uses;

static void add_material(const fathom_scene *scene, fathom_id id, material_uses *uses) {
    const fathom_material *m = &scene->materials.items[id].value;
    uses->bits |= material_features(m);
    const bool specular = m->k_s[0] > 0 || m->k_s[1] > 0 || m->k_s[2] > 0;
    uses->phong |= specular && m->specular == FATHOM_SPECULAR_PHONG;
    uses->blinn |= specular && m->specular == FATHOM_SPECULAR_BLINN;
    uses->fresnel |= m->fresnel;
    uses->lit_from_behind |= m->lit_from_behind;
}

static material_uses materials_in_use(const fathom_scene *scene) {
    material_uses uses = {.bits = 0};
    for (size_t i = 0; i < scene->objects.count; ++i) {
        add_material(scene, scene_object_material(scene, (fathom_id)i), &uses);
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE) add_material(scene, material, &uses);
    }
    return uses;
}

static void list_features(const fathom_scene *scene, info_facts *out) {
    bool nested = false, smooth = false;
    for (size_t i = 0; i < scene->meshes.count; ++i) smooth |= scene->meshes.items[i].normals != NULL;
    for (size_t i = 0; i < scene->instances.count; ++i)
        nested |= scene->instances.items[i].parent != FATHOM_ROOT;
    material_uses uses = materials_in_use(scene);
    add_feature(out, out->spheres, "spheres");
    add_feature(out, out->quads, "quads");
    add_feature(out, out->planes, "planes");
    add_feature(out, out->triangles, "triangles");
    add_feature(out, smooth, "smooth normals");
    add_feature(out, out->instances, "instances");
    add_feature(out, nested, "nested groups");
    add_feature(out, out->point_lights, "point lights");
    add_feature(out, out->directional_lights, "directional lights");
    add_feature(out, out->spot_lights, "spot lights");
    add_feature(out, scene->ambient[0] > 0 || scene->ambient[1] > 0 || scene->ambient[2] > 0, "ambient");
    add_feature(out, uses.phong, "Phong");
    add_feature(out, uses.blinn, "Blinn");
    add_feature(out, uses.bits & MATERIAL_MIRROR, "mirrors");
    add_feature(out, uses.bits & MATERIAL_REFRACT, "refraction");
    add_feature(out, uses.fresnel, "Fresnel");
    add_feature(out, uses.bits & MATERIAL_EMIT, "emission");
    add_feature(out, uses.lit_from_behind, "lit from behind");
}

static void count_items(const fathom_scene *scene, info_facts *out) {
    out->spheres = scene->spheres.count;
    out->quads = scene->quads.count;
    out->planes = scene->planes.count;
    out->meshes = scene->meshes.count;
    out->materials = scene->materials.count;
    out->groups = scene->groups.count;
    out->instances = scene->instances.count;
    out->triangles = scene_triangles(scene);
    for (size_t i = 0; i < scene->lights.count; ++i) {
        switch (scene->lights.items[i].type) {
        case FATHOM_LIGHT_POINT: ++out->point_lights; break;
        case FATHOM_LIGHT_DIRECTIONAL: ++out->directional_lights; break;
        case FATHOM_LIGHT_SPOT: ++out->spot_lights; break;
        }
    }
}

static fathom_status any_closed(const world *w, bool *out) {
    closed_how *closed = calloc(w->geometries.count + 1, sizeof *closed);
    bool fine = closed && closed_find(w, closed);
    *out = false;
    for (size_t i = 0; fine && i < w->geometries.count; ++i) *out |= closed[i] != CLOSED_NOT;
    free(closed);
    return fine ? FATHOM_OK : fail_memory(w->scene->context, w->geometries.count * sizeof *closed);
}

static fathom_status list_left_out(const world *w, info_facts *out) {
    const fathom_settings *settings = &w->scene->settings;
    bool closed;
    fathom_status status = any_closed(w, &closed);
    if (status != FATHOM_OK) return status;
    fathom_write_options usual;
    fathom_write_options_default(&usual);
    bool fine = left_out_find(w, settings, closed, &out->left_out);
    if (fine && image_view_is_srgb(&usual)) fine = left_out_image_module(&out->left_out);
    return fine ? FATHOM_OK : fail_memory(w->scene->context, sizeof(fathom_left_out));
}

void info_release(info_facts *facts) { array_free(&facts->left_out); }

/* Making the world also turns away scenes of more instances than can be built. */
static fathom_status look_at_world(const fathom_scene *scene, info_facts *out) {
    world *w;
    fathom_status status = world_create(scene, &w);
    if (status != FATHOM_OK) return status;
    out->degenerate_triangles = w->degenerate_triangles, out->beyond_reach = w->beyond_reach;
    trace_need need = trace_need_of(w, false);
    out->bvh_bytes = (uint64_t)need.kept, out->build_bytes = (uint64_t)need.passed;
    status = world_check(w);
    if (status == FATHOM_OK) status = reach_check(scene->context, w);
    if (status == FATHOM_OK) status = list_left_out(w, out);
    world_destroy(w);
    return status;
}

fathom_status info_gather(const fathom_scene *scene, info_facts *out) {
    *out = (info_facts){.spheres = 0};
    count_items(scene, out);
    fathom_status status = look_at_world(scene, out);
    if (status == FATHOM_OK) status = count_placed(scene, out);
    if (status == FATHOM_OK)
        status = scene_buffer_bytes(scene, SCENE_TRACED | SCENE_SHADED, &out->geometry_bytes);
    if (status == FATHOM_OK) status = scene_world_bounds(scene, &out->bounds);
    if (status != FATHOM_OK) return status;
    list_features(scene, out);
    const fathom_settings *s = &scene->settings;
    out->film_bytes = settings_pixels(s) * film_channels(s->aovs) * sizeof(float);
    out->program_bytes = MEMORY_PROGRAM;
    out->total_bytes =
        out->program_bytes + out->geometry_bytes + out->bvh_bytes + out->build_bytes + out->film_bytes;
    return FATHOM_OK;
}
