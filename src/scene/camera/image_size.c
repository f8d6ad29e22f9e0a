#include "scene/camera/image_size.h"

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

/* No whole number of pixels may be nearer, in the direction in which the size was rounded. */
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
        warn(
            scene->context,
            "%s: the image is stretched by %.4g across: w over h of the camera is %.6g, width over height of "
            "the image %.6g; leave w out, or take an image of %ux%u",
            path, shape / aspect, aspect, shape, fitting.width, fitting.height);
    } else if (shape < aspect) {
        warn(scene->context,
             "%s: the left and right %.3g %% of the camera's view are not seen: its aspectRatio is %.6g, the "
             "image's %.6g, and its yfov holds; %ux%u shows all of it",
             path, 50 * (1 - shape / aspect), aspect, shape, fitting.width, fitting.height);
    }
}
