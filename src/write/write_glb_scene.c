/* Textures, lights and the camera of binary glTF. */
#include "write/write_glb.h"

#include "math/frame.h"

#include <string.h>

static const double pi = 3.14159265358979324;

/* ---- textures ---- */

static unsigned wrap_code(fathom_wrap wrap) {
    switch (wrap) {
    case FATHOM_WRAP_REPEAT: return 10497;
    case FATHOM_WRAP_MIRROR: return 33648;
    case FATHOM_WRAP_CLAMP: return 33071;
    }
    return 10497;
}

static const char *filter_codes(fathom_texture_filter filter) {
    switch (filter) {
    case FATHOM_TEXTURE_NEAREST: return "\"magFilter\":9728,\"minFilter\":9728";
    case FATHOM_TEXTURE_LINEAR: return "\"magFilter\":9729,\"minFilter\":9729";
    case FATHOM_TEXTURE_TRILINEAR:
    case FATHOM_TEXTURE_STOCHASTIC: return "\"magFilter\":9729,\"minFilter\":9987";
    }
    return "";
}

/* Image types that need an extension are named in the extension. */
static void put_source(file_writer *t, const char *type, uint32_t image) {
    if (type && (strcmp(type, "image/webp") == 0 || strcmp(type, "image/avif") == 0))
        file_writer_print(t, "\"extensions\":{\"EXT_texture_%s\":{\"source\":%u}}", strchr(type, '/') + 1,
                          image);
    else if (type && strcmp(type, "image/ktx2") == 0)
        file_writer_print(t, "\"extensions\":{\"KHR_texture_basisu\":{\"source\":%u}}", image);
    else
        file_writer_print(t, "\"source\":%u", image);
}

static void put_images(const glb *g, file_writer *t) {
    file_writer_print(t, "],\n\"images\":[");
    for (uint32_t i = 0; i < g->images.count; ++i) {
        const write_image *image = &g->images.items[i];
        const char *type = write_image_type(image), *name = image->texture->name;
        file_writer_print(t, "%s\n{\"bufferView\":%u,\"mimeType\":\"%s\"", i ? "," : "", g->views + i,
                          type ? type : "application/octet-stream");
        if (!name && image->texture->file) name = file_name(image->texture->file);
        if (name) glb_put_name(t, ",", name);
        file_writer_print(t, "}");
        if (!type)
            notes_add(g->notes, 1, "",
                      "an image is none of the formats that glTF names, PNG, JPEG, WebP, "
                      "AVIF and KTX 2.0; Fathom reads it, and others may not");
    }
}

void glb_put_textures(const glb *g, file_writer *t) {
    const size_t count = g->scene->textures.count;
    if (!count) return;
    file_writer_print(t, ",\n\"textures\":[");
    for (size_t i = 0; i < count; ++i) {
        const uint32_t image = g->images.of_texture[i];
        file_writer_print(t, "%s\n{\"sampler\":%zu,", i ? "," : "", i);
        put_source(t, write_image_type(&g->images.items[image]), image);
        file_writer_print(t, "}");
    }
    file_writer_print(t, "],\n\"samplers\":[");
    for (size_t i = 0; i < count; ++i) {
        const fathom_texture *texture = &g->scene->textures.items[i];
        file_writer_print(t, "%s\n{\"wrapS\":%u,\"wrapT\":%u,%s}", i ? "," : "", wrap_code(texture->wrap_u),
                          wrap_code(texture->wrap_v), filter_codes(texture->filter));
    }
    put_images(g, t);
    file_writer_print(t, "]");
}

/* ---- lights and the camera ---- */

static size_t lights_of(const glb *g) { return g->scene->made.lights ? 0 : g->scene->lights.count; }

static bool has_camera(const glb *g) { return g->scene->has_camera && !g->scene->made.camera; }

bool glb_has_lights(const glb *g) { return lights_of(g) > 0; }

size_t glb_surroundings(const glb *g) { return lights_of(g) + has_camera(g); }

/* Columns x, y, z and the origin. */
static void put_frame(file_writer *t, vec3_f64 x, vec3_f64 y, vec3_f64 z, const double origin[3]) {
    file_writer_print(
        t, "\"matrix\":[%.17g,%.17g,%.17g,0,%.17g,%.17g,%.17g,0,%.17g,%.17g,%.17g,0,%.17g,%.17g,%.17g,1]",
        x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z, origin[0], origin[1], origin[2]);
}

/* A light points along the -z axis of its node. The y axis is arbitrary. */
static void put_light_node(file_writer *t, const fathom_light *light, size_t number) {
    static const double zero[3] = {0, 0, 0};
    const bool placed = light->type != FATHOM_LIGHT_DIRECTIONAL;
    const vec3_f64 back =
        light->type == FATHOM_LIGHT_POINT ? vec_f64(0, 0, 1) : neg_f64(load_f64(light->direction));
    const frame_f64 frame = frame_from(vec_f64(0, 0, 0), back, vec_f64(0, 1, 0));
    file_writer_print(t, ",\n{\"extensions\":{\"KHR_lights_punctual\":{\"light\":%zu}},", number);
    put_frame(t, frame.x, frame.y, frame.z, placed ? light->position : zero);
    file_writer_print(t, "}");
}

void glb_put_surroundings(const glb *g, file_writer *t) {
    const fathom_scene *scene = g->scene;
    const fathom_camera *c = &scene->camera;
    for (size_t i = 0; i < lights_of(g); ++i) put_light_node(t, &scene->lights.items[i], i);
    if (!has_camera(g)) return;
    const char *name = NULL;
    if (scene->cameras.count && scene->camera_taken != FATHOM_NONE)
        name = scene->cameras.items[scene->camera_taken].name;
    file_writer_print(t, ",\n{\"camera\":0,");
    put_frame(t, load_f64(c->x), load_f64(c->y), load_f64(c->z), c->origin);
    if (name) glb_put_name(t, ",", name);
    file_writer_print(t, "}");
}

/* The angle for which the reader's 2 tan(yfov / 2) is exactly `size`, if a double near it is; else the
 * nearest. */
static double angle_of(double size) {
    const double middle = 2 * atan(size / 2);
    double angle = middle, up = middle;
    for (int i = 0; i < 8; ++i, angle = nextafter(angle, 0), up = nextafter(up, 4)) {
        if (2 * tan(angle / 2) == size) return angle;
        if (2 * tan(up / 2) == size) return up;
    }
    return middle;
}

/* glTF requires a near plane, and a far one of orthographic cameras. Where the scene has none, they are so
 * near and so far that they clip nothing of most scenes. */
static void put_camera(const glb *g, file_writer *t) {
    const fathom_camera *c = &g->scene->camera;
    const fathom_settings *s = &g->scene->settings;
    const double asked = c->w > 0 ? c->w / c->h : g->scene->camera_aspect,
                 aspect = asked > 0 ? asked : (double)s->width / s->height,
                 near = c->near_clip > 0 || c->orthographic ? c->near_clip : 0.001;
    if (c->orthographic) {
        file_writer_print(t,
                          ",\n\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":%.17g,"
                          "\"ymag\":%.17g,\"znear\":%.17g,\"zfar\":%.17g}}]",
                          0.5 * c->h * aspect, 0.5 * c->h, near, c->far_clip > 0 ? c->far_clip : near + 1e6);
        return;
    }
    file_writer_print(
        t,
        ",\n\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":%.17g,\"znear\":%.17g,"
        "\"aspectRatio\":%.17g",
        angle_of(c->h / c->d), near, aspect);
    if (c->far_clip > 0) file_writer_print(t, ",\"zfar\":%.17g", c->far_clip);
    file_writer_print(t, "}}]");
    if (c->lens_radius > 0)
        notes_add(g->notes, 1, "", "the camera's lens has no place in glTF, and becomes a pinhole");
}

/* The reader's strength is the colour times the intensity divided by pi. */
static void put_light(const glb *g, file_writer *t, const fathom_light *light) {
    static const char *const types[] = {"point", "directional", "spot", ""};
    const float *k = light->intensity;
    const double most = fmax((double)k[0], fmax((double)k[1], (double)k[2]));
    file_writer_print(t, "{");
    if (light->name) glb_put_name(t, "", light->name), file_writer_print(t, ",");
    file_writer_print(t, "\"type\":\"%s\",\"intensity\":%.17g,\"color\":[", types[light->type], most * pi);
    for (int c = 0; c < 3; ++c)
        file_writer_print(t, "%s%.17g", c ? "," : "", most > 0 ? (double)k[c] / most : 1);
    file_writer_print(t, "]");
    if (light->type == FATHOM_LIGHT_SPOT)
        file_writer_print(t, ",\"spot\":{\"innerConeAngle\":%.9g,\"outerConeAngle\":%.9g}",
                          (double)light->inner_angle, (double)light->outer_angle);
    file_writer_print(t, "}");
    if (light->radius > 0 || light->angular_radius > 0)
        notes_add(g->notes, 1, "", "the size of a light has no place in glTF, and is left out");
}

void glb_put_cameras(const glb *g, file_writer *t) {
    if (has_camera(g)) put_camera(g, t);
    if (!glb_has_lights(g)) return;
    file_writer_print(t, ",\n\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
    for (size_t i = 0; i < lights_of(g); ++i) {
        file_writer_print(t, i ? ",\n" : "\n");
        put_light(g, t, &g->scene->lights.items[i]);
    }
    file_writer_print(t, "]}}");
}
