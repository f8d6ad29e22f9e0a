/* The image calls of the public interface: reading, access to channels, comparison. */
#include "base/file.h"
#include "base/sized.h"
#include "base/srgb.h"
#include "image/compare/flip.h"
#include "image/image.h"

#include <math.h>
#include <stdlib.h>

/* In clang, a comparison of floats is not a constant expression. */
_Static_assert((int)FATHOM_FLIP_PPD == (int)FLIP_PPD && (int)FATHOM_FLIP_PPD_LEAST == (int)FLIP_PPD_LEAST &&
                   (int)FATHOM_FLIP_PPD_MOST == (int)FLIP_PPD_MOST,
               "fathom/image.h says what FLIP takes");

struct fathom_image {
    const image *img;
    bool encoded; /* values are sRGB, not linear */
    char path[];  /* for messages */
};

fathom_status fathom_image_read(fathom_context *context, const char *path, const fathom_image **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !path) return fail_null(context, "path");
    const size_t length = strlen(path) + 1;
    fathom_image *found = calloc(1, sizeof *found + length);
    if (!found) return fail_memory(context, sizeof *found + length);
    memcpy(found->path, path, length);
    found->encoded = !file_ends_in(path, "exr|hdr|pfm");
    fathom_status status = image_read(context, path, &found->img);
    if (status == FATHOM_OK)
        *out = found;
    else
        free(found);
    return status;
}

void fathom_image_destroy(const fathom_image *img) {
    if (!img) return;
    image_release(img->img);
    free((void *)(uintptr_t)img);
}

/* ---- channels ---- */

static const void *channel_data(const fathom_image *img, const char *name, image_type type, size_t *stride) {
    const image_channel *c = img && name ? image_find_channel(img->img, name) : NULL;
    if (!c || c->type != type) return NULL;
    if (stride) *stride = c->stride;
    return c->data;
}

void fathom_image_size(const fathom_image *img, uint32_t *width, uint32_t *height) {
    if (width) *width = img ? img->img->width : 0;
    if (height) *height = img ? img->img->height : 0;
}

const char *fathom_image_channel_name(const fathom_image *img, size_t index) {
    return img && index < img->img->channel_count ? img->img->channels[index].name : NULL;
}

const float *fathom_image_channel(const fathom_image *img, const char *name, size_t *stride) {
    return channel_data(img, name, IMAGE_FLOAT, stride);
}

const uint32_t *fathom_image_channel_id(const fathom_image *img, const char *name, size_t *stride) {
    return channel_data(img, name, IMAGE_UINT, stride);
}

/* ---- values ---- */

static double value_at(const image_channel *c, uint32_t width, uint32_t x, uint32_t y) {
    const char *place = (const char *)c->data + ((size_t)y * width + x) * c->stride;
    float number;
    uint32_t id;
    switch (c->type) {
    case IMAGE_FLOAT: memcpy(&number, place, sizeof number); return (double)number;
    case IMAGE_UINT: memcpy(&id, place, sizeof id); return (double)id;
    }
    return 0;
}

static double distance(double a, double b) {
    if (a == b || (isnan(a) && isnan(b))) return 0;
    double d = fabs(a - b);
    return isnan(d) ? HUGE_VAL : d;
}

static fathom_status check_channels(fathom_context *context, const image *one, const image *other,
                                    const char *which) {
    for (size_t i = 0; i < one->channel_count; ++i) {
        const image_channel *c = &one->channels[i], *twin = image_find_channel(other, c->name);
        if (!twin)
            return fail(context, FATHOM_CHECK_FAILED, "channel %.60s is only in the %s", c->name, which);
        if (twin->type != c->type)
            return fail(context, FATHOM_CHECK_FAILED, "channel %.60s is of different types", c->name);
    }
    return FATHOM_OK;
}

static fathom_status check_alike(fathom_context *context, const image *a, const image *b) {
    if (a->width != b->width || a->height != b->height)
        return fail(context, FATHOM_CHECK_FAILED, "different sizes: %ux%u and %ux%u", a->width, a->height,
                    b->width, b->height);
    if (a->x != b->x || a->y != b->y || a->full_width != b->full_width || a->full_height != b->full_height)
        return fail(context, FATHOM_CHECK_FAILED,
                    "different crops: at (%d,%d) of %ux%u and at (%d,%d) of %ux%u", (int32_t)a->x,
                    (int32_t)a->y, a->full_width, a->full_height, (int32_t)b->x, (int32_t)b->y, b->full_width,
                    b->full_height);
    fathom_status status = check_channels(context, a, b, "first");
    return status == FATHOM_OK ? check_channels(context, b, a, "second") : status;
}

static bool compare_pixel(const image *a, const image *b, uint32_t x, uint32_t y, double tolerance,
                          fathom_image_difference *out) {
    bool differs = false;
    for (size_t i = 0; i < a->channel_count; ++i) {
        const image_channel *c = &a->channels[i], *twin = image_find_channel(b, c->name);
        double d = distance(value_at(c, a->width, x, y), value_at(twin, b->width, x, y));
        differs |= d > tolerance;
        out->rmse += d * d;
        if (d > out->largest) {
            out->largest = d;
            out->x = x, out->y = y;
            out->channel = c->name;
        }
    }
    return differs;
}

fathom_status fathom_image_compare(fathom_context *context, const fathom_image *a, const fathom_image *b,
                                   double tolerance, fathom_image_difference *out) {
    if (!context || !a) return fail_null(context, "a");
    if (!b) return fail_null(context, "b");
    if (!(tolerance >= 0))
        return fail_field(context, FATHOM_BAD_USAGE, "tolerance", "expected a number >= 0, found %g",
                          tolerance);
    fathom_image_difference d = {.channel = ""};
    fathom_status status = sized_check(context, "out", out, sizeof d);
    if (status == FATHOM_OK) status = check_alike(context, a->img, b->img);
    if (status != FATHOM_OK) return status;
    if (a->encoded != b->encoded && (a->encoded ? a : b)->img->bits == 8)
        warn(context,
             "one image has colours for a display, and the other linear ones; only FLIP is a measure "
             "of their difference");
    const uint32_t width = a->img->width, height = a->img->height;
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) d.pixels += compare_pixel(a->img, b->img, x, y, tolerance, &d);
    }
    d.rmse = sqrt(d.rmse / ((double)width * height * (double)a->img->channel_count));
    sized_write(out, &d, sizeof d);
    return FATHOM_OK;
}

/* ---- FLIP ---- */

static void take_plane(const image_channel *c, const fathom_image *from, float *out) {
    for (uint32_t y = 0; y < from->img->height; ++y) {
        for (uint32_t x = 0; x < from->img->width; ++x) {
            double value = value_at(c, from->img->width, x, y);
            *out++ = (float)(from->encoded ? srgb_decoded(value) : value);
        }
    }
}

/* The planes are in *memory; the caller frees it. */
static fathom_status take_image(fathom_context *context, const fathom_image *from, float **memory,
                                metric_image *out) {
    static const char *const names[3] = {"R", "G", "B"};
    const size_t pixels = (size_t)from->img->width * from->img->height;
    *memory = malloc(3 * pixels * sizeof **memory);
    if (!*memory) return fail_memory(context, 3 * pixels * sizeof **memory);
    *out = (metric_image){.width = from->img->width, .height = from->img->height};
    for (size_t i = 0; i < 3; ++i) {
        const image_channel *c = image_find_channel(from->img, names[i]);
        if (!c || c->type != IMAGE_FLOAT)
            return fail_file(context, FATHOM_BAD_INPUT, from->path, "FLIP needs the channels R, G and B");
        take_plane(c, from, *memory + i * pixels);
        out->rgb[i] = *memory + i * pixels;
    }
    return FATHOM_OK;
}

static fathom_status flip_planes(fathom_context *context, const metric_image *a, const metric_image *b,
                                 double ppd, fathom_flip *out) {
    flip_view *one = flip_view_create(a, ppd), *other = flip_view_create(b, ppd);
    bool made = one && other;
    if (made) out->mean = flip_mean(one, other, NULL), out->nonfinite = metric_nonfinite(a, b);
    flip_view_destroy(one);
    flip_view_destroy(other);
    return made ? FATHOM_OK : fail_memory(context, (size_t)a->width * a->height * 8 * sizeof(double));
}

static fathom_status check_flip(fathom_context *context, const fathom_image *a, const fathom_image *b,
                                double ppd, const fathom_flip *out) {
    fathom_status status = sized_check(context, "out", out, sizeof *out);
    if (status != FATHOM_OK) return status;
    if (!(ppd >= FLIP_PPD_LEAST && ppd <= FLIP_PPD_MOST))
        return fail_field(context, FATHOM_BAD_USAGE, "ppd", "expected a number from %g to %g, found %g",
                          FLIP_PPD_LEAST, FLIP_PPD_MOST, ppd);
    return check_alike(context, a->img, b->img);
}

fathom_status fathom_image_flip(fathom_context *context, const fathom_image *a, const fathom_image *b,
                                double ppd, fathom_flip *out) {
    if (!context || !a) return fail_null(context, "a");
    if (!b) return fail_null(context, "b");
    fathom_flip found = {.mean = 0};
    float *memory[2] = {NULL, NULL};
    metric_image images[2];
    fathom_status status = check_flip(context, a, b, ppd, out);
    if (status == FATHOM_OK) status = take_image(context, a, &memory[0], &images[0]);
    if (status == FATHOM_OK) status = take_image(context, b, &memory[1], &images[1]);
    if (status == FATHOM_OK) status = flip_planes(context, &images[0], &images[1], ppd, &found);
    if (status == FATHOM_OK) sized_write(out, &found, sizeof found);
    free(memory[0]);
    free(memory[1]);
    return status;
}
