#include "scene/camera/camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

fathom_status scene_note_camera(fathom_scene *scene, const char *name, const char *own_name,
                                bool orthographic) {
    scene_camera camera = {name, own_name, orthographic};
    fathom_status status = scene_own_text(scene, &camera.name);
    if (status == FATHOM_OK) status = scene_own_text(scene, &camera.own_name);
    if (status != FATHOM_OK) return status;
    return array_push(&scene->cameras, camera) ? FATHOM_OK : fail_memory(scene->context, sizeof camera);
}

/* ---- as text ---- */

#define LISTED_MOST 20
#define CAMERA_TEXT 128 /* the maximum that print_camera() writes */

/* Writes a camera as in: 3 "Top" (orthographic) */
static size_t print_camera(const fathom_scene *scene, size_t i, char out[CAMERA_TEXT]) {
    const scene_camera *c = &scene->cameras.items[i];
    const char *name = c->name ? c->name : c->own_name, *quote = name ? "\"" : "";
    return (size_t)snprintf(out, CAMERA_TEXT, "%zu%s%s%.60s%s%s", i, name ? " " : "", quote, name ? name : "",
                            quote, c->orthographic ? " (orthographic)" : "");
}

static void print_all(const fathom_scene *scene, char out[(LISTED_MOST + 1) * CAMERA_TEXT]) {
    const size_t count = scene->cameras.count, listed = count < LISTED_MOST ? count : LISTED_MOST;
    for (size_t i = 0; i < listed; ++i) {
        if (i) out += snprintf(out, CAMERA_TEXT, ", ");
        out += print_camera(scene, i, out);
    }
    if (count > listed) snprintf(out, CAMERA_TEXT, " and %zu more, which fathom info lists", count - listed);
}

/* ---- choosing ---- */

typedef enum name_kind { NAME_OF_NODE, NAME_OF_CAMERA } name_kind;

/* Returns how many cameras have the name; *out is the first. */
static size_t find_name(const fathom_scene *scene, const char *wanted, name_kind kind, uint32_t *out) {
    size_t found = 0;
    for (size_t i = 0; i < scene->cameras.count; ++i) {
        const scene_camera *c = &scene->cameras.items[i];
        const char *name = kind == NAME_OF_NODE ? c->name : c->own_name;
        if (!name || strcmp(name, wanted) != 0) continue;
        if (!found++) *out = (uint32_t)i;
    }
    return found;
}

static bool find_number(const fathom_scene *scene, const char *wanted, uint32_t *out) {
    const size_t digits = strspn(wanted, "0123456789");
    if (!digits || digits > 9 || wanted[digits]) return false;
    *out = (uint32_t)strtoul(wanted, NULL, 10);
    return *out < scene->cameras.count;
}

static fathom_status find_asked(const fathom_scene *scene, const char *path, const char *wanted,
                                uint32_t *out) {
    char list[(LISTED_MOST + 1) * CAMERA_TEXT];
    size_t found = find_name(scene, wanted, NAME_OF_NODE, out);
    if (!found) found = find_name(scene, wanted, NAME_OF_CAMERA, out);
    if (!found && find_number(scene, wanted, out)) found = 1;
    if (found == 1) return FATHOM_OK;
    print_all(scene, list);
    if (!found) {
        return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                         "there is no camera \"%.60s\"; expected one of %s", wanted, list);
    }
    return fail_file(scene->context, FATHOM_BAD_USAGE, path,
                     "%zu cameras are called \"%.60s\"; expected the number of one of %s", found, wanted,
                     list);
}

static void warn_others(const fathom_scene *scene, const char *path) {
    char taken[CAMERA_TEXT];
    const size_t count = scene->cameras.count;
    if (count < 2) return;
    print_camera(scene, scene->camera_taken, taken);
    warn(scene->context, "%s: holds %zu cameras; %s is taken, and --camera NAME|N takes another", path, count,
         taken);
}

/* Unless one is requested, perspective cameras take precedence. */
fathom_status scene_choose_camera(fathom_scene *scene, const char *path) {
    const char *wanted = scene->asked ? scene->asked->camera : NULL;
    scene->camera_taken = FATHOM_NONE;
    if (!scene->cameras.count) return FATHOM_OK;
    if (wanted) return find_asked(scene, path, wanted, &scene->camera_taken);
    scene->camera_taken = 0;
    for (size_t i = scene->cameras.count; i-- > 0;) {
        if (!scene->cameras.items[i].orthographic) scene->camera_taken = (uint32_t)i;
    }
    warn_others(scene, path);
    return FATHOM_OK;
}

/* ---- the aspect ratio of images ---- */

image_size scene_image_size(const fathom_scene *scene) {
    const fathom_read_options *asked = scene->asked;
    if (asked && asked->width) return (image_size){asked->width, asked->height};
    return (image_size){scene->settings.width, scene->settings.height};
}

static uint32_t pixels(double length) { return (uint32_t)(fmin(fmax(length, 1), 65536) + 0.5); }

void image_size_follow(fathom_settings *s, double aspect, bool has_width, bool has_height) {
    if (has_width && has_height) return;
    if (!has_width && !has_height) {
        const uint32_t longer = s->width > s->height ? s->width : s->height;
        has_width = aspect >= 1;
        s->width = s->height = longer;
    }
    if (has_width)
        s->height = pixels(s->width / aspect);
    else
        s->width = pixels(s->height * aspect);
}

/* True if one side follows from the other by the aspect ratio, rounded to whole pixels. */
static bool has_shape(image_size size, double aspect) {
    return fabs(size.width - size.height * aspect) <= 0.5 || fabs(size.height - size.width / aspect) <= 0.5;
}

void scene_warn_shape(const fathom_scene *scene, const char *path) {
    const fathom_camera *c = &scene->camera;
    const bool fixed = scene->has_camera && c->w > 0;
    const double aspect = fixed ? c->w / c->h : scene->camera_aspect;
    const image_size size = scene_image_size(scene);
    const double shape = (double)size.width / size.height;
    if (!(aspect > 0) || has_shape(size, aspect)) return;
    fathom_settings fitting = {.width = size.width, .height = size.height};
    image_size_follow(&fitting, aspect, false, false);
    if (fixed) {
        warn(scene->context,
             "%s: the image is stretched horizontally by %.4g: w over h of the camera is %.6g, width over "
             "height of the image %.6g; leave w out, or take an image of %ux%u",
             path, shape / aspect, aspect, shape, fitting.width, fitting.height);
    } else if (shape < aspect) {
        warn(scene->context,
             "%s: the left and right %.3g %% of the camera's view are not seen: its aspectRatio is %.6g, the "
             "image's %.6g, and its yfov holds; %ux%u shows all of it",
             path, 50 * (1 - shape / aspect), aspect, shape, fitting.width, fitting.height);
    }
}
