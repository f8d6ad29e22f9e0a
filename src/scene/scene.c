#include "scene/scene.h"

#include "base/memory.h"
#include "base/sized.h"
#include "scene/motion/motion.h"

#include <stdlib.h>
#include <string.h>

static fathom_status add_default_material(fathom_scene *scene) {
    fathom_material material;
    fathom_material_default(&material);
    return fathom_scene_add_material(scene, NULL, &material, NULL);
}

fathom_status fathom_scene_create(fathom_context *context, fathom_scene **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context) return FATHOM_BAD_USAGE;
    fathom_scene *scene = calloc(1, sizeof *scene);
    if (!scene) return fail_memory(context, sizeof *scene);
    scene->context = context;
    scene->camera_taken = FATHOM_NONE;
    fathom_camera_default(&scene->camera);
    fathom_settings_default(&scene->settings);
    fathom_status status = fathom_scene_set_name(scene, "");
    if (status == FATHOM_OK) status = fathom_scene_add_group(scene, "world", NULL);
    if (status == FATHOM_OK) status = add_default_material(scene);
    if (status != FATHOM_OK) {
        fathom_scene_destroy(scene);
        return status;
    }
    *out = scene;
    return FATHOM_OK;
}

void fathom_scene_destroy(fathom_scene *scene) {
    if (!scene) return;
    for (size_t i = 0; i < scene->blobs.count; ++i) scene->blobs.items[i].release(scene->blobs.items[i].data);
    array_free(&scene->blobs);
    array_free(&scene->materials);
    array_free(&scene->lights);
    array_free(&scene->environments);
    array_free(&scene->textures);
    array_free(&scene->groups);
    array_free(&scene->objects);
    array_free(&scene->spheres);
    array_free(&scene->quads);
    array_free(&scene->planes);
    array_free(&scene->meshes);
    array_free(&scene->mesh_facts);
    array_free(&scene->instances);
    array_free(&scene->origins);
    array_free(&scene->cameras);
    array_free(&scene->grouped_lights);
    free(scene->name);
    free(scene->tracer);
    free(scene);
}

fathom_scene scene_through(const fathom_scene *scene, fathom_context *context) {
    fathom_scene view = *scene;
    view.context = context;
    return view;
}

fathom_status scene_origin_add(fathom_scene *scene, scene_part part, fathom_id id,
                               const fathom_place *place) {
    const size_t file = place->file ? strlen(place->file) + 1 : 0, field = strlen(place->field) + 1;
    scene_origin origin = {part, id, *place};
    void *texts;
    fathom_status status = scene_allocate(scene, file + field, &texts);
    if (status != FATHOM_OK) return status;
    if (file) origin.place.file = memcpy(texts, place->file, file);
    origin.place.field = memcpy((char *)texts + file, place->field, field);
    return array_push(&scene->origins, origin) ? FATHOM_OK : fail_memory(scene->context, sizeof origin);
}

const fathom_place *scene_origin_find(const fathom_scene *scene, scene_part part, fathom_id id) {
    for (size_t i = 0; i < scene->origins.count; ++i) {
        const scene_origin *o = &scene->origins.items[i];
        if (o->part == part && o->id == id) return &o->place;
    }
    return NULL;
}

fathom_status scene_fail_instance(const fathom_scene *scene, fathom_id instance, const char *text) {
    const char *name = scene->groups.items[scene->instances.items[instance].group];
    const fathom_place *place = scene_origin_find(scene, SCENE_PART_MOVED, instance);
    if (place) return fail_at(scene->context, FATHOM_BAD_INPUT, place, "%s", text);
    if (!name) return fail(scene->context, FATHOM_BAD_INPUT, "instance %u: %s", instance, text);
    return fail(scene->context, FATHOM_BAD_INPUT, "instance %u, of \"%.60s\": %s", instance, name, text);
}

fathom_status scene_adopt(fathom_scene *scene, void *data, void (*release)(void *data)) {
    return scene_adopt_file(scene, data, release, &(file_map){.bytes = NULL});
}

fathom_status scene_adopt_file(fathom_scene *scene, void *data, void (*release)(void *data),
                               const file_map *map) {
    scene_blob blob = {data, release, *map};
    if (array_push(&scene->blobs, blob)) return FATHOM_OK;
    release(data);
    return fail_memory(scene->context, sizeof blob);
}

fathom_status scene_allocate(fathom_scene *scene, size_t bytes, void **out) {
    *out = NULL;
    /* Embree loads 16 bytes at a time and may read past the last vertex by that much. */
    size_t room;
    if (__builtin_add_overflow(bytes, 16, &room) || !memory_has(room))
        return fail_memory(scene->context, bytes);
    char *data = malloc(room);
    if (!data) return fail_memory(scene->context, room);
    memset(data + bytes, 0, 16);
    fathom_status status = scene_adopt(scene, data, free);
    if (status == FATHOM_OK) *out = data;
    return status;
}

fathom_status scene_allocate_items(fathom_scene *scene, size_t count, size_t bytes, void **out) {
    size_t all;
    *out = NULL;
    if (__builtin_mul_overflow(count, bytes, &all)) return fail_memory(scene->context, SIZE_MAX);
    return scene_allocate(scene, all, out);
}

fathom_status scene_own_text(fathom_scene *scene, const char **text) {
    if (!*text) return FATHOM_OK;
    const size_t length = strlen(*text);
    char *copy = strdup(*text);
    *text = copy;
    return copy ? scene_adopt(scene, copy, free) : fail_memory(scene->context, length);
}

static fathom_status check_color(fathom_context *context, const char *what, const float rgb[3]) {
    for (int i = 0; i < 3; ++i) {
        if (!isfinite(rgb[i]) || rgb[i] < 0) {
            return fail_field(context, FATHOM_BAD_INPUT, what, "expected finite numbers >= 0, found %g",
                              (double)rgb[i]);
        }
    }
    return FATHOM_OK;
}

static fathom_status check_textures(const fathom_scene *scene, const fathom_material *material) {
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        const fathom_id texture = material->maps[k].texture;
        if (texture != FATHOM_NONE && texture >= scene->textures.count)
            return fail(scene->context, FATHOM_BAD_INPUT, "maps[%d]: there is no texture %u", k, texture);
    }
    const fathom_id bump = material->maps[FATHOM_MAP_BUMP].texture;
    if (bump != FATHOM_NONE && scene->textures.items[bump].filter == FATHOM_TEXTURE_STOCHASTIC)
        return fail(scene->context, FATHOM_BAD_INPUT,
                    "the bump map's filter: expected nearest, linear or trilinear, found stochastic: texels "
                    "chosen by chance have no slope");
    return FATHOM_OK;
}

/* Takes images of numbers and directions as linear, unless their color space is given, as scene JSON does.
 * Alpha is linear anyway. */
static fathom_status take_numbers(fathom_scene *scene, fathom_material *material) {
    fathom_status status = FATHOM_OK;
    for (int k = 0; k < FATHOM_MAPS && status == FATHOM_OK; ++k) {
        fathom_map *map = &material->maps[k];
        if (map->texture == FATHOM_NONE || material_map_is_color(k) || map->channel == 3) continue;
        fathom_texture texture = scene->textures.items[map->texture];
        if (texture.color_space != FATHOM_COLOR_AUTO) continue;
        texture.color_space = FATHOM_COLOR_LINEAR;
        status = fathom_scene_add_texture(scene, &texture, &map->texture);
    }
    return status;
}

fathom_status fathom_scene_add_material_sized(fathom_scene *scene, const char *name,
                                              const fathom_material *material, size_t size, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    scene_named_material entry = {.name = name};
    fathom_status status = SIZED_ITEM(scene->context, fathom_material, material, size, &entry.value);
    if (status == FATHOM_OK) status = scene_check_material(scene->context, &entry.value);
    if (status == FATHOM_OK) status = check_textures(scene, &entry.value);
    if (status == FATHOM_OK) status = take_numbers(scene, &entry.value);
    if (status == FATHOM_OK) status = scene_own_text(scene, &entry.name);
    if (status != FATHOM_OK) return status;
    /* Path tracing alone would read them. */
    if (entry.value.model == FATHOM_MODEL_CLASSIC) entry.value.opacity = 1, entry.value.opacity_cutoff = 0;
    entry.classic = entry.value;
    if (entry.value.model == FATHOM_MODEL_METALLIC_ROUGHNESS)
        metallic_to_classic(&entry.value, &entry.classic);
    if (!array_push(&scene->materials, entry)) return fail_memory(scene->context, sizeof entry);
    scene->has_maps |= material_has_maps(&entry.value);
    scene->uses_uvs |= scene->has_maps || material_is_directed(&entry.value);
    if (out) *out = (fathom_id)(scene->materials.count - 1);
    return FATHOM_OK;
}

uint64_t scene_triangles(const fathom_scene *scene) {
    uint64_t triangles = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) triangles += scene->meshes.items[i].triangle_count;
    return triangles;
}

uint64_t scene_points(const fathom_scene *scene) {
    uint64_t points = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        points += mesh->point_radius > 0 ? mesh->vertex_count : 0;
    }
    return points;
}

uint64_t scene_primitives(const fathom_scene *scene) {
    return scene_triangles(scene) + scene_points(scene) + scene->spheres.count + scene->quads.count +
           scene->planes.count;
}

size_t scene_moving(const fathom_scene *scene) {
    size_t count = scene->camera.key_count > 1;
    for (size_t i = 0; i < scene->instances.count; ++i) count += scene->instances.items[i].key_count > 1;
    for (size_t i = 0; i < scene->meshes.count; ++i) count += scene->meshes.items[i].key_count > 1;
    return count;
}

bool scene_has_opacities(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        if (mesh->colors && mesh->color_channels == 4) return true;
    }
    return false;
}

fathom_id scene_object_material(const fathom_scene *scene, fathom_id id) {
    scene_object object = scene->objects.items[id];
    switch (object.kind) {
    case SCENE_SPHERE: return scene->spheres.items[object.index].material;
    case SCENE_QUAD: return scene->quads.items[object.index].material;
    case SCENE_PLANE: return scene->planes.items[object.index].material;
    case SCENE_MESH: return scene->meshes.items[object.index].material;
    }
    return FATHOM_NONE;
}

SIZED_DEFAULT(fathom_light, {.type = FATHOM_LIGHT_POINT,
                             .direction = {0, -1, 0},
                             .intensity = {1, 1, 1},
                             .outer_angle = 0.785398163f,
                             .up = {0, 1, 0}})

static fathom_status check_light(fathom_context *context, const fathom_light *light) {
    const vec3_f64 direction = load_f64(light->direction);
    if (light->type != FATHOM_LIGHT_DIRECTIONAL && !finite_f64(load_f64(light->position)))
        return fail_field(context, FATHOM_BAD_INPUT, "position", "expected three finite numbers");
    if (light->type != FATHOM_LIGHT_POINT && (!finite_f64(direction) || length_f64(direction) == 0))
        return fail_field(context, FATHOM_BAD_INPUT, "direction",
                          "expected a finite vector that is not zero");
    if (!isfinite(light->radius) || light->radius < 0)
        return fail_field(context, FATHOM_BAD_INPUT, "radius", "expected a finite number >= 0, found %g",
                          (double)light->radius);
    if (!(light->angular_radius >= 0 && light->angular_radius < 1.57079637f))
        return fail(context, FATHOM_BAD_INPUT,
                    "angular radius: expected at least 0 and less than 90 degrees, found %g degrees",
                    (double)light->angular_radius * 57.29577951308232);
    if (light->type == FATHOM_LIGHT_SPOT &&
        !(light->inner_angle >= 0 && light->inner_angle < light->outer_angle &&
          light->outer_angle <= 1.57079637f)) {
        return fail(
            context, FATHOM_BAD_INPUT,
            "spot angles: expected 0 <= inner < outer <= 90 degrees, found inner %g and outer %g degrees",
            (double)light->inner_angle * 57.29577951308232, (double)light->outer_angle * 57.29577951308232);
    }
    return FATHOM_OK;
}

/* A light that is added replaces what fathom_scene_complete() made. */
static void drop_made_lights(fathom_scene *scene) {
    if (scene->made.lights) scene->lights.count = 0;
    if (scene->made.background) memset(scene->background, 0, sizeof scene->background);
    if (scene->made.ambient) memset(scene->ambient, 0, sizeof scene->ambient);
    scene->has_background &= !scene->made.background, scene->has_ambient &= !scene->made.ambient;
    scene->made.lights = scene->made.background = scene->made.ambient = scene->in_studio = false;
}

static fathom_status add_environment(fathom_scene *scene, const fathom_light *light, fathom_id *out) {
    fathom_context *context = scene->context;
    fathom_light entry = *light;
    if (!light->file || !*light->file)
        return fail_field(context, FATHOM_BAD_INPUT, "file", "expected the path of an image");
    if (!isfinite(light->rotation))
        return fail_field(context, FATHOM_BAD_INPUT, "rotation", "expected a finite number");
    if (!finite_f64(load_f64(light->up)) || length_f64(load_f64(light->up)) == 0)
        return fail_field(context, FATHOM_BAD_INPUT, "up", "expected a finite vector that is not zero");
    fathom_status status = scene_own_text(scene, &entry.file);
    if (status == FATHOM_OK) status = scene_own_text(scene, &entry.name);
    if (status != FATHOM_OK) return status;
    drop_made_lights(scene);
    if (!array_push(&scene->environments, entry)) return fail_memory(context, sizeof entry);
    if (out) *out = (fathom_id)(scene->environments.count - 1);
    return FATHOM_OK;
}

fathom_status fathom_scene_add_light_sized(fathom_scene *scene, const fathom_light *light, size_t size,
                                           fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_context *context = scene->context;
    fathom_light item;
    fathom_status status = SIZED_ITEM(context, fathom_light, light, size, &item);
    if (status != FATHOM_OK) return status;
    if ((unsigned)item.type > FATHOM_LIGHT_ENVIRONMENT)
        return fail(context, FATHOM_BAD_USAGE, "light: there is no type %u", (unsigned)item.type);
    status = check_color(context, "intensity", item.intensity);
    if (status != FATHOM_OK) return status;
    if (item.type == FATHOM_LIGHT_ENVIRONMENT) return add_environment(scene, &item, out);
    status = check_light(context, &item);
    if (status == FATHOM_OK) status = scene_own_text(scene, &item.name);
    if (status != FATHOM_OK) return status;
    drop_made_lights(scene);
    if (!array_push(&scene->lights, item)) return fail_memory(context, sizeof item);
    if (out) *out = (fathom_id)(scene->lights.count - 1);
    return FATHOM_OK;
}

fathom_status fathom_scene_add_group(fathom_scene *scene, const char *name, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_status status = scene_own_text(scene, &name);
    if (status != FATHOM_OK) return status;
    if (!array_push(&scene->groups, name)) return fail_memory(scene->context, sizeof name);
    if (out) *out = (fathom_id)(scene->groups.count - 1);
    return FATHOM_OK;
}

SIZED_DEFAULT(fathom_instance, {.group = FATHOM_NONE,
                                .parent = FATHOM_ROOT,
                                .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                .material = FATHOM_NONE})

static fathom_status check_instance(const fathom_scene *scene, const fathom_instance *instance) {
    fathom_context *context = scene->context;
    if (instance->group >= scene->groups.count || instance->group == FATHOM_ROOT) {
        return fail(context, FATHOM_BAD_INPUT, "instance: expected a group other than the world, found id %u",
                    instance->group);
    }
    if (instance->parent >= scene->groups.count) {
        return fail(context, FATHOM_BAD_INPUT, "instance: there is no group %u to place it in",
                    instance->parent);
    }
    if (instance->material != FATHOM_NONE && instance->material >= scene->materials.count) {
        return fail(context, FATHOM_BAD_INPUT, "instance: there is no material %u", instance->material);
    }
    affine_f64 map, inverse;
    affine_load(&map, instance->transform);
    if (!instance->key_count && !affine_invert(&map, &inverse)) {
        return fail_field(context, FATHOM_BAD_INPUT, "transform",
                          "it flattens space or is not finite; expected one that can be inverted");
    }
    return FATHOM_OK;
}

/* If one key mirrors and the next does not, the interpolated transform flattens space at some time in
 * between, so this is an error. */
static fathom_status check_motion(fathom_context *context, const fathom_instance *instance) {
    fathom_status status = motion_check_keys(context, instance->key_times, instance->key_count);
    if (status == FATHOM_OK && !instance->key_transforms) status = fail_null(context, "key_transforms");
    bool mirrored = false;
    for (uint32_t k = 0; k < instance->key_count && status == FATHOM_OK; ++k) {
        affine_f64 map, inverse;
        affine_load(&map, instance->key_transforms + 12 * (size_t)k);
        if (!affine_invert(&map, &inverse))
            return fail_item(context, FATHOM_BAD_INPUT, "key_transforms", k,
                             "it flattens space or is not finite; expected one that can be inverted");
        const bool mirrors = motion_take_apart(&map).scale[2] < 0;
        if (k && mirrors != mirrored)
            return fail_item(context, FATHOM_BAD_INPUT, "key_transforms", k,
                             "it mirrors and the key before does not, or the reverse: between them the "
                             "group would be flat");
        mirrored = mirrors;
    }
    return status;
}

fathom_status fathom_scene_add_instance_sized(fathom_scene *scene, const fathom_instance *instance,
                                              size_t size, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_instance item;
    fathom_status status = SIZED_ITEM(scene->context, fathom_instance, instance, size, &item);
    if (status == FATHOM_OK) status = check_instance(scene, &item);
    if (status == FATHOM_OK && item.key_count) status = check_motion(scene->context, &item);
    if (status == FATHOM_OK && item.key_count)
        status = motion_copy_keys(scene, item.key_count, 12, &item.key_times, &item.key_transforms);
    if (status == FATHOM_OK) status = scene_own_text(scene, &item.name);
    if (status != FATHOM_OK) return status;
    if (item.key_count) memcpy(item.transform, item.key_transforms, sizeof item.transform);
    if (!array_push(&scene->instances, item)) return fail_memory(scene->context, sizeof item);
    if (out) *out = (fathom_id)(scene->instances.count - 1);
    return FATHOM_OK;
}

static fathom_status set_color(fathom_scene *scene, const char *what, const float rgb[3], float out[3],
                               bool *given, bool *made) {
    if (!rgb) return fail_null(scene->context, what);
    fathom_status status = check_color(scene->context, what, rgb);
    if (status != FATHOM_OK) return status;
    memcpy(out, rgb, 3 * sizeof *out);
    *given = true;
    *made = scene->in_studio = false;
    return FATHOM_OK;
}

fathom_status fathom_scene_set_background(fathom_scene *scene, const float rgb[3]) {
    if (!scene) return FATHOM_BAD_USAGE;
    return set_color(scene, "background", rgb, scene->background, &scene->has_background,
                     &scene->made.background);
}

fathom_status fathom_scene_set_ambient(fathom_scene *scene, const float rgb[3]) {
    if (!scene) return FATHOM_BAD_USAGE;
    return set_color(scene, "ambient", rgb, scene->ambient, &scene->has_ambient, &scene->made.ambient);
}

fathom_status fathom_scene_set_name(fathom_scene *scene, const char *name) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!name) return fail_null(scene->context, "name");
    char *copy = strdup(name);
    if (!copy) return fail_memory(scene->context, strlen(name));
    free(scene->name);
    scene->name = copy;
    return FATHOM_OK;
}
