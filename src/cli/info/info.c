#include "cli/command.h"
#include "cli/info/info_facts.h"
#include "cli/interrupt.h"
#include "cli/json_text.h"
#include "cli/render/left_out.h"
#include "cli/render/warnings.h"

#include "base/status.h"
#include "scene/world/world.h"

#include <stdlib.h>
#include <string.h>

typedef struct info_settings {
    const char *scene, *camera;
    fathom_up up;
    unsigned threads;
    bool json, allow_outside;
} info_settings;

static double megabytes(uint64_t bytes) { return 1e-6 * (double)bytes; }

static void print_bounds(const scene_bounds *b) {
    if (bounds_is_empty(b)) return;
    printf("bounds    (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g)\n", b->lower.x, b->lower.y, b->lower.z,
           b->upper.x, b->upper.y, b->upper.z);
}

/* By the numbers that --camera takes. */
static void print_cameras(const fathom_scene *scene) {
    for (uint32_t i = 0; i < scene->cameras.count; ++i) {
        const scene_camera *c = &scene->cameras.items[i];
        printf("%s%u ", i ? "          " : "cameras   ", i);
        if (c->name) print_name(stdout, c->name);
        if (c->own_name) {
            fputs(c->name ? " (" : "(", stdout);
            print_name(stdout, c->own_name);
            putchar(')');
        }
        if (c->orthographic) fputs(c->name || c->own_name ? ", orthographic" : "orthographic", stdout);
        puts(i == scene->camera_taken ? " <- taken" : "");
    }
}

static void print_facts(const fathom_scene *scene, const info_facts *f) {
    const fathom_settings *s = &scene->settings;
    fputs("scene     ", stdout);
    print_name(stdout, scene->name);
    putchar('\n');
    printf("triangles %llu in %llu mesh%s", (unsigned long long)f->triangles, (unsigned long long)f->meshes,
           f->meshes == 1 ? "" : "es");
    if (f->placed_triangles != f->triangles)
        printf("; %llu with instances", (unsigned long long)f->placed_triangles);
    putchar('\n');
    printf("shapes    %llu spheres, %llu quads, %llu planes\n", (unsigned long long)f->spheres,
           (unsigned long long)f->quads, (unsigned long long)f->planes);
    printf("instances %llu of %llu groups\n", (unsigned long long)f->instances,
           (unsigned long long)f->groups - 1);
    printf("lights    %llu point, %llu directional, %llu spot\n", (unsigned long long)f->point_lights,
           (unsigned long long)f->directional_lights, (unsigned long long)f->spot_lights);
    printf("materials %llu\n", (unsigned long long)f->materials);
    print_bounds(&f->bounds);
    printf("camera    at (%.9g, %.9g, %.9g) looking along (%.6g, %.6g, %.6g)\n", scene->camera.origin[0],
           scene->camera.origin[1], scene->camera.origin[2], -scene->camera.z[0], -scene->camera.z[1],
           -scene->camera.z[2]);
    print_cameras(scene);
    printf("image     %ux%u, %u spp\n", s->width, s->height, s->spp);
    printf("memory    about %.0f MB: program %.0f, geometry %.1f, BVH %.1f, building it %.1f, film %.1f\n",
           megabytes(f->total_bytes), megabytes(f->program_bytes), megabytes(f->geometry_bytes),
           megabytes(f->bvh_bytes), megabytes(f->build_bytes), megabytes(f->film_bytes));
    printf("features ");
    for (size_t i = 0; i < f->feature_count; ++i) printf("%s %s", i ? "," : "", f->features[i]);
    putchar('\n');
    left_out_print(f->left_out.items, (uint32_t)f->left_out.count, "left out  ");
}

static void print_problems(const warning_list *problems) {
    printf("problems  %s\n", problems->count ? "" : "none");
    for (size_t i = 0; i < problems->count; ++i) printf("  %s\n", problems->items[i]);
}

static json_t *vector(double x, double y, double z) { return json_pack("[f, f, f]", x, y, z); }

static json_t *pack_counts(const info_facts *f) {
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "triangles",
                     json_count(f->triangles), "placedTriangles", json_count(f->placed_triangles),
                     "degenerateTriangles", json_count(f->degenerate_triangles), "meshes",
                     json_count(f->meshes), "spheres", json_count(f->spheres), "quads", json_count(f->quads),
                     "planes", json_count(f->planes), "instances", json_count(f->instances), "groups",
                     json_count(f->groups - 1), "materials", json_count(f->materials));
}

static json_t *name_or_null(const char *name) { return name ? json_text(name) : json_null(); }

static json_t *pack_cameras(const fathom_scene *scene) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->cameras.count; ++i) {
        const scene_camera *c = &scene->cameras.items[i];
        json_array_append_new(list, json_pack("{s:o, s:o, s:b, s:b}", "node", name_or_null(c->name), "name",
                                              name_or_null(c->own_name), "orthographic", c->orthographic,
                                              "taken", i == scene->camera_taken));
    }
    return list;
}

static void set_facts(json_t *root, const fathom_scene *scene, const info_facts *f) {
    const fathom_settings *s = &scene->settings;
    const fathom_camera *c = &scene->camera;
    json_object_set_new(root, "scene", json_text(scene->name));
    json_object_set_new(root, "counts", pack_counts(f));
    json_object_set_new(root, "lights",
                        json_pack("{s:o, s:o, s:o}", "point", json_count(f->point_lights), "directional",
                                  json_count(f->directional_lights), "spot", json_count(f->spot_lights)));
    json_t *bounds = json_null();
    if (!bounds_is_empty(&f->bounds))
        bounds =
            json_pack("{s:o, s:o}", "lower", vector(f->bounds.lower.x, f->bounds.lower.y, f->bounds.lower.z),
                      "upper", vector(f->bounds.upper.x, f->bounds.upper.y, f->bounds.upper.z));
    json_object_set_new(root, "bounds", bounds);
    json_object_set_new(root, "camera",
                        json_pack("{s:o, s:o}", "origin", vector(c->origin[0], c->origin[1], c->origin[2]),
                                  "direction", vector(-c->z[0], -c->z[1], -c->z[2])));
    json_object_set_new(root, "cameras", pack_cameras(scene));
    json_object_set_new(
        root, "image",
        json_pack("{s:i, s:i, s:i}", "width", (int)s->width, "height", (int)s->height, "spp", (int)s->spp));
    json_object_set_new(root, "memoryBytes",
                        json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "program", json_count(f->program_bytes),
                                  "geometry", json_count(f->geometry_bytes), "bvh", json_count(f->bvh_bytes),
                                  "building", json_count(f->build_bytes), "film", json_count(f->film_bytes),
                                  "total", json_count(f->total_bytes)));
    json_t *features = json_array();
    for (size_t i = 0; i < f->feature_count; ++i)
        json_array_append_new(features, json_string(f->features[i]));
    json_object_set_new(root, "features", features);
    json_object_set_new(root, "leftOut", left_out_json(f->left_out.items, (uint32_t)f->left_out.count));
}

/* facts: NULL when the scene cannot be rendered. */
static fathom_status print_json(fathom_context *context, const char *path, const fathom_scene *scene,
                                const info_facts *facts, const warning_list *problems) {
    json_t *root = json_object();
    json_object_set_new(root, "file", json_text(path));
    json_object_set_new(root, "renderable", json_boolean(facts != NULL));
    if (facts) set_facts(root, scene, facts);
    json_object_set_new(root, "problems", warnings_json(problems));
    char *bytes = json_dump_text(root, 0);
    json_decref(root);
    if (!bytes) return fail_memory(context, 4096);
    puts(bytes);
    free(bytes);
    return FATHOM_OK;
}

/* Things that can be rendered but hardly can be meant. */
static void look_for_problems(const fathom_scene *scene, const info_facts *f, warning_list *problems) {
    char text[128];
    if (f->degenerate_triangles) {
        snprintf(text, sizeof text, "triangles without area that are left out: %llu",
                 (unsigned long long)f->degenerate_triangles);
        warnings_keep(problems, text);
    }
    if (f->beyond_reach) {
        snprintf(text, sizeof text,
                 "shapes and triangles beyond %g from the origin, which Embree leaves out: %llu", WORLD_REACH,
                 (unsigned long long)f->beyond_reach);
        warnings_keep(problems, text);
    }
    bool emits = false, ambient = false;
    for (size_t i = 0; i < f->feature_count; ++i) emits |= strcmp(f->features[i], "emission") == 0;
    for (int c = 0; c < 3; ++c) ambient |= scene->ambient[c] > 0;
    if (!scene->lights.count && !emits && !ambient)
        warnings_keep(problems, "no light, no ambient light and nothing that emits: every surface is black");
}

static fathom_status describe(fathom_context *context, const info_settings *settings,
                              warning_list *problems) {
    fathom_scene *scene = NULL;
    info_facts facts = {.spheres = 0};
    const fathom_read_options read = {.camera = settings->camera, .up = settings->up};
    fathom_status status = fathom_scene_read_with(context, settings->scene, &read, &scene);
    if (status == FATHOM_OK) {
        status = info_gather(scene, &facts);
        if (status == FATHOM_BAD_INPUT)
            fail_within(context, status, &(fathom_place){.file = settings->scene});
        if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    }
    /* Lack of memory is no property of the scene. */
    if (status == FATHOM_OUT_OF_RESOURCES) {
        info_release(&facts);
        fathom_scene_destroy(scene);
        return say_status(&command_info, context, status);
    }
    bool renderable = status == FATHOM_OK;
    if (renderable)
        look_for_problems(scene, &facts, problems);
    else
        warnings_keep(problems, fathom_context_message(context));
    if (settings->json) {
        fathom_status printed =
            print_json(context, settings->scene, scene, renderable ? &facts : NULL, problems);
        if (printed != FATHOM_OK) status = say_status(&command_info, context, printed);
    } else {
        say_status(&command_info, context, status);
        if (renderable) print_facts(scene, &facts);
        if (renderable) print_problems(problems);
    }
    info_release(&facts);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status run(int argc, char **argv) {
    info_settings settings = {.scene = NULL};
    fathom_status status;
    if (!command_parse(&command_info, argc, argv, &settings, &status)) return status;
    fathom_context *context;
    status = command_context(settings.threads, &context);
    if (status != FATHOM_OK) return status;
    fathom_context_allow_outside(context, settings.allow_outside);
    interrupt_install();
    warning_list problems = {.count = 0};
    fathom_context_on_warning(context, warnings_keep, &problems);
    status = describe(context, &settings, &problems);
    warnings_free(&problems);
    fathom_context_destroy(context);
    return status;
}

static const args_option options[] = {
    {.help = "Options"},
    COMMAND_CAMERA(info_settings),
    COMMAND_UP(info_settings),
    {"json", 0, NULL, take_true, offsetof(info_settings, json), 0, 0, "as JSON"},
    COMMAND_ALLOW_OUTSIDE(info_settings),
    {"threads", 0, "N", take_u32, offsetof(info_settings, threads), 1, 1024, "1 to 1024 (one a processor)"},
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
