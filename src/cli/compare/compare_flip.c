#include "cli/compare/compare_flip.h"

#include "base/file.h"
#include "image/compare/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const image_channel *compare_channel(const image *img, const char *name) {
    for (size_t i = 0; i < img->channel_count; ++i) {
        if (strcmp(img->channels[i].name, name) == 0) return &img->channels[i];
    }
    return NULL;
}

double compare_value(const image_channel *c, uint32_t width, uint32_t x, uint32_t y) {
    const char *place = (const char *)c->data + ((size_t)y * width + x) * c->stride;
    float number;
    uint32_t id;
    switch (c->type) {
    case IMAGE_FLOAT: memcpy(&number, place, sizeof number); return (double)number;
    case IMAGE_UINT: memcpy(&id, place, sizeof id); return (double)id;
    }
    return 0;
}

/* IEC 61966-2-1. */
static double linear_of(double srgb) {
    return srgb > 0.04045 ? pow((srgb + 0.055) / 1.055, 2.4) : srgb / 12.92;
}

static void take_plane(const image_channel *c, const image *img, bool encoded, float *out) {
    for (uint32_t y = 0; y < img->height; ++y) {
        for (uint32_t x = 0; x < img->width; ++x) {
            double value = compare_value(c, img->width, x, y);
            *out++ = (float)(encoded ? linear_of(value) : value);
        }
    }
}

/* The planes are in *memory, to be released with free(). */
static fathom_status take_image(fathom_context *context, const compare_side *side, float **memory,
                                metric_image *out) {
    static const char *const names[3] = {"R", "G", "B"};
    char extension[16];
    file_extension(side->path, extension);
    bool encoded = strcmp(extension, "exr") != 0;
    size_t pixels = (size_t)side->img->width * side->img->height;
    *memory = malloc(3 * pixels * sizeof **memory);
    if (!*memory) return fail_memory(context, 3 * pixels * sizeof **memory);
    *out = (metric_image){.width = side->img->width, .height = side->img->height};
    for (size_t i = 0; i < 3; ++i) {
        const image_channel *c = compare_channel(side->img, names[i]);
        if (!c || c->type != IMAGE_FLOAT)
            return fail_file(context, FATHOM_BAD_INPUT, side->path, "FLIP needs the channels R, G and B");
        take_plane(c, side->img, encoded, *memory + i * pixels);
        out->rgb[i] = *memory + i * pixels;
    }
    return FATHOM_OK;
}

static fathom_status compare_planes(fathom_context *context, const metric_image *a, const metric_image *b,
                                    double ppd, compare_flip *out) {
    flip_view *one = flip_view_create(a, ppd), *other = flip_view_create(b, ppd);
    bool made = one && other;
    if (made) *out = (compare_flip){flip_mean(one, other, NULL), metric_nonfinite(a, b)};
    flip_view_destroy(one);
    flip_view_destroy(other);
    return made ? FATHOM_OK : fail_memory(context, (size_t)a->width * a->height * 8 * sizeof(double));
}

fathom_status compare_flip_of(fathom_context *context, const compare_side *a, const compare_side *b,
                              double ppd, compare_flip *out) {
    float *memory[2] = {NULL, NULL};
    metric_image images[2];
    fathom_status status = take_image(context, a, &memory[0], &images[0]);
    if (status == FATHOM_OK) status = take_image(context, b, &memory[1], &images[1]);
    if (status == FATHOM_OK) status = compare_planes(context, &images[0], &images[1], ppd, out);
    free(memory[0]);
    free(memory[1]);
    return status;
}
