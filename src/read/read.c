#include "read/read.h"

#include "base/file.h"
#include "base/sized.h"
#include "read/mesh/strokes.h"
#include "scene/camera/camera.h"
#include "scene/motion/motion.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Replaces the path after `from` by that of an existing file whose name differs only in case. */
static void take_case(char **path, size_t from) {
    char *found = file_of_any_case(*path, from);
    if (!found) return;
    free(*path);
    *path = found;
}

fathom_status read_beside(fathom_scene *scene, const char *base, const char *name, char **out) {
    *out = file_beside(base, name);
    if (!*out) return fail_memory(scene->context, strlen(base) + strlen(name));
    /* Windows separates folders by backslashes. */
    char *c = *out + strlen(*out) - strlen(name);
    for (; access(*out, F_OK) != 0 && (c = strchr(c, '\\')) != NULL;) *c = '/';
    if (access(*out, F_OK) != 0 && *name != '/') take_case(out, strlen(*out) - strlen(name));
    if (!scene->top) return FATHOM_OK;
    fathom_status status = file_confine(scene->context, scene->top, *out, name);
    if (status == FATHOM_OK) return status;
    free(*out);
    *out = NULL;
    return status;
}

/* Exporters name the folder of images where there is no image. */
static bool is_no_folder(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && !S_ISDIR(info.st_mode);
}

fathom_status read_image_beside(fathom_scene *scene, const char *base, const char *name, char **out) {
    *out = NULL;
    for (const char *part = name; *part;) {
        const fathom_status status = read_beside(scene, base, part, out);
        if (status != FATHOM_OK && status != FATHOM_BAD_INPUT) return status;
        if (status == FATHOM_OK && is_no_folder(*out)) return FATHOM_OK;
        free(*out);
        *out = NULL;
        part += strcspn(part, "/\\");
        part += strspn(part, "/\\");
    }
    return FATHOM_OK;
}

bool read_is_outside(fathom_scene *scene, const char *base, const char *name) {
    const char *top = scene->top;
    char *path = NULL;
    scene->top = NULL; /* as if each folder were allowed */
    const bool found = top && read_beside(scene, base, name, &path) == FATHOM_OK && is_no_folder(path) &&
                       access(path, R_OK) == 0;
    scene->top = top;
    free(path);
    return found;
}

fathom_status read_colored_material(fathom_scene *scene, fathom_id *out) {
    fathom_material material;
    fathom_material_default(&material);
    for (int c = 0; c < 3; ++c) material.k_d[c] = 1;
    return fathom_scene_add_material(scene, "vertex colours", &material, out);
}

/* The file's value is mostly 1, which would make a mirror, a lamp, a coat or a white wall. Instead: grey,
 * rough and not metallic; no emission, no transmission, and no layer that the image would vary. A specular
 * colour tints the reflectance that the ior gives; with ior 0, and in the classic model, it is the
 * reflectance. */
void read_without_image(int kind, fathom_material *m) {
    for (int c = 0; c < 3; ++c) {
        if (kind == FATHOM_MAP_COLOR) m->k_d[c] *= 0.5f, m->base_color[c] *= 0.5f;
        if (kind == FATHOM_MAP_SPECULAR_COLOR) m->k_s[c] = m->k_r[c] = 0;
        if (kind == FATHOM_MAP_SPECULAR_COLOR && m->ior == 0) m->specular_color[c] *= 0.04f;
        if (kind == FATHOM_MAP_EMISSIVE) m->k_e[c] = m->emissive[c] = 0;
        if (kind == FATHOM_MAP_SHEEN_COLOR) m->sheen_color[c] = 0;
    }
    if (kind == FATHOM_MAP_METALLIC) m->metallic = 0;
    if (kind == FATHOM_MAP_ROUGHNESS) m->roughness = 1;
    if (kind == FATHOM_MAP_TRANSMISSION) m->transmission = 0;
    if (kind == FATHOM_MAP_CLEARCOAT) m->clearcoat = 0;
    if (kind == FATHOM_MAP_ANISOTROPY) m->anisotropy = 0;
    if (kind == FATHOM_MAP_IRIDESCENCE) m->iridescence = 0;
    if (kind == FATHOM_MAP_DIFFUSE_TRANSMISSION) m->diffuse_transmission = 0;
}

fathom_status read_missing_uvs(fathom_scene *scene, fathom_mesh *mesh, uint64_t *bytes) {
    const fathom_map *maps = scene->materials.items[mesh->material].value.maps;
    const size_t row = 2 * sizeof(float);
    bool missing[2] = {false, false};
    *bytes = 0;
    if (!scene_keeps_uvs(scene) || mesh->point_radius > 0) return FATHOM_OK;
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (maps[k].texture != FATHOM_NONE) missing[maps[k].uv_set] = true;
    }
    missing[0] &= !mesh->uvs, missing[1] &= !mesh->uvs_1;
    if (!missing[0] && !missing[1]) return FATHOM_OK;
    void *zeros;
    const fathom_status status = scene_allocate_items(scene, mesh->vertex_count, row, &zeros);
    if (status != FATHOM_OK) return status;
    *bytes = (uint64_t)mesh->vertex_count * row;
    memset(zeros, 0, (size_t)*bytes);
    if (missing[0])
        mesh->uvs = zeros, mesh->uv_stride = row, mesh->uv_count = mesh->vertex_count,
        mesh->uv_indices = NULL;
    if (missing[1]) mesh->uvs_1 = zeros, mesh->uv_1_stride = row;
    return FATHOM_OK;
}

fathom_status read_add_mesh(fathom_scene *scene, fathom_id group, const char *path, fathom_mesh *mesh,
                            mesh_facts facts, note_list *notes) {
    uint64_t added = 0;
    fathom_status status = mesh_look_at_triangles(scene->context, path, mesh, &facts);
    if (status == FATHOM_OK) status = read_missing_uvs(scene, mesh, &added);
    if (status != FATHOM_OK) return status;
    notes_add(notes, added > 0, "", READ_MISSING_UVS);
    facts.upwards = true;
    status = strokes_add(scene, group, mesh, &facts, notes);
    return status == FATHOM_OK ? status : fail_within(scene->context, status, &(fathom_place){.file = path});
}

static double rounded_to(double x, double step) { return round(x / step) * step; }

vec3_f64 origin_for(const scene_bounds *bounds) {
    const vec3_f64 zero = {0, 0, 0};
    if (bounds_is_empty(bounds)) return zero;
    vec3_f64 center = bounds_center(bounds), half = scale_f64(0.5, sub_f64(bounds->upper, bounds->lower));
    double extent = fmax(half.x, fmax(half.y, half.z));
    double size = fmax(fabs(center.x), fmax(fabs(center.y), fabs(center.z))) + extent;
    if (!(extent > 0) || !(size > 16 * extent)) return zero;
    /* step = 2^k with e/2 < 2^k <= e; below double's range of exact integers, rounding has no effect. */
    int exponent;
    frexp(extent, &exponent);
    double step = ldexp(1, exponent - 1);
    return (vec3_f64){rounded_to(center.x, step), rounded_to(center.y, step), rounded_to(center.z, step)};
}

/* Samples per pixel of models with the integrator classic; with 1, all edges would be aliased. */
#define MODEL_SPP 16

static const struct format {
    const char *extension;
    fathom_status (*read)(fathom_scene *scene, fathom_id group, const char *path,
                          const read_mesh_options *options);
} mesh_formats[] = {{"obj", read_obj}, {"ply", read_ply}, {"gltf", read_gltf}, {"glb", read_gltf}};

static const struct format *format_find(const char *extension) {
    for (size_t i = 0; i < sizeof mesh_formats / sizeof *mesh_formats; ++i) {
        if (strcmp(mesh_formats[i].extension, extension) == 0) return &mesh_formats[i];
    }
    return NULL;
}

static fathom_status fail_extension(fathom_context *context, const char *path, const char *extension,
                                    const char *known) {
    if (!*extension)
        return fail_file(context, FATHOM_BAD_INPUT, path, "the name has no extension; expected %s", known);
    return fail_file(context, FATHOM_BAD_INPUT, path, "the extension .%s is not known; expected %s",
                     extension, known);
}

fathom_status read_mesh(fathom_scene *scene, fathom_id group, const char *path,
                        const read_mesh_options *options) {
    char extension[16];
    file_extension(path, extension);
    const struct format *format = format_find(extension);
    if (!format) return fail_extension(scene->context, path, extension, ".obj, .ply, .gltf or .glb");
    return format->read(scene, group, path, options);
}

fathom_integrator read_integrator(const fathom_scene *scene, fathom_integrator own) {
    const fathom_read_options *asked = scene->asked;
    return asked && asked->choose_integrator ? asked->integrator : own;
}

/* Reads a model, scaled to metres. */
static fathom_status read_scaled(fathom_scene *scene, const char *path, const read_mesh_options *options) {
    const double unit = scene->asked->unit;
    fathom_instance all;
    if (!(unit > 0) || unit == 1) return read_mesh(scene, FATHOM_ROOT, path, options);
    fathom_instance_default(&all);
    for (int i = 0; i < 3; ++i) all.transform[i * 5] = unit;
    read_mesh_options scaled = *options;
    scaled.unit = unit;
    fathom_status status = fathom_scene_add_group(scene, scene->name, &all.group);
    if (status == FATHOM_OK) status = read_mesh(scene, all.group, path, &scaled);
    return status == FATHOM_OK ? fathom_scene_add_instance(scene, &all, NULL) : status;
}

static fathom_status read_any(fathom_scene *scene, const char *path) {
    char extension[16];
    file_extension(path, extension);
    if (strcmp(extension, "json") == 0) {
        if (scene->asked->unit > 0)
            return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                             "is scene JSON, which scales each model by itself; expected no unit");
        return read_json(scene, path);
    }
    if (!format_find(extension))
        return fail_extension(scene->context, path, extension, ".json, .obj, .ply, .gltf or .glb");
    const read_mesh_options options = {.material = FATHOM_NONE, .surroundings = true};
    const fathom_integrator integrator = read_integrator(scene, FATHOM_INTEGRATOR_PATH);
    fathom_settings_set_integrator(&scene->settings, integrator);
    if (integrator == FATHOM_INTEGRATOR_CLASSIC) scene->settings.spp = MODEL_SPP;
    return read_scaled(scene, path, &options);
}

/* "models/bunny.obj" -> "bunny" */
static fathom_status name_after(fathom_scene *scene, const char *path) {
    const char *file = file_name(path), *dot = strrchr(file, '.');
    char *name = strndup(file, dot && dot != file ? (size_t)(dot - file) : strlen(file));
    if (!name) return fail_memory(scene->context, strlen(file));
    fathom_status status = fathom_scene_set_name(scene, name);
    free(name);
    return status;
}

/* Code without motion, such as writers of models, gets the vertices at the time when the shutter opens. */
static fathom_status pose_vertices(fathom_scene *scene) {
    const double open = scene->camera.shutter[0];
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < scene->meshes.count && status == FATHOM_OK; ++i) {
        fathom_mesh *mesh = &scene->meshes.items[i];
        const size_t points = 3 * (size_t)mesh->vertex_count, normals = 3 * (size_t)mesh->normal_count;
        void *posed = NULL, *turned = NULL;
        if (!mesh->key_count) continue;
        status = scene_allocate_items(scene, points, sizeof(float), &posed);
        if (status == FATHOM_OK && mesh->normals)
            status = scene_allocate_items(scene, normals, sizeof(float), &turned);
        if (status != FATHOM_OK) return status;
        motion_rows(mesh, mesh->key_positions, points, open, posed);
        mesh->positions = posed, mesh->position_stride = 3 * sizeof(float);
        if (!mesh->normals) continue;
        motion_rows(mesh, mesh->key_normals, normals, open, turned);
        mesh->normals = turned, mesh->normal_stride = 3 * sizeof(float);
    }
    return status;
}

double read_shutter(const fathom_scene *scene) {
    const double *shutter = scene->camera.shutter;
    const bool own = scene->asked->choose_shutter || scene->asked->shutter > 0;
    return own ? scene->asked->shutter : shutter[1] - shutter[0];
}

/* The shutter opens at the requested time. Motion without a shutter and without a requested time is probably
 * a mistake, so it gets a warning. A closed shutter in scene JSON is intended. */
static fathom_status open_shutter(fathom_scene *scene, const char *path) {
    const fathom_read_options *asked = scene->asked;
    double *shutter = scene->camera.shutter;
    if (asked->choose_shutter || asked->shutter > 0 || asked->choose_time) {
        const double length = read_shutter(scene);
        shutter[0] = asked->time, shutter[1] = asked->time + length;
        /* Sets the camera again, because a camera with keys takes its position at the time when the shutter
         * opens. */
        const fathom_camera camera = scene->camera;
        return camera.key_count ? fathom_scene_set_camera(scene, &camera) : FATHOM_OK;
    }
    if (!scene->has_shutter && scene_moving(scene))
        warn(scene->context,
             "%s: has motion, but no shutter, so everything stands still at time 0; give the camera a "
             "shutter [OPEN, CLOSE], or --time SECONDS, --shutter SECONDS",
             path);
    return FATHOM_OK;
}

/* Surveys give eastings and northings of more than 100 km, and heights of less than 10 km. */
static fathom_status warn_of_map(const fathom_scene *scene, const char *path) {
    scene_bounds box;
    const fathom_status status = scene_world_bounds(scene, &box);
    const vec3_f64 center = bounds_center(&box);
    const double nearest = fmin(fabs(center.x), fabs(center.y));
    if (status == FATHOM_OK && nearest > 1e5 && fabs(center.z) < 1e4 && bounds_radius(&box) < nearest)
        warn(scene->context, "%s: x and y look like coordinates on a map, where z is up; if so, give --up z",
             path);
    return status;
}

/* Reports options that the file cannot satisfy. */
static fathom_status check_asked(const fathom_scene *scene, const char *path) {
    const fathom_read_options *asked = scene->asked;
    const struct {
        const char *name, *kind;
        bool has;
    } choices[] = {{asked->camera, "cameras", scene->cameras.count},
                   {asked->scene, "scenes", scene->has_scenes},
                   {asked->variant, "variants of materials", scene->has_variants}};
    for (size_t i = 0; i < sizeof choices / sizeof *choices; ++i) {
        if (choices[i].name && !choices[i].has)
            return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                             "has no %s to choose \"%.60s\" from; .gltf and .glb files may have them",
                             choices[i].kind, choices[i].name);
    }
    if (asked->animations && !scene->has_animations) {
        return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                         "has no animations to pose; .gltf and .glb files may have them");
    }
    if ((asked->shutter > 0 || asked->choose_time) && !scene->has_animations && !scene_moving(scene)) {
        return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                         "has nothing that moves, so a %s has no effect; expected animations in a .gltf or "
                         ".glb file, or motion in scene JSON",
                         asked->shutter > 0 ? "shutter" : "time");
    }
    if (asked->up != FATHOM_UP_Y && scene->has_camera && !asked->environment) {
        warn(scene->context, "%s: has its own camera, so --up has no effect", path);
    }
    if ((asked->choose_azimuth || asked->choose_elevation) && scene->has_camera)
        warn(scene->context, "%s: has its own camera, so --azimuth and --elevation have no effect", path);
    if (asked->no_studio && (scene->has_lights || scene->lights.count || scene->environments.count))
        warn(scene->context, "%s: has its own lights, so --no-studio has no effect", path);
    scene_warn_shape(scene, path);
    return asked->up == FATHOM_UP_Y && !scene->has_camera ? warn_of_map(scene, path) : FATHOM_OK;
}

static void drop_environments(fathom_scene *scene) {
    size_t kept = 0;
    for (size_t i = 0; i < scene->grouped_lights.count; ++i) {
        const scene_grouped_light g = scene->grouped_lights.items[i];
        if (g.source != FATHOM_SOURCE_ENVIRONMENT) scene->grouped_lights.items[kept++] = g;
    }
    scene->grouped_lights.count = kept;
    scene->environments.count = 0;
}

static fathom_status set_environment(fathom_scene *scene) {
    const fathom_read_options *asked = scene->asked;
    fathom_light light;
    if (!asked->environment) return FATHOM_OK;
    drop_environments(scene);
    memset(scene->background, 0, sizeof scene->background);
    scene->has_background = false;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT;
    light.file = asked->environment, light.rotation = asked->environment_rotation;
    if (asked->up == FATHOM_UP_Z) light.up[1] = 0, light.up[2] = 1;
    return fathom_scene_add_light(scene, &light, NULL);
}

static fathom_status read_and_complete(fathom_scene *scene, const char *path) {
    fathom_status status = read_any(scene, path);
    if (status == FATHOM_OK) status = check_asked(scene, path);
    if (status == FATHOM_OK) status = open_shutter(scene, path);
    if (status == FATHOM_OK) status = pose_vertices(scene);
    if (status == FATHOM_OK) status = set_environment(scene);
    if (status != FATHOM_OK) return status;
    status = fathom_scene_complete(scene);
    if (status == FATHOM_OK && scene->asked->floor) status = scene_add_floor(scene);
    /* Callers may look for other times of an animation that hides all at this one. */
    if (status == FATHOM_OK && !scene->hides) status = fathom_scene_check(scene);
    return status == FATHOM_OK ? status : fail_within(scene->context, status, &(fathom_place){.file = path});
}

static fathom_status read_whole(fathom_scene *scene, const char *path, const fathom_read_options *options) {
    fathom_status status = name_after(scene, path);
    if (status != FATHOM_OK) return status;
    scene->top = path, scene->asked = options;
    status = read_and_complete(scene, path);
    scene->top = NULL, scene->asked = NULL;
    return status;
}

static fathom_status check_options(fathom_context *context, const fathom_read_options *options) {
    if ((unsigned)options->up > FATHOM_UP_Z)
        return fail_field(context, FATHOM_BAD_USAGE, "up", "there is no axis %u", (unsigned)options->up);
    if (options->choose_integrator && (unsigned)options->integrator > FATHOM_INTEGRATOR_REFERENCE)
        return fail_field(context, FATHOM_BAD_USAGE, "integrator", "expected a fathom_integrator, found %u",
                          (unsigned)options->integrator);
    if (options->choose_time && !isfinite(options->time))
        return fail_field(context, FATHOM_BAD_USAGE, "time", "is %g; expected seconds", options->time);
    if (!(options->shutter >= 0 && options->shutter <= 1e9))
        return fail_field(context, FATHOM_BAD_USAGE, "shutter", "is %g; expected seconds, or 0",
                          options->shutter);
    if (!(options->unit >= 0 && options->unit <= 1e15))
        return fail_field(context, FATHOM_BAD_USAGE, "unit", "is %g; expected metres, or 0", options->unit);
    if (options->choose_azimuth && !isfinite(options->azimuth))
        return fail_field(context, FATHOM_BAD_USAGE, "azimuth", "is %g; expected radians", options->azimuth);
    if (options->choose_elevation && !(fabs(options->elevation) <= 1.5707963267948968))
        return fail_field(context, FATHOM_BAD_USAGE, "elevation", "is %g; expected radians from -π/2 to π/2",
                          options->elevation);
    if (options->framing && options->framing->size < sizeof *options->framing)
        return fail_field(context, FATHOM_BAD_USAGE, "framing",
                          "its size is %zu; expected that of the struct", options->framing->size);
    if (!options->width != !options->height) {
        return fail(context, FATHOM_BAD_USAGE, "width, height: expected both or none, found %u and %u",
                    options->width, options->height);
    }
    return FATHOM_OK;
}

SIZED_DEFAULT_OWN(fathom_read_options, {.up = FATHOM_UP_Y})

fathom_status fathom_scene_read_with(fathom_context *context, const char *path,
                                     const fathom_read_options *options, fathom_scene **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !path) return fail_null(context, "path");
    fathom_scene *scene;
    fathom_read_options asked;
    fathom_status status = SIZED_OWN(context, fathom_read_options, options, &asked);
    if (status == FATHOM_OK) status = check_options(context, &asked);
    if (status == FATHOM_OK) status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    scene->without_uvs = asked.without_uvs;
    status = read_whole(scene, path, &asked);
    /* If a file has changed, all other errors may be a result of it. */
    if (status == FATHOM_OK || status == FATHOM_BAD_INPUT) {
        fathom_status changed = fathom_scene_check_files(scene);
        if (changed != FATHOM_OK) status = changed;
    }
    if (status == FATHOM_OK)
        *out = scene;
    else
        fathom_scene_destroy(scene);
    return status;
}

fathom_status fathom_scene_read(fathom_context *context, const char *path, fathom_scene **out) {
    fathom_read_options options;
    fathom_read_options_default(&options);
    return fathom_scene_read_with(context, path, &options, out);
}

fathom_status fathom_scene_read_to_render(fathom_context *context, const char *path, fathom_scene **out) {
    fathom_read_options options;
    fathom_read_options_default(&options);
    options.without_uvs = true;
    return fathom_scene_read_with(context, path, &options, out);
}
