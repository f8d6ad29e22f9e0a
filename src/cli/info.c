/* `fathom info`: what a scene holds, what rendering it will take, and what is wrong with it. */
#include "cli/command.h"
#include "cli/json_text.h"
#include "cli/notes.h"

#include "base/memory.h"
#include "base/status.h"
#include "film/film.h"
#include "image/image.h"
#include "integrate/parts.h"
#include "material/material.h"
#include "scene/graph.h"
#include "scene/mesh/closed.h"
#include "scene/world/world.h"
#include "trace/embree/embree_limits.h"
#include "json/memory.h"

#include <stdlib.h>

typedef struct info_settings {
    command_common common;
    const char *scene, *camera;
    fathom_up up;
    bool json;
} info_settings;

/* ---- counting ---- */

static uint64_t triangles_of_group(const fathom_scene *scene, const scene_graph *graph, uint32_t group) {
    uint64_t triangles = 0;
    for (uint32_t k = graph->objects.first[group]; k < graph->objects.first[group + 1]; ++k) {
        scene_object object = scene->objects.items[graph->objects.items[k]];
        if (object.kind == SCENE_MESH) triangles += scene->meshes.items[object.index].triangle_count;
    }
    return triangles;
}

/* How often each group appears follows from its parents, which come first in the graph's order. */
static fathom_status count_placed(const fathom_scene *scene, uint64_t *out) {
    scene_graph graph;
    *out = 0;
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
        *out += placed[group] * triangles_of_group(scene, &graph, group);
        for (uint32_t i = graph.instances.first[group]; i < graph.instances.first[group + 1]; ++i) {
            const fathom_instance *instance = &scene->instances.items[graph.instances.items[i]];
            placed[instance->group] += placed[group];
        }
    }
    free(placed);
    graph_destroy(&graph);
    return FATHOM_OK;
}

typedef struct material_uses {
    unsigned bits;
    bool phong, blinn, fresnel, lit_from_behind;
} material_uses;

static void add_material(const fathom_scene *scene, fathom_id id, material_uses *uses) {
    const fathom_material *m = &scene->materials.items[id].classic;
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

static fathom_status any_closed(const world *w, bool *out) {
    closed_how *closed = calloc(w->geometries.count + 1, sizeof *closed);
    bool fine = closed && closed_find(w, closed);
    *out = false;
    for (size_t i = 0; fine && i < w->geometries.count; ++i) *out |= closed[i] != CLOSED_NOT;
    free(closed);
    return fine ? FATHOM_OK : fail_memory(w->scene->context, w->geometries.count * sizeof *closed);
}

/* ---- the object ---- */

static json_t *pack_counts(const fathom_scene *scene, const world *w, uint64_t placed) {
    return json_of(JSON("triangles", scene_triangles(scene)), JSON("placedTriangles", placed),
                   JSON("degenerateTriangles", w->degenerate_triangles), JSON("meshes", scene->meshes.count),
                   JSON("spheres", scene->spheres.count), JSON("quads", scene->quads.count),
                   JSON("planes", scene->planes.count), JSON("instances", scene->instances.count),
                   JSON("groups", scene->groups.count - 1), JSON("materials", scene->materials.count));
}

static json_t *pack_lights(const fathom_scene *scene) {
    uint64_t counts[3] = {0};
    for (size_t i = 0; i < scene->lights.count; ++i) ++counts[scene->lights.items[i].type];
    return json_of(JSON("point", counts[FATHOM_LIGHT_POINT]),
                   JSON("directional", counts[FATHOM_LIGHT_DIRECTIONAL]),
                   JSON("spot", counts[FATHOM_LIGHT_SPOT]), JSON("environment", scene->environments.count));
}

static json_t *pack_bounds(const scene_bounds *b) {
    if (bounds_is_empty(b)) return json_null();
    return json_of(JSON("lower", json_vector(b->lower.x, b->lower.y, b->lower.z)),
                   JSON("upper", json_vector(b->upper.x, b->upper.y, b->upper.z)));
}

static json_t *pack_camera(const fathom_camera *c) {
    return json_of(JSON("origin", json_vector(c->origin[0], c->origin[1], c->origin[2])),
                   JSON("direction", json_vector(-c->z[0], -c->z[1], -c->z[2])));
}

static json_t *pack_cameras(const fathom_scene *scene) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->cameras.count; ++i) {
        const scene_camera *c = &scene->cameras.items[i];
        json_array_append_new(list, json_of(JSON("node", c->name), JSON("name", c->own_name),
                                            JSON("orthographic", c->orthographic),
                                            JSON("taken", (bool)(i == scene->camera_taken))));
    }
    return list;
}

/* Memory at its highest: building adds to the tree what is given back when it stands. */
static fathom_status add_memory(const fathom_scene *scene, const world *w, json_t *root) {
    const fathom_settings *s = &scene->settings;
    const trace_need need = trace_need_of(w, false);
    const uint64_t program = MEMORY_PROGRAM, bvh = (uint64_t)need.kept, building = (uint64_t)need.passed;
    const uint64_t film = settings_pixels(s) * film_channels(s->aovs) * sizeof(float);
    uint64_t geometry;
    fathom_status status = scene_buffer_bytes(scene, SCENE_TRACED | SCENE_SHADED, &geometry);
    json_add(root,
             JSON("memoryBytes", json_of(JSON("program", program), JSON("geometry", geometry),
                                         JSON("bvh", bvh), JSON("building", building), JSON("film", film),
                                         JSON("total", program + geometry + bvh + building + film))));
    return status;
}

static json_t *pack_features(const fathom_scene *scene) {
    bool nested = false, smooth = false, lights[3] = {false};
    for (size_t i = 0; i < scene->meshes.count; ++i) smooth |= scene->meshes.items[i].normals != NULL;
    for (size_t i = 0; i < scene->instances.count; ++i)
        nested |= scene->instances.items[i].parent != FATHOM_ROOT;
    for (size_t i = 0; i < scene->lights.count; ++i) lights[scene->lights.items[i].type] = true;
    const float *ambient = scene->ambient;
    const material_uses uses = materials_in_use(scene);
    const struct {
        bool used;
        const char *name;
    } features[] = {{scene->spheres.count, "spheres"},
                    {scene->quads.count, "quads"},
                    {scene->planes.count, "planes"},
                    {scene_triangles(scene), "triangles"},
                    {smooth, "smooth normals"},
                    {scene->instances.count, "instances"},
                    {nested, "nested groups"},
                    {lights[FATHOM_LIGHT_POINT], "point lights"},
                    {lights[FATHOM_LIGHT_DIRECTIONAL], "directional lights"},
                    {lights[FATHOM_LIGHT_SPOT], "spot lights"},
                    {scene->environments.count, "environments"},
                    {ambient[0] > 0 || ambient[1] > 0 || ambient[2] > 0, "ambient"},
                    {uses.phong, "Phong"},
                    {uses.blinn, "Blinn"},
                    {uses.bits & MATERIAL_MIRROR, "mirrors"},
                    {uses.bits & MATERIAL_REFRACT, "refraction"},
                    {uses.fresnel, "Fresnel"},
                    {uses.bits & MATERIAL_EMIT, "emission"},
                    {uses.lit_from_behind, "lit from behind"}};
    json_t *list = json_array();
    for (size_t i = 0; i < sizeof features / sizeof *features; ++i) {
        if (features[i].used) json_array_append_new(list, json_string(features[i].name));
    }
    return list;
}

/* For a render with the scene's own settings. */
static fathom_status add_left_out(const world *w, json_t *root) {
    left_out_list list = {.count = 0};
    fathom_write_options usual;
    bool closed;
    fathom_status status = any_closed(w, &closed);
    if (status != FATHOM_OK) return status;
    fathom_write_options_default(&usual);
    bool fine = left_out_find(w, &w->scene->settings, closed, &list);
    if (fine && image_view_is_srgb(&usual)) fine = left_out_image_module(&list);
    json_add(root, JSON("leftOut", left_out_json(&list)));
    array_free(&list);
    return fine ? FATHOM_OK : fail_memory(w->scene->context, sizeof(fathom_left_out));
}

/* Things that can be rendered but hardly can be meant. */
static void look_for_problems(const fathom_scene *scene, const world *w, warning_list *problems) {
    char text[128];
    if (w->degenerate_triangles) {
        snprintf(text, sizeof text, "triangles without area that are left out: %llu",
                 (unsigned long long)w->degenerate_triangles);
        warnings_keep(problems, text);
    }
    if (w->beyond_reach) {
        snprintf(text, sizeof text,
                 "shapes and triangles beyond %g from the origin, which Embree leaves out: %llu", WORLD_REACH,
                 (unsigned long long)w->beyond_reach);
        warnings_keep(problems, text);
    }
    const float *ambient = scene->ambient;
    const bool emits = materials_in_use(scene).bits & MATERIAL_EMIT;
    if (!scene->lights.count && !scene->environments.count && !emits &&
        !(ambient[0] > 0 || ambient[1] > 0 || ambient[2] > 0))
        warnings_keep(problems, "no light, no ambient light and nothing that emits: every surface is black");
}

static fathom_status add_facts(const fathom_scene *scene, const world *w, json_t *root) {
    const fathom_settings *s = &scene->settings;
    scene_bounds bounds;
    uint64_t placed;
    fathom_status status = count_placed(scene, &placed);
    if (status == FATHOM_OK) status = scene_world_bounds(scene, &bounds);
    if (status != FATHOM_OK) return status;
    json_add(root, JSON("scene", scene->name), JSON("counts", pack_counts(scene, w, placed)),
             JSON("lights", pack_lights(scene)), JSON("bounds", pack_bounds(&bounds)),
             JSON("camera", pack_camera(&scene->camera)), JSON("cameras", pack_cameras(scene)),
             JSON("image", json_of(JSON("width", s->width), JSON("height", s->height), JSON("spp", s->spp))));
    status = add_memory(scene, w, root);
    json_add(root, JSON("features", pack_features(scene)));
    return status == FATHOM_OK ? add_left_out(w, root) : status;
}

/* Making the world also turns away scenes of more instances than can be built. */
static fathom_status gather(const fathom_scene *scene, json_t *root, warning_list *problems) {
    world *w;
    fathom_status status = world_create(scene, &w);
    if (status != FATHOM_OK) return status;
    status = world_check(w);
    if (status == FATHOM_OK) status = reach_check(scene->context, w);
    if (status == FATHOM_OK) status = add_facts(scene, w, root);
    if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    if (status == FATHOM_OK) look_for_problems(scene, w, problems);
    world_destroy(w);
    return status;
}

/* ---- the text ---- */

/* By the numbers that --camera takes. */
static void print_cameras(const json_t *cameras) {
    size_t i;
    json_t *c;
    json_array_foreach(cameras, i, c) {
        const char *node = json_text_at(c, "node"), *own = json_text_at(c, "name");
        const bool named = *node || *own;
        printf("%s%zu ", i ? "          " : "cameras   ", i);
        print_name(stdout, node);
        if (*own) {
            fputs(*node ? " (" : "(", stdout);
            print_name(stdout, own);
            putchar(')');
        }
        if (json_is_true(json_at(c, "orthographic"))) printf("%sorthographic", named ? ", " : "");
        puts(json_is_true(json_at(c, "taken")) ? " <- taken" : "");
    }
}

static void print_vector(const json_t *v, int digits) {
    printf("(%.*g, %.*g, %.*g)", digits, json_number_value(json_array_get(v, 0)), digits,
           json_number_value(json_array_get(v, 1)), digits, json_number_value(json_array_get(v, 2)));
}

static void print_pair(const char *title, const json_t *first, const char *between, const json_t *second,
                       int digits) {
    printf("%s", title);
    print_vector(first, 9);
    printf("%s", between);
    print_vector(second, digits);
    putchar('\n');
}

static void print_facts(const json_t *root) {
    size_t i;
    json_t *item;
    fputs("scene     ", stdout);
    print_name(stdout, json_text_at(root, "scene"));
    json_print(root, "\ntriangles {counts.triangles:.0f} in {counts.meshes:.0f} mesh");
    if (json_number_at(root, "counts.meshes") != 1) fputs("es", stdout);
    if (json_number_at(root, "counts.placedTriangles") != json_number_at(root, "counts.triangles"))
        json_print(root, "; {counts.placedTriangles:.0f} with instances");
    json_print(
        root,
        "\nshapes    {counts.spheres:.0f} spheres, {counts.quads:.0f} quads, {counts.planes:.0f} planes\n"
        "instances {counts.instances:.0f} of {counts.groups:.0f} groups\n"
        "lights    {lights.point:.0f} point, {lights.directional:.0f} directional, {lights.spot:.0f} "
        "spot\n"
        "materials {counts.materials:.0f}\n");
    if (json_is_object(json_at(root, "bounds")))
        print_pair("bounds    ", json_at(root, "bounds.lower"), " to ", json_at(root, "bounds.upper"), 9);
    print_pair("camera    at ", json_at(root, "camera.origin"), " looking along ",
               json_at(root, "camera.direction"), 6);
    print_cameras(json_object_get(root, "cameras"));
    json_print(root, "image     {image.width:.0f}x{image.height:.0f}, {image.spp:.0f} spp\n"
                     "memory    about {memoryBytes.total:.0fM} MB: program {memoryBytes.program:.0fM}, "
                     "geometry {memoryBytes.geometry:.1fM}, BVH {memoryBytes.bvh:.1fM}, building it "
                     "{memoryBytes.building:.1fM}, film {memoryBytes.film:.1fM}\n"
                     "features ");
    json_array_foreach(json_object_get(root, "features"), i, item)
        printf("%s %s", i ? "," : "", json_string_value(item));
    putchar('\n');
    json_array_foreach(json_object_get(root, "leftOut"), i, item) {
        printf("%-10s", i ? "" : "left out");
        json_print(item, "{what:s}: {why:s}\n");
    }
    item = json_object_get(root, "problems");
    printf("problems  %s\n", json_array_size(item) ? "" : "none");
    for (i = 0; i < json_array_size(item); ++i) printf("  %s\n", json_string_value(json_array_get(item, i)));
}

/* ---- the command ---- */

static fathom_status print_json(fathom_context *context, const json_t *root) {
    char *bytes = json_dump_text(root, 0);
    if (!bytes) return fail_memory(context, 4096);
    puts(bytes);
    free(bytes);
    return FATHOM_OK;
}

static fathom_status print(fathom_context *context, const info_settings *settings, fathom_status status,
                           const json_t *root) {
    if (json_memory_lacked()) return say_status(&command_info, context, fail_memory(context, 4096));
    if (settings->json) {
        const fathom_status printed = print_json(context, root);
        return printed == FATHOM_OK ? status : say_status(&command_info, context, printed);
    }
    say_status(&command_info, context, status);
    if (status == FATHOM_OK) print_facts(root);
    return status;
}

static fathom_status describe(fathom_context *context, const info_settings *settings,
                              warning_list *problems) {
    fathom_scene *scene = NULL;
    json_t *facts = json_object();
    const fathom_read_options read = {.camera = settings->camera, .up = settings->up};
    fathom_status status = fathom_scene_read_with(context, settings->scene, &read, &scene);
    if (status == FATHOM_OK) {
        status = gather(scene, facts, problems);
        if (status == FATHOM_BAD_INPUT && !*fathom_context_error(context)->place->file)
            fail_within(context, status, &(fathom_place){.file = settings->scene});
    }
    /* Lack of memory is no property of the scene. */
    if (status == FATHOM_OUT_OF_RESOURCES) {
        say_status(&command_info, context, status);
    } else {
        const bool renderable = status == FATHOM_OK;
        if (!renderable) warnings_keep(problems, fathom_context_message(context));
        json_t *root = json_of(JSON("file", settings->scene), JSON("renderable", renderable));
        if (renderable) json_object_update(root, facts);
        json_add(root, JSON("problems", warnings_json(problems)));
        status = print(context, settings, status, root);
        json_decref(root);
    }
    json_decref(facts);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status describe_with_problems(fathom_context *context, void *settings) {
    warning_list problems = {.count = 0};
    fathom_context_on_warning(context, warnings_keep, &problems);
    fathom_status status = describe(context, settings, &problems);
    warnings_free(&problems);
    return status;
}

static fathom_status run(int argc, char **argv) {
    info_settings settings = {.scene = NULL};
    return command_run(&command_info, argc, argv, &settings, describe_with_problems);
}

static const args_option options[] = {
    {.help = "Options"},
    COMMAND_CAMERA(info_settings),
    COMMAND_UP(info_settings),
    {"json", 0, NULL, take_true, offsetof(info_settings, json), 0, 0, "as JSON"},
    COMMAND_ALLOW_OUTSIDE(command_common),
    COMMAND_THREADS,
    {.help = NULL},
};
static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {offsetof(info_settings, scene)};

const command command_info = {
    .name = "info",
    .usage = "SCENE [options]",
    .summary = "Tell what a scene holds, what it will take, and what is wrong with it.",
    .text = "Counts, bounds, features used, what a render leaves out and why, an estimate of\n"
            "the memory it takes, and the problems found. The exit code is 3 when the scene\n"
            "cannot be rendered with Embree, the usual tracer.\n",
    .args = {options, operands, operand_offsets, 1},
    .run = run,
};
