#include "film/film_marks.h"

#include "base/murmur.h"
#include "camera/camera.h"
#include "image/image.h"

#include <stdio.h>
#include <string.h>

/* OpenEXR multiplies row vectors by matrices, (x y z 1) M, and stores matrices row by row
 * (ImfStandardAttributes.h). So each column gives one coordinate. */
static void set_column(double m[16], int column, vec3_f64 axis, double constant) {
    m[column] = axis.x, m[4 + column] = axis.y, m[8 + column] = axis.z, m[12 + column] = constant;
}

/* The coordinate along the axis, relative to the camera. */
static void set_axis(double m[16], int column, vec3_f64 axis, vec3_f64 origin) {
    set_column(m, column, axis, -dot_f64(axis, origin));
}

/* World to camera, left-handed: x to the right, y up, z forwards. */
static void set_to_camera(const fathom_camera *camera, double out[16]) {
    const vec3_f64 origin = load_f64(camera->origin);
    set_axis(out, 0, load_f64(camera->x), origin);
    set_axis(out, 1, load_f64(camera->y), origin);
    set_axis(out, 2, neg_f64(load_f64(camera->z)), origin);
    set_column(out, 3, (vec3_f64){0, 0, 0}, 1);
}

/* The same for a parallel projection: x / w + 1/2 and 1/2 - y / h, without a division by z. */
static void set_parallel_ndc(const fathom_camera *camera, double w, double h, double out[16]) {
    const vec3_f64 origin = load_f64(camera->origin), x = scale_f64(1 / w, load_f64(camera->x)),
                   y = scale_f64(-1 / h, load_f64(camera->y)), forwards = neg_f64(load_f64(camera->z));
    set_column(out, 0, x, 0.5 - dot_f64(x, origin));
    set_column(out, 1, y, 0.5 - dot_f64(y, origin));
    set_axis(out, 2, forwards, origin);
    set_column(out, 3, (vec3_f64){0, 0, 0}, 1);
}

/* With (x, y, z) relative to the camera, x / (w z) + 1/2 and 1/2 - y / (h z) range from (0, 0) at the upper
 * left corner of the whole image to (1, 1). The products are divided by the fourth coordinate, z. The third
 * coordinate has no meaning here; 1 - 1/z keeps the matrix invertible. */
static void set_to_ndc(const fathom_film *film, double out[16]) {
    const fathom_camera *camera = &film->camera;
    const vec3_f64 origin = load_f64(camera->origin), forwards = neg_f64(load_f64(camera->z));
    double w, h;
    camera_extent(camera, film->full_width, film->full_height, &w, &h);
    if (camera->orthographic) {
        set_parallel_ndc(camera, w, h, out);
        return;
    }
    set_axis(out, 0, madd_f64(scale_f64(0.5, forwards), 1 / w, load_f64(camera->x)), origin);
    set_axis(out, 1, madd_f64(scale_f64(0.5, forwards), -1 / h, load_f64(camera->y)), origin);
    set_column(out, 2, forwards, -dot_f64(forwards, origin) - 1);
    set_axis(out, 3, forwards, origin);
}

static void add_text(film_marks *out, const char *name, const char *text) {
    out->items[out->count++] = (image_attribute){.name = name, .text = text};
}

static void add_matrix(film_marks *out, const char *name, const double *numbers) {
    out->items[out->count++] = (image_attribute){.name = name, .numbers = numbers, .count = 16};
}

/* These are texts: all formats can hold the first, and PNG holds only texts. */
static void add_interruption(const fathom_film *film, film_marks *out) {
    const double share = film->stats.finished;
    snprintf(out->description, sizeof out->description, "Interrupted: %.1f %% of the render is done",
             100 * share);
    snprintf(out->finished, sizeof out->finished, "%.4f", share);
    add_text(out, "ImageDescription", out->description);
    add_text(out, "fathom:interrupted", "true");
    add_text(out, "fathom:finished", out->finished);
}

/* The key of a layer is the first seven digits of the hash of its name. These entries come last, because
 * files without mattes leave them out. */
static void add_mattes(const fathom_film *film, film_marks *out) {
    static const char *const what[4] = {"name", "hash", "conversion", "manifest"};
    for (int k = 0; k < MATTE_KINDS; ++k) {
        const char *layer = matte_layer((matte_kind)k);
        const char *const texts[4] = {layer, "MurmurHash3_32", "uint32_to_float32", film->manifests[k]};
        for (int i = 0; film->manifests[k] && i < 4; ++i) {
            char *key = out->matte_keys[k][i];
            snprintf(key, sizeof out->matte_keys[k][i], "%s%07x/%s", IMAGE_MATTE_ENTRY,
                     murmur_hash(layer, strlen(layer)) >> 4, what[i]);
            add_text(out, key, texts[i]);
        }
    }
}

void film_marks_of(const fathom_film *film, const fathom_write_options *options, film_marks *out) {
    *out = (film_marks){.seconds = film->stats.render_seconds + film->stats.resumed_seconds};
    set_to_camera(&film->camera, out->to_camera);
    set_to_ndc(film, out->to_ndc);
    add_matrix(out, "worldToCamera", out->to_camera);
    add_matrix(out, "worldToNDC", out->to_ndc);
    if (!image_date_is_given()) {
        out->items[out->count++] =
            (image_attribute){.name = "fathom:renderTime", .numbers = &out->seconds, .count = 1};
    }
    if (film->interrupted) add_interruption(film, out);
    if (options && options->exposure != 0) {
        snprintf(out->exposure, sizeof out->exposure, "%g", (double)options->exposure);
        add_text(out, "fathom:exposure", out->exposure);
    }
    add_mattes(film, out);
}
