/* Scene JSON: holds the whole scene. Images stay in place or are copied next to the file. */
#include "write/write_json.h"

#include "read/json/json_form.h"

#include <stdlib.h>
#include <string.h>

static double degrees(double radians) { return radians / 0.017453292519943295; }

const char *json_light_group(const fathom_scene *scene, fathom_light_source source, fathom_id id) {
    for (size_t i = scene->grouped_lights.count; i-- > 0;) {
        const scene_grouped_light *g = &scene->grouped_lights.items[i];
        if (g->source == source && g->id == id) return scene->light_groups.names[g->group];
    }
    return NULL;
}

/* ---- camera and image ---- */

void json_put_matrix(file_writer *t, const double rows[12]) {
    for (int i = 0; i < 16; ++i) {
        file_writer_print(t, i ? "," : "[");
        form_put_number(t, i % 4 < 3 ? rows[i % 4 * 4 + i / 4] : i / 4 == 3);
    }
    file_writer_print(t, "]");
}

/* An object whose members all have a key in the form. */
static void put_members(const json_out *o, const form *f, const void *values, const void *usual) {
    file_writer_print(o->stream.file, "{");
    form_put(o->stream.file, f, values, usual, o->notes);
    file_writer_print(o->stream.file, "}");
}

static form_frame_values frame_of(const double rows[12]) {
    form_frame_values f;
    for (int i = 0; i < 3; ++i) {
        f.x[i] = rows[4 * i], f.y[i] = rows[4 * i + 1], f.z[i] = rows[4 * i + 2];
        f.origin[i] = rows[4 * i + 3];
    }
    return f;
}

static void put_camera_keys(const json_out *o, const fathom_camera *c) {
    file_writer *t = o->stream.file;
    const form_camera_values usual = {.up = {0}};
    for (uint32_t k = 0; k < c->key_count; ++k) {
        const form_camera_values key = {.frame = frame_of(c->key_frames + (size_t)12 * k),
                                        .time = c->key_times[k]};
        file_writer_print(t, k ? "," : ",\"motion\":[");
        put_members(o, &form_camera_key, &key, &usual);
    }
    if (c->key_count) file_writer_print(t, "]");
}

static void put_camera(json_out *o) {
    const fathom_scene *scene = o->scene;
    const fathom_camera *c = &scene->camera;
    file_writer *t = o->stream.file;
    form_camera_values usual = {.up = {0}}, v = {.d = c->d,
                                                 .h = c->h,
                                                 .w = c->w,
                                                 .lens_radius = c->lens_radius,
                                                 .near_clip = c->near_clip,
                                                 .far_clip = c->far_clip};
    if (!c->key_count) {
        memcpy(v.frame.x, c->x, sizeof c->x), memcpy(v.frame.y, c->y, sizeof c->y);
        memcpy(v.frame.z, c->z, sizeof c->z), memcpy(v.frame.origin, c->origin, sizeof c->origin);
    }
    if (c->orthographic) v.orthographic = c->h, v.d = v.h = 0;
    if (c->lens_radius > 0)
        v.focus_distance = c->focus_distance, v.blades = c->blades,
        v.blade_rotation = degrees(c->blade_rotation);
    memcpy(v.shutter, c->shutter, sizeof v.shutter);
    if (scene->has_shutter || c->key_count) usual.shutter[0] = NAN;
    file_writer_print(t, ",\n\"camera\":{");
    form_put(t, &form_camera, &v, &usual, o->notes);
    put_camera_keys(o, c);
    file_writer_print(t, "}");
}

/* Writes target_error if the number of samples or the pattern differs from the default: these keys would turn
 * it off when read. */
static void put_image(json_out *o) {
    const fathom_settings *s = &o->scene->settings;
    fathom_settings usual = write_usual_settings(o->scene);
    if (usual.width != s->width || usual.height != s->height) usual.width = usual.height = 0;
    if (usual.spp != s->spp || usual.pattern != s->pattern) usual.target_error = NAN;
    file_writer_print(o->stream.file, ",\n\"image\":");
    put_members(o, &form_image, s, &usual);
}

/* ---- materials ---- */

static void set_texture(const json_out *o, const fathom_map *map, int kind, form_texture_values *out) {
    const fathom_texture *texture = &o->scene->textures.items[map->texture];
    const fathom_color_space own = material_map_is_color(kind) ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
    const write_turn turn = write_turn_of(map->transform);
    out->file = o->images.items[o->images.of_texture[map->texture]].name;
    if (texture->color_space == FATHOM_COLOR_NAMED)
        out->color_space = texture->color_space_name;
    else if (texture->color_space != own)
        out->color_space = texture->color_space == FATHOM_COLOR_SRGB ? "srgb" : "linear";
    out->channel = (int)map->channel, out->uv_set = map->uv_set, out->inverted = map->inverted;
    out->wrap_u = (int)texture->wrap_u, out->wrap_v = (int)texture->wrap_v;
    out->filter = (int)texture->filter;
    out->rotation = degrees(turn.radians);
    memcpy(out->scale, turn.scale, sizeof out->scale);
    out->offset[0] = (double)map->transform[2], out->offset[1] = (double)map->transform[5];
}

static void put_material(const json_out *o, fathom_id id) {
    const fathom_material *m = &o->scene->materials.items[id].value;
    form_material_values v, usual;
    memset(&usual, 0, sizeof usual);
    fathom_material_default(&usual.material);
    for (int k = 0; k < FATHOM_MAPS; ++k)
        usual.textures[k] = (form_texture_values){.scale = {1, 1}, .filter = FATHOM_TEXTURE_TRILINEAR};
    v = usual;
    v.material = *m;
    if (m->k_a[0] < 0) memcpy(v.material.k_a, usual.material.k_a, sizeof m->k_a);
    /* The opacities of meshes are cut too, so the cutoff is written, which takes a key for opacity. */
    if (m->opacity_cutoff > 0 && scene_has_opacities(o->scene)) usual.material.opacity = NAN;
    v.group = json_light_group(o->scene, FATHOM_SOURCE_MATERIAL, id);
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (m->maps[k].texture != FATHOM_NONE) set_texture(o, &m->maps[k], k, &v.textures[k]);
    }
    put_members(o, form_variant(&form_material, (int)m->model), &v, &usual);
}

/* Every scene has material 0, but no key names it: it is written only for instances that replace others by
 * it.
 */
static fathom_id first_material(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->instances.count; ++i)
        if (scene->instances.items[i].material == 0) return 0;
    return 1;
}

static void put_materials(const json_out *o) {
    file_writer *t = o->stream.file;
    const fathom_id first = first_material(o->scene);
    if (first == o->scene->materials.count) return;
    for (fathom_id i = first; i < o->scene->materials.count; ++i) {
        file_writer_print(t, i > first ? ",\n" : ",\n\"materials\":{\n");
        write_quoted(t, o->materials[i]);
        file_writer_print(t, ":");
        put_material(o, i);
    }
    file_writer_print(t, "}");
}

/* ---- lights ---- */

static form_light_id light_id(const fathom_light *light) {
    switch (light->type) {
    case FATHOM_LIGHT_POINT: return FORM_POINT;
    case FATHOM_LIGHT_SPOT: return FORM_SPOT;
    case FATHOM_LIGHT_DIRECTIONAL: return light->angular_radius > 0 ? FORM_SUN : FORM_DIRECTIONAL;
    case FATHOM_LIGHT_ENVIRONMENT: return FORM_ENVIRONMENT;
    }
    return FORM_POINT;
}

static void put_light(const json_out *o, const fathom_light *light, fathom_id id, const char *file) {
    const bool sky = light->type == FATHOM_LIGHT_ENVIRONMENT;
    const form_light_values usual = {.color = {1, 1, 1}, .intensity = 1, .up = {0, 1, 0}};
    form_light_values v = {.name = light->name, .intensity = 1, .radius = light->radius, .file = file};
    memcpy(v.color, light->intensity, sizeof v.color);
    memcpy(v.position, light->position, sizeof v.position);
    memcpy(v.direction, light->direction, sizeof v.direction);
    v.inner_angle = degrees((double)light->inner_angle);
    v.outer_angle = fmin(degrees((double)light->outer_angle), 90); /* the float next to pi/2 is above it */
    v.angular_diameter = 2 * degrees((double)light->angular_radius);
    v.rotation = degrees(light->rotation);
    memcpy(v.up, light->up, sizeof v.up);
    v.group = json_light_group(o->scene, sky ? FATHOM_SOURCE_ENVIRONMENT : FATHOM_SOURCE_LIGHT, id);
    put_members(o, form_variant(&form_light, (int)light_id(light)), &v, &usual);
}

static void put_lights(const json_out *o) {
    const fathom_scene *scene = o->scene;
    const size_t lights = scene->made.lights ? 0 : scene->lights.count, skies = scene->environments.count;
    if (!lights && !skies && !scene->has_lights) return;
    file_writer_print(o->stream.file, ",\n\"lights\":[");
    for (uint32_t i = 0; i < lights + skies; ++i) {
        file_writer_print(o->stream.file, i ? ",\n" : "\n");
        if (i < lights) {
            put_light(o, &scene->lights.items[i], i, NULL);
            continue;
        }
        const uint32_t sky = i - (uint32_t)lights, image = o->images.of_texture[scene->textures.count + sky];
        const char *faces = o->images.faces[sky];
        put_light(o, &scene->environments.items[sky], sky, faces ? faces : o->images.items[image].name);
    }
    file_writer_print(o->stream.file, "]");
}

/* ---- file ---- */

static void put_rgb(const json_out *o, const char *key, const float rgb[3]) {
    file_writer_print(o->stream.file, ",\n\"%s\":", key);
    form_put_numbers(o->stream.file, form_find(&form_scene, key), rgb, o->notes);
}

static fathom_status put_file(json_out *o, const char *path) {
    const fathom_scene *scene = o->scene;
    fathom_status status = write_stream_open(scene->context, path, &o->stream);
    if (status != FATHOM_OK) return status;
    file_writer *t = o->stream.file;
    const char *behind = json_light_group(scene, FATHOM_SOURCE_BACKGROUND, 0);
    file_writer_print(t, "{\"name\":");
    write_quoted(t, scene->name);
    const bool opens = scene->camera.shutter[0] != scene->camera.shutter[1];
    if (scene->has_camera && (!scene->made.camera || opens)) put_camera(o);
    put_image(o);
    if (scene->has_background && !scene->made.background) put_rgb(o, "background", scene->background);
    if (behind) file_writer_print(t, ",\n\"backgroundGroup\":\"%s\"", behind);
    if (scene->has_ambient && !scene->made.ambient) put_rgb(o, "ambient", scene->ambient);
    put_materials(o);
    put_lights(o);
    status = json_put_objects(o);
    file_writer_print(t, "}\n");
    return write_stream_close(&o->stream, status);
}

fathom_status write_json(const fathom_scene *scene, const scene_graph *graph, const char *path,
                         note_list *notes) {
    json_out o = {.scene = scene, .graph = graph, .notes = notes};
    form_prepare();
    fathom_status status = write_images_open(scene, true, &o.images);
    if (status == FATHOM_OK) status = write_names(scene, false, false, notes, &o.materials);
    if (status == FATHOM_OK) status = write_names(scene, true, false, notes, &o.groups);
    /* Writes images before the file that names them. */
    if (status == FATHOM_OK) status = write_images_beside(scene, path, false, &o.images);
    if (status == FATHOM_OK) status = put_file(&o, path);
    write_names_free(o.materials, scene->materials.count);
    write_names_free(o.groups, scene->groups.count);
    free(o.numbered);
    write_images_close(&o.images);
    return status;
}
