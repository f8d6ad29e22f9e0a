/* Scene JSON. The format itself is in json_form.c. */
#include "base/file.h"
#include "read/json/json_scene.h"
#include "read/mesh/text.h"
#include "read/read.h"
#include "scene/camera/camera.h"
#include "scene/graph.h"
#include "json/memory.h"

#include <stdlib.h>
#include <string.h>

/* ---- camera and image ---- */

/* Without a focus distance in the file, the focus is at the target. */
static fathom_status set_lens(const object_reader *r, const where *at, json_t *value,
                              const form_camera_values *c, fathom_camera *camera) {
    camera->lens_radius = c->f_stop > 0 ? c->focal_length / (2 * c->f_stop) : c->lens_radius;
    if (!(camera->lens_radius > 0)) return FATHOM_OK;
    const where focal = {at, "focalLength", 0}, radius = {at, "lensRadius", 0};
    const bool given = doc_has(value, "focusDistance");
    if (!given && !doc_has(value, "target"))
        return doc_fail(r->doc, at, "a lens needs \"focusDistance\"%s",
                        c->motion ? " where \"motion\" places the camera" : ", or \"eye\" and \"target\"");
    camera->focus_distance =
        given ? c->focus_distance : length_f64(sub_f64(load_f64(c->target), load_f64(c->eye)));
    if (c->f_stop > 0 && c->focal_length >= camera->focus_distance)
        doc_warn(r->doc, &focal,
                 "expected units of the scene; %g seems to be in another unit, because no lens of this focal "
                 "length focuses as near as %g",
                 c->focal_length, camera->focus_distance);
    if (c->lens_radius >= camera->focus_distance)
        doc_warn(
            r->doc, &radius,
            "expected units of the scene; %g seems to be in another unit, because the focus is only %g away",
            c->lens_radius, camera->focus_distance);
    return FATHOM_OK;
}

/* Positions the camera, or one of its keys, by eye and target or by a frame. A camera with keys is positioned
 * by these later. */
static fathom_status place_camera(const object_reader *r, const where *at, json_t *value,
                                  const form_camera_values *c, double fovy, fathom_camera *camera) {
    const where target = {at, "target", 0}, framed = {at, "frame", 0};
    if (doc_has(value, "eye")) {
        vec3_f64 view = sub_f64(load_f64(c->target), load_f64(c->eye));
        if (!(length_f64(view) > 0)) return doc_fail(r->doc, &target, "it is where the eye is");
        fathom_camera_look_at(c->eye, c->target, c->up, fovy, camera);
        return FATHOM_OK;
    }
    frame_f64 frame = frame_from((vec3_f64){0, 0, 0}, (vec3_f64){0, 0, 1}, (vec3_f64){0, 1, 0});
    fathom_status status = FATHOM_OK;
    if (!c->motion) status = place_frame(r->doc, &framed, json_object_get(value, "frame"), &c->frame, &frame);
    if (status != FATHOM_OK) return status;
    *camera = (fathom_camera){.d = 1, .h = 2 * tan(fovy / 2)};
    store_f64(camera->origin, frame.origin);
    store_f64(camera->x, frame.x);
    store_f64(camera->y, frame.y);
    store_f64(camera->z, frame.z);
    return FATHOM_OK;
}

static fathom_status read_camera_key(const object_reader *r, const where *at, json_t *value, double *time,
                                     affine_f64 *map) {
    form_camera_values c = {.up = {0, 1, 0}};
    fathom_camera there;
    fathom_status status = doc_read(r->doc, at, value, &form_camera_key, &c);
    if (status == FATHOM_OK) status = place_camera(r, at, value, &c, 1, &there);
    if (status != FATHOM_OK) return status;
    *time = c.time;
    for (int i = 0; i < 3; ++i) {
        const double row[4] = {there.x[i], there.y[i], there.z[i], there.origin[i]};
        memcpy(map->m[i], row, sizeof row);
    }
    return FATHOM_OK;
}

static fathom_status set_camera(const object_reader *r, json_t *value, const form_camera_values *c) {
    const where at = {NULL, "camera", 0};
    double *keys = NULL;
    fathom_camera camera;
    fathom_status status = place_camera(r, &at, value, c, place_radians(c->fovy), &camera);
    if (status != FATHOM_OK) return status;
    doc_warn_useless(r->doc, &at, value, &form_camera, NULL);
    r->scene->has_shutter = doc_has(value, "shutter");
    camera.shutter[0] = c->shutter[0], camera.shutter[1] = c->shutter[1];
    camera.near_clip = c->near_clip, camera.far_clip = c->far_clip;
    camera.blades = c->blades, camera.blade_rotation = place_radians(c->blade_rotation);
    if (doc_has(value, "h")) camera.d = c->d, camera.h = c->h;
    if (doc_has(value, "w")) camera.w = c->w;
    camera.orthographic = doc_has(value, "orthographic");
    if (camera.orthographic) camera.h = c->orthographic;
    status = set_lens(r, &at, value, c, &camera);
    if (status == FATHOM_OK && c->motion) {
        status = place_motion(r, &at, c->motion, read_camera_key, &camera.key_count, &keys);
        camera.key_times = keys, camera.key_frames = keys ? keys + camera.key_count : NULL;
    }
    if (status == FATHOM_OK) {
        status = fathom_scene_set_camera(r->scene, &camera);
        if (status != FATHOM_OK) status = place_within(r, &at, "motion", status);
    }
    free(keys);
    return status;
}

static fathom_integrator own_integrator(json_t *image) {
    const char *word = json_string_value(json_object_get(image, "integrator"));
    if (word && strcmp(word, "classic") == 0) return FATHOM_INTEGRATOR_CLASSIC;
    if (word && strcmp(word, "reference") == 0) return FATHOM_INTEGRATOR_REFERENCE;
    return FATHOM_INTEGRATOR_PATH;
}

/* The integrator sets the defaults of the other settings. With a number of samples, or a pattern other than
 * "sobol", all pixels get the same number of samples. */
static fathom_integrator choose_integrator(const fathom_scene *scene, json_t *root, fathom_settings *image) {
    json_t *from = json_object_get(root, "image");
    const char *pattern = json_string_value(json_object_get(from, "pattern"));
    fathom_settings_set_integrator(image, read_integrator(scene, own_integrator(from)));
    if (doc_has(from, "spp") || (pattern && strcmp(pattern, "sobol") != 0)) image->target_error = 0;
    return image->integrator;
}

/* Adapts settings that the file meant for another integrator than the requested one. A valid scene stays
 * valid: only settings that the file does not give change. */
static void suit_integrator(const object_reader *r, json_t *image, fathom_settings *s) {
    const where at = {NULL, "image", 0}, aovs = {&at, "aovs", 0};
    const bool replaced = r->scene->asked && r->scene->asked->own_spp;
    if (s->integrator != FATHOM_INTEGRATOR_CLASSIC || own_integrator(image) == s->integrator) return;
    if (replaced) s->spp = 1, s->target_error = 0;
    if (s->target_error > 0 && !doc_has(image, "spp")) s->spp = 1024;
    if (!doc_has(image, "pattern") && (s->target_error > 0 || !settings_spp_is_square(s->spp)))
        s->pattern = FATHOM_PATTERN_SOBOL;
    if (!(s->aovs & FATHOM_AOV_ERROR) || s->target_error > 0) return;
    s->aovs &= ~(unsigned)FATHOM_AOV_ERROR;
    doc_warn(
        r->doc, &aovs,
        "\"error\" is left out: the integrator classic estimates errors only with a target error; give one");
}

/* The camera's aspect ratio sets the image's size, as far as the file does not give it. */
static fathom_status set_image(const object_reader *r, json_t *root, form_scene_values *v) {
    const where at = {NULL, "image", 0};
    json_t *image = json_object_get(root, "image");
    if (doc_has(json_object_get(root, "camera"), "w")) {
        image_size_follow(&v->image, v->camera.w / v->camera.h, doc_has(image, "width"),
                          doc_has(image, "height"));
    }
    fathom_status status = fathom_scene_set_settings(r->scene, &v->image);
    return status == FATHOM_OK ? status : doc_within(r->doc, &at, status);
}

/* ---- lights ---- */

fathom_status light_group_set(const object_reader *r, const where *at, const char *key,
                              fathom_light_source source, size_t first, size_t end, const char *name) {
    const where named = {at, key, 0};
    for (size_t id = first; name && id < end; ++id) {
        fathom_status status = fathom_scene_set_light_group(r->scene, source, (fathom_id)id, name);
        if (status != FATHOM_OK) return doc_within(r->doc, &named, status);
    }
    return FATHOM_OK;
}

static fathom_light_type light_type(form_light_id id) {
    switch (id) {
    case FORM_POINT: return FATHOM_LIGHT_POINT;
    case FORM_SPOT: return FATHOM_LIGHT_SPOT;
    case FORM_DIRECTIONAL:
    case FORM_SUN: return FATHOM_LIGHT_DIRECTIONAL;
    case FORM_ENVIRONMENT: return FATHOM_LIGHT_ENVIRONMENT;
    }
    return FATHOM_LIGHT_POINT;
}

/* A light's strength is the radiance of a white diffuser, which is the irradiance divided by pi. */
static double strength_of(json_t *value, const form_light_values *v) {
    if (doc_has(value, "radiantIntensity")) return (double)v->radiant_intensity / 3.14159265358979323846;
    if (doc_has(value, "irradiance")) return (double)v->irradiance / 3.14159265358979323846;
    return (double)v->intensity;
}

static void set_light(json_t *value, const form_light_values *v, fathom_light *light) {
    const double strength = strength_of(value, v);
    for (int i = 0; i < 3; ++i) {
        light->position[i] = v->position[i];
        light->direction[i] = doc_has(value, "target") ? v->target[i] - v->position[i] : v->direction[i];
        light->intensity[i] = (float)((double)v->color[i] * strength);
    }
    light->inner_angle = (float)place_radians(v->inner_angle);
    light->outer_angle = (float)place_radians(v->outer_angle);
    light->radius = v->radius;
    light->rotation = place_radians(v->rotation);
    memcpy(light->up, v->up, sizeof light->up);
}

/* Six files may be links that lead out of the folder. */
static fathom_status check_faces(const object_reader *r, const char *path, const char *name) {
    fathom_context *context = r->scene->context;
    file_faces files;
    fathom_status status = file_faces_open(context, path, &files);
    for (unsigned i = 0; status == FATHOM_OK && i < files.count; ++i) {
        file_map map;
        if (r->scene->top && files.count > 1)
            status = file_confine(context, r->scene->top, files.paths[i], name);
        if (status == FATHOM_OK) status = file_open(context, files.paths[i], &map);
        if (status == FATHOM_OK) file_close(&map);
    }
    file_faces_close(&files);
    return status;
}

/* The image's path is relative to the scene file. An environment that the caller requested replaces it. */
static fathom_status add_environment(const object_reader *r, const where *at, const char *name,
                                     fathom_light *light) {
    const where file = {at, "file", 0};
    const bool replaced = r->scene->asked && r->scene->asked->environment;
    fathom_id id;
    char *path;
    if (!*name) return doc_fail(r->doc, &file, "expected the name of a file, found \"\"");
    fathom_status status = read_beside(r->scene, r->doc->path, name, &path);
    if (status != FATHOM_OK) return doc_within(r->doc, &file, status);
    if (!replaced) status = check_faces(r, path, name);
    if (status != FATHOM_OK) {
        free(path);
        return doc_within(r->doc, &file, status);
    }
    light->file = path;
    status = fathom_scene_add_light(r->scene, light, &id);
    free(path);
    if (status != FATHOM_OK) return doc_within(r->doc, at, status);
    return replaced ? FATHOM_OK : place_origin(r, &file, SCENE_PART_ENVIRONMENT, id);
}

static fathom_status group_light(const object_reader *r, const where *at, const form_light_values *v,
                                 form_light_id id) {
    const bool sky = id == FORM_ENVIRONMENT;
    const size_t count = sky ? r->scene->environments.count : r->scene->lights.count;
    return light_group_set(r, at, "group", sky ? FATHOM_SOURCE_ENVIRONMENT : FATHOM_SOURCE_LIGHT, count - 1,
                           count, v->group);
}

static fathom_status add_light(const object_reader *r, const where *at, json_t *value) {
    const where target = {at, "target", 0};
    const form *f;
    fathom_status status = doc_choose(r->doc, at, value, &form_light, &f);
    if (status != FATHOM_OK) return status;
    form_light_values v = {
        .color = {1, 1, 1}, .intensity = 1, .outer_angle = 45, .angular_diameter = 0.53, .up = {0, 1, 0}};
    status = doc_read(r->doc, at, value, f, &v);
    if (status != FATHOM_OK) return status;
    fathom_light light;
    fathom_light_default(&light);
    light.type = light_type((form_light_id)f->id);
    light.name = v.name;
    set_light(value, &v, &light);
    if (doc_has(value, "target") && !(length_f64(load_f64(light.direction)) > 0))
        return doc_fail(r->doc, &target, "it is the light's position; expected another point to shine at");
    if (f->id == FORM_SUN) light.angular_radius = (float)place_radians(v.angular_diameter / 2);
    if (f->id == FORM_ENVIRONMENT) {
        status = add_environment(r, at, v.file, &light);
    } else {
        status = fathom_scene_add_light(r->scene, &light, NULL);
        if (status != FATHOM_OK) status = doc_within(r->doc, at, status);
    }
    return status == FATHOM_OK ? group_light(r, at, &v, (form_light_id)f->id) : status;
}

static fathom_status add_lights(const object_reader *r, json_t *lights) {
    const where at = {NULL, "lights", 0};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < json_array_size(lights) && status == FATHOM_OK; ++i) {
        const where item = {&at, NULL, i};
        status = add_light(r, &item, json_array_get(lights, i));
    }
    return status;
}

/* ---- groups and objects ---- */

/* Adds all names first, because groups may use each other in any order. */
static fathom_status name_groups(const object_reader *r, json_t *groups) {
    const char *name;
    json_t *list;
    json_object_foreach(groups, name, list) {
        fathom_id id;
        fathom_status status = fathom_scene_add_group(r->scene, name, &id);
        if (status != FATHOM_OK) return status;
        if (json_object_set_new(r->groups, name, json_integer(id)) != 0)
            return fail_memory(r->scene->context, strlen(name));
    }
    return FATHOM_OK;
}

static fathom_status fill_groups(const object_reader *r, json_t *groups) {
    const where at = {NULL, "groups", 0};
    fathom_status status = name_groups(r, groups);
    const char *name;
    json_t *list;
    json_object_foreach(groups, name, list) {
        const where item = {&at, name, 0};
        fathom_id id = (fathom_id)json_integer_value(json_object_get(r->groups, name));
        if (status == FATHOM_OK) status = object_list(r, &item, list, id);
    }
    return status;
}

static fathom_status check_cycles(const object_reader *r) {
    const where at = {NULL, "groups", 0};
    fathom_status status = scene_check_cycles(r->scene);
    return status == FATHOM_BAD_INPUT ? doc_within(r->doc, &at, status) : status;
}

/* Limits nested instances: each level multiplies the number of instances, so a few bytes of JSON could create
 * any number. Each takes about 0.5 kB in a render. */
static fathom_status check_placements(const object_reader *r) {
    const double most = 0x1p20 + (double)strlen(r->doc->text) / 4;
    const size_t groups = r->scene->groups.count;
    const where at = {NULL, "groups", 0};
    scene_graph graph;
    fathom_status status = graph_create(r->scene, &graph);
    if (status != FATHOM_OK) return status;
    double *placements = calloc(groups, sizeof *placements);
    const double total = placements ? graph_count_placements(r->scene, &graph, placements) : 0;
    if (!placements)
        status = fail_memory(r->scene->context, groups * sizeof *placements);
    else if (total > most)
        status = doc_fail(
            r->doc, &at,
            "nested instances place %.3g groups; expected at most %.0f: 2^20, and one for each 4 bytes "
            "of the file",
            total, most);
    free(placements);
    graph_destroy(&graph);
    return status;
}

static fathom_status add_objects(const object_reader *r, const form_scene_values *v) {
    const where at = {NULL, "objects", 0};
    fathom_status status = fill_groups(r, v->groups);
    if (status == FATHOM_OK) status = object_list(r, &at, v->objects, FATHOM_ROOT);
    if (status == FATHOM_OK) status = check_cycles(r);
    if (status == FATHOM_OK) status = check_placements(r);
    return status == FATHOM_OK ? objects_cast(r) : status;
}

/* ---- the document ---- */

static fathom_status build(const object_reader *r, json_t *root, form_scene_values *v) {
    fathom_scene *scene = r->scene;
    fathom_status status = v->name ? fathom_scene_set_name(scene, v->name) : FATHOM_OK;
    if (status == FATHOM_OK) status = set_image(r, root, v);
    if (status == FATHOM_OK && doc_has(root, "background"))
        status = fathom_scene_set_background(scene, v->background);
    if (status == FATHOM_OK)
        status =
            light_group_set(r, NULL, "backgroundGroup", FATHOM_SOURCE_BACKGROUND, 0, 1, v->background_group);
    if (status == FATHOM_OK && doc_has(root, "ambient")) status = fathom_scene_set_ambient(scene, v->ambient);
    if (status == FATHOM_OK) status = materials_add(r, v->materials);
    if (status == FATHOM_OK) status = add_lights(r, v->lights);
    /* Before animated models, which its shutter blurs. */
    if (status == FATHOM_OK && doc_has(root, "camera"))
        status = set_camera(r, json_object_get(root, "camera"), &v->camera);
    if (status == FATHOM_OK) status = add_objects(r, v);
    if (status == FATHOM_OK) status = materials_warn(r, v->materials);
    if (doc_has(root, "lights")) scene->has_lights = true;
    /* So that frames of an animation in which everything is hidden can be converted. */
    if (json_array_size(v->objects) == 0 && scene->has_camera) scene->hides = true;
    return status;
}

static fathom_status read_root(const doc *d, json_t *root, fathom_scene *scene) {
    form_prepare();
    form_scene_values values = {.camera = {.up = {0, 1, 0}, .fovy = 45}};
    fathom_settings_default(&values.image);
    const fathom_integrator integrator = choose_integrator(scene, root, &values.image);
    fathom_status status = doc_read(d, NULL, root, &form_scene, &values);
    if (status != FATHOM_OK) return status;
    values.image.integrator = integrator;
    const object_reader reader = {d, scene, json_object(), json_object()};
    suit_integrator(&reader, json_object_get(root, "image"), &values.image);
    if (reader.materials && reader.groups)
        status = build(&reader, root, &values);
    else
        status = fail_memory(d->context, sizeof values);
    json_decref(reader.materials);
    json_decref(reader.groups);
    return status;
}

fathom_status read_json(fathom_scene *scene, const char *path) {
    file_map map;
    fathom_status status = file_open(scene->context, path, &map);
    if (status != FATHOM_OK) return status;
    const char *end = (const char *)map.bytes + map.size,
               *text = text_after_mark((const char *)map.bytes, end);
    size_t size = (size_t)(end - text);
    size_t told = 0;
    const doc d = {scene->context, path, text, &told};
    json_error_t error;
    /* Numbers are read as double: 1, 1.0 and 1e0 are equal, and 1e20 is valid without a point. */
    json_arena arena = {NULL, false};
    json_t *root =
        json_arena_read(&arena, text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error);
    if (arena.lacked)
        status = fail_memory(scene->context, size);
    else
        status = root ? read_root(&d, root, scene) : json_syntax_fail(scene->context, path, &error);
    json_arena_release(&arena);
    return file_finish(scene->context, &map, status);
}
