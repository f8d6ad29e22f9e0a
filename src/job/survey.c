/* Surveys of scenes: contents, the memory that rendering takes, and problems. */
#include "base/memory.h"
#include "base/sized.h"
#include "integrate/parts.h"
#include "job/lacks.h"
#include "light/environment.h"
#include "material/material.h"
#include "math/rgb.h"
#include "scene/graph.h"
#include "scene/mesh/closed.h"
#include "scene/scene.h"
#include "texture/texture.h"
#include "trace/embree/embree_limits.h"

#include <fathom/survey.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LIGHT_TYPES = FATHOM_LIGHT_ENVIRONMENT + 1, FEATURES_MOST = 33, PROBLEMS_MOST = LACKS_MOST + 1 };

/* A survey and the arrays that it points to. */
typedef struct survey {
    fathom_survey shown;
    fathom_camera camera;
    uint64_t lights[LIGHT_TYPES];
    ARRAY(fathom_camera_choice) cameras;
    const char *features[FEATURES_MOST];
    left_out_list left_out;
    const char *problems[PROBLEMS_MOST];
    char texts[PROBLEMS_MOST][PARTS_TEXT];
} survey;

/* ---- facts about a scene ---- */

const char *fathom_scene_name(const fathom_scene *scene) { return scene ? scene->name : ""; }

uint32_t fathom_scene_lights(const fathom_scene *scene) { return scene ? (uint32_t)scene->lights.count : 0; }

fathom_status fathom_scene_light_sized(const fathom_scene *scene, uint32_t index, fathom_light *out,
                                       size_t size) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!out) return fail_null(scene->context, "out");
    if (index >= scene->lights.count)
        return fail_item(scene->context, FATHOM_BAD_USAGE, "lights", index, "the scene has %zu",
                         scene->lights.count);
    sized_give(out, size, &scene->lights.items[index], sizeof *out);
    return FATHOM_OK;
}

/* ---- counting ---- */

/* Triangles and shapes. */
typedef struct amount {
    uint64_t triangles, shapes;
} amount;

static void add_amount(amount *to, amount from) {
    to->triangles += from.triangles, to->shapes += from.shapes;
}

static bool material_emits(const fathom_scene *scene, fathom_id material) {
    return material_features(&scene->materials.items[material].classic) & MATERIAL_EMIT;
}

static amount amount_of(const fathom_scene *scene, scene_object object) {
    if (object.kind != SCENE_MESH) return (amount){.shapes = 1};
    const fathom_mesh *mesh = &scene->meshes.items[object.index];
    return mesh->point_radius > 0 ? (amount){.shapes = mesh->vertex_count}
                                  : (amount){.triangles = mesh->triangle_count};
}

/* Sets what is in a group, and how much of it emits, from its objects and from the groups in it. An
 * instance's material replaces those inside. */
static void add_group(const fathom_scene *scene, const scene_graph *graph, uint32_t group, amount *all,
                      amount *emits) {
    for (uint32_t k = graph->objects.first[group]; k < graph->objects.first[group + 1]; ++k) {
        const uint32_t object = graph->objects.items[k];
        const amount a = amount_of(scene, scene->objects.items[object]);
        add_amount(&all[group], a);
        if (material_emits(scene, scene_object_material(scene, object))) add_amount(&emits[group], a);
    }
    for (uint32_t k = graph->instances.first[group]; k < graph->instances.first[group + 1]; ++k) {
        const fathom_instance *instance = &scene->instances.items[graph->instances.items[k]];
        const bool own = instance->material == FATHOM_NONE;
        add_amount(&all[group], all[instance->group]);
        if (own || material_emits(scene, instance->material))
            add_amount(&emits[group], (own ? emits : all)[instance->group]);
    }
}

/* Groups come after all groups that hold them in the graph's order. */
static fathom_status count_placed(const fathom_scene *scene, fathom_survey *out) {
    const size_t groups = scene->groups.count;
    scene_graph graph;
    fathom_status status = graph_create(scene, &graph);
    if (status != FATHOM_OK) return status;
    amount *all = calloc(2 * groups, sizeof *all), *emits = all + groups;
    if (all) {
        for (uint32_t k = graph.order_count; k > 0; --k)
            add_group(scene, &graph, graph.order[k - 1], all, emits);
        out->placed_triangles = all[FATHOM_ROOT].triangles;
        out->emissive_triangles = emits[FATHOM_ROOT].triangles;
        out->emissive_shapes = emits[FATHOM_ROOT].shapes;
    }
    graph_destroy(&graph);
    if (!all) return fail_memory(scene->context, 2 * groups * sizeof *all);
    free(all);
    return FATHOM_OK;
}

/* True if the integrator uses neither the lights nor the ambient light. */
static bool replaced(const fathom_scene *scene) {
    return scene->settings.integrator != FATHOM_INTEGRATOR_CLASSIC && scene_replaces_lights(scene);
}

/* Every scene has material 0, which has no name; it counts if a shape has it. */
static uint64_t count_materials(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->objects.count; ++i)
        if (scene_object_material(scene, (fathom_id)i) == 0) return scene->materials.count;
    return scene->materials.count - 1;
}

static fathom_status count(const fathom_scene *scene, const world *w, survey *out) {
    fathom_survey *s = &out->shown;
    s->triangles = scene_triangles(scene);
    s->degenerate_triangles = w->degenerate_triangles;
    s->points = scene_points(scene);
    for (size_t i = 0; i < scene->meshes.count; ++i) s->clouds += scene->meshes.items[i].point_radius > 0;
    s->meshes = scene->meshes.count - s->clouds, s->spheres = scene->spheres.count,
    s->quads = scene->quads.count;
    s->planes = scene->planes.count, s->instances = scene->instances.count;
    s->groups = scene->groups.count - 1, s->materials = count_materials(scene);
    for (size_t i = 0; i < scene->lights.count && !replaced(scene); ++i)
        ++out->lights[scene->lights.items[i].type];
    out->lights[FATHOM_LIGHT_ENVIRONMENT] = scene->environments.count;
    s->lights = out->lights;
    return count_placed(scene, s);
}

static fathom_status find_place(const fathom_scene *scene, survey *out) {
    fathom_survey *s = &out->shown;
    scene_bounds bounds;
    fathom_status status = scene_world_bounds(scene, &bounds);
    if (status != FATHOM_OK) return status;
    s->has_bounds = !bounds_is_empty(&bounds);
    if (s->has_bounds) store_f64(s->lower, bounds.lower), store_f64(s->upper, bounds.upper);
    out->camera = scene->camera;
    s->camera = &out->camera;
    for (uint32_t i = 0; i < scene->cameras.count; ++i) {
        const scene_camera *c = &scene->cameras.items[i];
        char *node = c->name ? strdup(c->name) : NULL, *name = c->own_name ? strdup(c->own_name) : NULL;
        const fathom_camera_choice choice = {node, name, c->orthographic, i == scene->camera_taken};
        if ((!c->name || node) && (!c->own_name || name) && array_push(&out->cameras, choice)) continue;
        free(node);
        free(name);
        return fail_memory(scene->context, sizeof choice);
    }
    s->cameras = out->cameras.items, s->camera_count = (uint32_t)out->cameras.count;
    return FATHOM_OK;
}

/* The peak: building needs memory in addition to the tree, and releases it at the end. */
static fathom_status find_memory(const fathom_scene *scene, const world *w, fathom_survey *s) {
    fathom_status status = scene_buffer_bytes(scene, SCENE_TRACED | SCENE_SHADED, &s->mesh_bytes);
    const trace_need need = trace_need_of(w, false);
    s->program_bytes = MEMORY_PROGRAM;
    s->bvh_bytes = (uint64_t)need.kept, s->building_bytes = (uint64_t)need.passed;
    s->film_bytes = settings_pixels(&scene->settings) *
                    film_channels(&scene->settings, &scene->light_groups) * sizeof(float);
    s->mesh_bytes += w->carried_bytes;
    if (status == FATHOM_OK && scene->has_maps)
        status =
            texture_cache_measure(scene->context, scene, scene->settings.texture_memory, &s->texture_bytes);
    if (status == FATHOM_OK && scene->settings.integrator != FATHOM_INTEGRATOR_CLASSIC)
        status = environment_measure(scene->context, scene, &s->environment_bytes);
    return status;
}

/* ---- features ---- */

typedef struct material_uses {
    unsigned bits;
    bool phong, blinn, ggx, fresnel, lit_from_behind, clearcoat, sheen, anisotropy, iridescence, dispersion,
        diffuse_transmission, absorption, one_sided;
} material_uses;

static void add_material(const fathom_scene *scene, fathom_id id, material_uses *uses) {
    fathom_material classic, between;
    mapped_between_classic(&scene->materials.items[id].value, &classic);
    mapped_between(&scene->materials.items[id].value, &between);
    const fathom_material *m = &classic, *full = &between;
    const bool layered = full->model == FATHOM_MODEL_METALLIC_ROUGHNESS &&
                         scene->settings.integrator != FATHOM_INTEGRATOR_CLASSIC;
    uses->bits |= material_features(m);
    const bool specular = rgb_any(m->k_s);
    uses->phong |= specular && m->specular == FATHOM_SPECULAR_PHONG;
    uses->blinn |= specular && m->specular == FATHOM_SPECULAR_BLINN && !layered;
    uses->ggx |= layered;
    uses->clearcoat |= layered && full->clearcoat > 0;
    uses->sheen |= layered && rgb_any(full->sheen_color);
    uses->anisotropy |= layered && material_is_directed(full);
    uses->iridescence |= layered && full->iridescence > 0;
    uses->dispersion |= layered && full->dispersion > 0 && full->thickness > 0 && full->transmission > 0;
    uses->diffuse_transmission |= layered && full->diffuse_transmission > 0;
    uses->absorption |= layered && material_absorbs(full);
    uses->one_sided |= layered && material_is_one_sided(full);
    uses->fresnel |= m->fresnel;
    uses->lit_from_behind |= m->lit_from_behind;
}

static material_uses materials_in_use(const fathom_scene *scene) {
    material_uses uses = {.bits = 0};
    for (size_t i = 0; i < scene->objects.count; ++i)
        add_material(scene, scene_object_material(scene, (fathom_id)i), &uses);
    for (size_t i = 0; i < scene->instances.count; ++i) {
        fathom_id material = scene->instances.items[i].material;
        if (material != FATHOM_NONE) add_material(scene, material, &uses);
    }
    return uses;
}

static void find_features(const fathom_scene *scene, survey *out) {
    bool nested = false, smooth = false;
    for (size_t i = 0; i < scene->meshes.count; ++i) smooth |= scene->meshes.items[i].normals != NULL;
    for (size_t i = 0; i < scene->instances.count; ++i)
        nested |= scene->instances.items[i].parent != FATHOM_ROOT;
    const material_uses uses = materials_in_use(scene);
    const bool classic = scene->settings.integrator == FATHOM_INTEGRATOR_CLASSIC;
    const bool studio = scene->in_studio && !classic;
    const struct {
        bool used;
        const char *name;
    } features[] = {{scene->spheres.count, "spheres"},
                    {out->shown.points, "points"},
                    {scene->quads.count, "quads"},
                    {scene->planes.count, "planes"},
                    {out->shown.triangles, "triangles"},
                    {smooth, "smooth normals"},
                    {scene->instances.count, "instances"},
                    {nested, "nested groups"},
                    {scene_moving(scene), "motion"},
                    {scene->camera.lens_radius > 0, "depth of field"},
                    {out->lights[FATHOM_LIGHT_POINT], "point lights"},
                    {out->lights[FATHOM_LIGHT_DIRECTIONAL], "directional lights"},
                    {out->lights[FATHOM_LIGHT_SPOT], "spot lights"},
                    {scene->environments.count, "environments"},
                    {parts_ambient(scene) && !replaced(scene), "ambient"},
                    {studio, "the built-in studio"},
                    {scene->has_maps, "textures"},
                    {uses.phong, "Phong"},
                    {uses.blinn, "Blinn"},
                    {uses.ggx, "GGX"},
                    {uses.clearcoat, "clearcoat"},
                    {uses.sheen, "sheen"},
                    {uses.anisotropy, "anisotropy"},
                    {uses.iridescence, "iridescence"},
                    {uses.dispersion, "dispersion"},
                    {uses.diffuse_transmission, "diffuse transmission"},
                    {uses.absorption, "absorption"},
                    {uses.one_sided, "one-sided surfaces"},
                    {uses.bits & MATERIAL_MIRROR, "mirrors"},
                    {uses.bits & MATERIAL_REFRACT, "refraction"},
                    {uses.fresnel, "Fresnel"},
                    {uses.bits & MATERIAL_EMIT, "emission"},
                    {uses.lit_from_behind, "lit from behind"}};
    _Static_assert(sizeof features / sizeof *features <= FEATURES_MOST, "all features fit");
    for (size_t i = 0; i < sizeof features / sizeof *features; ++i) {
        if (features[i].used) out->features[out->shown.feature_count++] = features[i].name;
    }
    out->shown.features = out->features;
}

static fathom_status any_closed(const world *w, bool *out) {
    closed_how *closed = calloc(w->geometries.count + 1, sizeof *closed);
    bool fine = closed && closed_find(w, closed);
    *out = false;
    for (size_t i = 0; fine && i < w->geometries.count; ++i) *out |= closed[i] != CLOSED_NOT;
    free(closed);
    return fine ? FATHOM_OK : fail_memory(w->scene->context, w->geometries.count * sizeof *closed);
}

static fathom_status find_left_out(const world *w, survey *out) {
    bool closed;
    fathom_status status = any_closed(w, &closed);
    if (status != FATHOM_OK) return status;
    const bool fine = left_out_find(w, &w->scene->settings, closed, &out->left_out);
    out->shown.left_out = out->left_out.items;
    out->shown.left_out_count = (uint32_t)out->left_out.count;
    return fine ? FATHOM_OK : fail_memory(w->scene->context, sizeof(fathom_left_out));
}

/* ---- problems ---- */

static void add_problem(void *user, const char *text) {
    survey *out = user;
    char *to = out->texts[out->shown.problem_count];
    snprintf(to, sizeof *out->texts, "%s", text);
    out->problems[out->shown.problem_count++] = to;
}

static bool any_bright(const fathom_light *lights, size_t count) {
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c)
            if (lights[i].intensity[c] > 0) return true;
    return false;
}

static void find_problems(const fathom_scene *scene, const world *w, survey *out) {
    const fathom_integrator integrator = scene->settings.integrator;
    const bool sky = parts_background(scene) ||
                     any_bright(scene->environments.items, scene->environments.count),
               shines = sky && integrator != FATHOM_INTEGRATOR_CLASSIC,
               emits = shines || materials_in_use(scene).bits & MATERIAL_EMIT;
    out->shown.problems = out->problems;
    lacks_find(w, integrator, add_problem, out);
    if (!any_bright(scene->lights.items, scene->lights.count) && !emits && !parts_ambient(scene))
        add_problem(out, scene->lights.count + scene->environments.count
                             ? "no light whose intensity and color are above 0, no ambient light and nothing "
                               "that emits: every surface is black"
                             : "no light, no ambient light and nothing that emits: every surface is black");
}

static fathom_status fill(const fathom_scene *scene, const world *w, survey *out) {
    fathom_status status = world_check(w);
    if (status == FATHOM_OK) status = reach_check(scene->context, w);
    if (status == FATHOM_OK) status = count(scene, w, out);
    if (status == FATHOM_OK) status = find_place(scene, out);
    if (status == FATHOM_OK) status = find_memory(scene, w, &out->shown);
    if (status == FATHOM_OK && scene->settings.integrator != FATHOM_INTEGRATOR_CLASSIC)
        status = environment_check(scene->context, scene);
    if (status == FATHOM_OK) status = find_left_out(w, out);
    if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    if (status != FATHOM_OK) return status;
    find_features(scene, out);
    find_problems(scene, w, out);
    return FATHOM_OK;
}

/* Creating the world also rejects scenes with too many instances. */
fathom_status fathom_scene_survey(const fathom_scene *scene, const fathom_survey **out) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!out) return fail_null(scene->context, "out");
    *out = NULL;
    world *w;
    fathom_status status = fathom_scene_check(scene);
    if (status == FATHOM_OK) status = world_create(scene, &w);
    if (status != FATHOM_OK) return status;
    survey *made = calloc(1, sizeof *made);
    status = made ? fill(scene, w, made) : fail_memory(scene->context, sizeof *made);
    world_destroy(w);
    if (status == FATHOM_OK)
        *out = &made->shown;
    else
        fathom_survey_destroy(made ? &made->shown : NULL);
    return status;
}

/* `shown` is the first member of the survey. */
void fathom_survey_destroy(const fathom_survey *shown) {
    survey *s = (survey *)(uintptr_t)shown;
    if (!s) return;
    for (size_t i = 0; i < s->cameras.count; ++i) {
        free((void *)(uintptr_t)s->cameras.items[i].node);
        free((void *)(uintptr_t)s->cameras.items[i].name);
    }
    array_free(&s->cameras);
    array_free(&s->left_out);
    free(s);
}
