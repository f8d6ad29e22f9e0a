/* `fathom info`: the contents of a scene, the memory that rendering needs, and problems. */
#include "cli/command.h"
#include "cli/fail.h"
#include "cli/json_text.h"
#include "cli/notes.h"

#include "json/memory.h"

#include <fathom/image.h>
#include <fathom/read.h>
#include <fathom/survey.h>
#include <stdlib.h>

typedef struct info_settings {
    command_common common;
    const char *scene;
    command_model model;
    bool json;
} info_settings;

/* ---- the object ---- */

static json_t *pack_counts(const fathom_survey *s) {
    return json_of(JSON("triangles", s->triangles), JSON("placedTriangles", s->placed_triangles),
                   JSON("degenerateTriangles", s->degenerate_triangles), JSON("meshes", s->meshes),
                   JSON("spheres", s->spheres), JSON("points", s->points), JSON("clouds", s->clouds),
                   JSON("quads", s->quads), JSON("planes", s->planes), JSON("instances", s->instances),
                   JSON("groups", s->groups), JSON("materials", s->materials));
}

static json_t *pack_lights(const fathom_survey *s) {
    return json_of(
        JSON("point", s->lights[FATHOM_LIGHT_POINT]),
        JSON("directional", s->lights[FATHOM_LIGHT_DIRECTIONAL]), JSON("spot", s->lights[FATHOM_LIGHT_SPOT]),
        JSON("environment", s->lights[FATHOM_LIGHT_ENVIRONMENT]),
        JSON("emissiveTriangles", s->emissive_triangles), JSON("emissiveShapes", s->emissive_shapes));
}

static json_t *pack_vector(const double v[3]) { return json_vector(v[0], v[1], v[2]); }

static json_t *pack_bounds(const fathom_survey *s) {
    if (!s->has_bounds) return json_null();
    return json_of(JSON("lower", pack_vector(s->lower)), JSON("upper", pack_vector(s->upper)));
}

static json_t *pack_camera(const fathom_camera *c) {
    return json_of(JSON("origin", pack_vector(c->origin)),
                   JSON("direction", json_vector(0 - c->z[0], 0 - c->z[1], 0 - c->z[2])));
}

static json_t *pack_cameras(const fathom_survey *s) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < s->camera_count; ++i) {
        const fathom_camera_choice *c = &s->cameras[i];
        json_array_append_new(list, json_of(JSON("node", c->node), JSON("name", c->name),
                                            JSON("orthographic", c->orthographic), JSON("taken", c->taken)));
    }
    return list;
}

static json_t *pack_memory(const fathom_survey *s) {
    const uint64_t total = s->program_bytes + s->mesh_bytes + s->bvh_bytes + s->building_bytes +
                           s->film_bytes + s->texture_bytes + s->environment_bytes;
    return json_of(JSON("program", s->program_bytes), JSON("geometry", s->mesh_bytes),
                   JSON("bvh", s->bvh_bytes), JSON("building", s->building_bytes),
                   JSON("film", s->film_bytes), JSON("textures", s->texture_bytes),
                   JSON("environments", s->environment_bytes), JSON("total", total));
}

static json_t *pack_features(const fathom_survey *s) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < s->feature_count; ++i) json_array_append_new(list, json_string(s->features[i]));
    return list;
}

static json_t *pack_left_out(const fathom_survey *s) {
    fathom_write_options usual;
    fathom_write_options_default(&usual);
    const left_out_list list = {s->left_out, s->left_out_count, fathom_write_is_srgb(&usual)};
    return left_out_json(&list);
}

static void add_facts(const fathom_scene *scene, const fathom_survey *s, json_t *root) {
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    json_add(root, JSON("scene", fathom_scene_name(scene)), JSON("counts", pack_counts(s)),
             JSON("lights", pack_lights(s)), JSON("bounds", pack_bounds(s)),
             JSON("camera", pack_camera(s->camera)), JSON("cameras", pack_cameras(s)),
             JSON("image", json_of(JSON("width", settings.width), JSON("height", settings.height),
                                   JSON("spp", settings.spp), JSON("targetError", settings.target_error))),
             JSON("memoryBytes", pack_memory(s)), JSON("features", pack_features(s)),
             JSON("leftOut", pack_left_out(s)));
}

static fathom_status gather(const fathom_scene *scene, json_t *root, warning_list *problems) {
    const fathom_survey *survey;
    fathom_status status = fathom_scene_survey(scene, &survey);
    if (status != FATHOM_OK) return status;
    add_facts(scene, survey, root);
    for (uint32_t i = 0; i < survey->problem_count; ++i) warnings_keep(problems, survey->problems[i]);
    fathom_survey_destroy(survey);
    return FATHOM_OK;
}

/* ---- the text ---- */

/* Lists the cameras with the numbers that --camera takes. */
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

static void print_contents(const json_t *root) {
    fputs("scene     ", stdout);
    print_name(stdout, json_text_at(root, "scene"));
    json_print(root, "\ntriangles {counts.triangles:.0f} in {counts.meshes:.0f} mesh{counts.meshes:+es}");
    if (json_number_at(root, "counts.placedTriangles") != json_number_at(root, "counts.triangles"))
        json_print(root, "; {counts.placedTriangles:.0f} with instances");
    fputs("\nshapes    ", stdout);
    if (json_number_at(root, "counts.points") > 0)
        json_print(root, "{counts.points:.0f} point{counts.points:+s} in {counts.clouds:.0f} "
                         "cloud{counts.clouds:+s}, ");
    json_print(root, "{counts.spheres:.0f} sphere{counts.spheres:+s}, {counts.quads:.0f} "
                     "quad{counts.quads:+s}, {counts.planes:.0f} plane{counts.planes:+s}\n"
                     "instances {counts.instances:.0f} of {counts.groups:.0f} group{counts.groups:+s}\n"
                     "lights    {lights.point:.0f} point, {lights.directional:.0f} directional, "
                     "{lights.spot:.0f} spot, {lights.environment:.0f} environment");
    if (json_number_at(root, "lights.emissiveTriangles") > 0)
        json_print(root, ", {lights.emissiveTriangles:.0f} emissive triangle{lights.emissiveTriangles:+s}");
    if (json_number_at(root, "lights.emissiveShapes") > 0)
        json_print(root, ", {lights.emissiveShapes:.0f} emissive shape{lights.emissiveShapes:+s}");
    json_print(root, "\nmaterials {counts.materials:.0f}\n");
}

static void print_facts(const json_t *root) {
    size_t i;
    json_t *item;
    print_contents(root);
    if (json_is_object(json_at(root, "bounds")))
        print_pair("bounds    ", json_at(root, "bounds.lower"), " to ", json_at(root, "bounds.upper"), 9);
    print_pair("camera    at ", json_at(root, "camera.origin"), " looking along ",
               json_at(root, "camera.direction"), 6);
    print_cameras(json_object_get(root, "cameras"));
    const bool adaptive = json_number_at(root, "image.targetError") > 0;
    json_print(root, "image     {image.width:.0f}x{image.height:.0f}, ");
    json_print(root, adaptive ? "up to {image.spp:.0f} spp until the error is {image.targetError:.3g}\n"
                              : "{image.spp:.0f} spp\n");
    json_print(root, "memory    about {memoryBytes.total:.0fM} MB: program {memoryBytes.program:.0fM}, "
                     "geometry {memoryBytes.geometry:.1fM}, BVH {memoryBytes.bvh:.1fM}, building it "
                     "{memoryBytes.building:.1fM}, film {memoryBytes.film:.1fM}, textures "
                     "{memoryBytes.textures:.1fM}, environments {memoryBytes.environments:.1fM}\n"
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

static fathom_status print(fathom_context *context, const info_settings *settings, fathom_status status,
                           const json_t *root) {
    char *text = settings->json ? json_dump_text(root, 0) : NULL;
    if (json_memory_lacked() || (settings->json && !text))
        return say_status(&command_info, context, cli_fail_memory(context));
    if (text)
        puts(text);
    else if (say_status(&command_info, context, status) == FATHOM_OK)
        print_facts(root);
    free(text);
    return status;
}

static fathom_status describe(fathom_context *context, const info_settings *settings,
                              warning_list *problems) {
    fathom_scene *scene = NULL;
    json_t *facts = json_object();
    const fathom_read_options read = command_read_options(&settings->model);
    fathom_status status = fathom_scene_read_with(context, settings->scene, &read, &scene);
    if (status == FATHOM_OK) {
        status = gather(scene, facts, problems);
        if (status == FATHOM_BAD_INPUT) cli_fail_within(context, settings->scene);
    }
    /* Lack of memory is not a problem of the scene, so it is not part of the JSON. */
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

static const args_option options[] = {
    {.help = "Options"},
    COMMAND_MODEL(info_settings),
    COMMAND_VIEW(info_settings),
    {"json", 0, NULL, take_true, offsetof(info_settings, json), 0, 0, "as JSON"},
    COMMAND_ALLOW_OUTSIDE,
    COMMAND_THREADS,
    {.help = NULL},
};

const command command_info = {
    .name = "info",
    .usage = "SCENE [options]",
    .summary = "Print the contents, memory estimate and problems of a scene.",
    .text = "Prints counts, bounds, the features used, the parts of the renderer that a\n"
            "render skips and why, an estimate of its memory, and the problems found. The\n"
            "exit code is 3 if Embree, the default tracer, cannot render the scene.\n",
    .args = {options, {{"SCENE", offsetof(info_settings, scene)}}},
    COMMAND_BODY(describe_with_problems, info_settings, {.scene = NULL}),
};
