/* Images in files. PNG in sRGB is written here. OpenImageIO, for all other formats and for reading, and
 * OpenColorIO, for all other views, live in a process of their own, the image helper: it starts when the
 * first image needs it, next to other work, since its 260 libraries take a quarter of a second to load.
 * Whatever they do, this process lives on. The helper's program is looked for in the folder `fathom` next to
 * the file that holds this code, else in the library folders that belong to that file's place. */
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include "base/status.h"

#include <fathom/render.h>
#include <string.h>

typedef enum image_type { IMAGE_FLOAT, IMAGE_UINT } image_type;

/* One channel: value (x, y) at data + (y * width + x) * stride bytes, top row first. */
typedef struct image_channel {
    const char *name; /* "R", "N.X"… */
    image_type type;
    bool color; /* stored as half in EXR unless asked otherwise */
    const void *data;
    size_t stride;
} image_channel;

/* A header entry: text when it is not NULL, else `count` numbers. EXR stores 1, 2, 3, 9 and 16 numbers as a
 * double, vector or matrix of doubles, and any other count as a text of numbers; the matrices that OpenEXR
 * itself defines are of floats. The other formats keep texts where they have a place for them (Software,
 * ImageDescription; PNG: any). */
typedef struct image_attribute {
    const char *name;
    const char *text;
    const double *numbers;
    size_t count;
} image_attribute;

/* Whether OpenEXR defines the entry as a matrix of floats. */
static inline bool image_attribute_is_m44f(const image_attribute *a) {
    return !a->text && a->count == 16 &&
           (strcmp(a->name, "worldToCamera") == 0 || strcmp(a->name, "worldToNDC") == 0);
}

typedef struct image {
    uint32_t width, height;
    uint32_t x, y, full_width, full_height; /* where the pixels lie in the full (uncropped) image */
    const image_channel *channels;          /* R, G, B first */
    size_t channel_count;
    const image_attribute *attributes;
    size_t attribute_count;
} image;

/* Writes the image whole or not at all; see fathom_film_write() for formats and options.
 *
 * EXR: scene-linear, every value as it is, infinities and NaN too; a finite value beyond half's range becomes
 * the largest half, so that a bright pixel stays a number. The other formats hold R, G and B (A too in PNG
 * and TIFF, not premultiplied): value · 2^exposure, then the display and view, then round(255 v) of v in
 * [0,1]; NaN becomes 0. A pixel of a view that ends in sRGB is marked as such in the file. A config of the
 * user's has to know linear Rec.709 by one of its usual names or through the role aces_interchange; else its
 * role scene_linear is taken to be linear Rec.709.
 *
 * FATHOM_BAD_USAGE: unknown extension, display or view (the message lists those there are), no such config;
 * FATHOM_BAD_INPUT: the config is broken; FATHOM_OUT_OF_RESOURCES: cannot be
 * written, or the image helper is missing or ended. */
fathom_status image_write(fathom_context *context, const image *img, const char *path,
                          const fathom_write_options *options);

/* As image_write(), into a file that is removed again: to see how long that takes. */
fathom_status image_rehearse(fathom_context *context, const image *img, const char *path,
                             const fathom_write_options *options);

/* As image_write() would write PNG, to memory. On FATHOM_OK release it with free(). */
fathom_status image_encode_png(fathom_context *context, const image *img, const fathom_write_options *options,
                               unsigned char **bytes, size_t *size);

/* Checks path and options as image_write() would, before anything is rendered for them: the extension, that
 * the folder exists and can be written to, that the helper is there if it is needed. Asks it only for
 * a view, where the format needs one other than the built-in sRGB. */
fathom_status image_check(fathom_context *context, const char *path, const fathom_write_options *options);
/* FATHOM_BAD_USAGE when the format does not hold as many pixels: known before rendering, as the rest is
 * before reading. */
fathom_status image_check_size(fathom_context *context, const char *path, uint32_t width, uint32_t height);

/* Whether the view is the built-in one for sRGB: no config is named ($OCIO counts), nor another display or
 * view. */
bool image_view_is_srgb(const fathom_write_options *options);

/* Whether writing there takes the helper; false of extensions that are not known. */
bool image_needs_module(const char *path, const fathom_write_options *options);

/* Reads every channel, in the file's order: unsigned 32-bit channels as IMAGE_UINT, all others as float (8-
 * and 16-bit integers as fractions of their maximum). Values are as stored: no colour transform, no change of
 * alpha. Release with image_release(). FATHOM_BAD_INPUT when the file is missing or is no image. */
fathom_status image_read(fathom_context *context, const char *path, const image **out);
void image_release(const image *img);

/* Starts the helper, and does not wait for it. */
void image_prefetch(void);

/* The libraries that the helper works with, "OpenImageIO 2.4.7.1, OpenColorIO 2.1.2", in `out`; waits for its
 * start. FATHOM_OUT_OF_RESOURCES as of image_write(). */
fathom_status image_libraries(fathom_context *context, char out[256]);

/* FATHOM_OUT_OF_RESOURCES with the reason once its start has failed, so that nobody renders for hours towards
 * a file that cannot be written. FATHOM_OK while it is under way, too. Any thread. */
fathom_status image_prefetch_status(fathom_context *context);

#endif
