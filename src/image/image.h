/* Writing images. OpenImageIO and OpenColorIO live in a module of their own, fathom_image.so, which is loaded
 * on the first use: its 260 libraries cost a quarter of a second. */
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include "base/status.h"

#include <fathom/render.h>

typedef enum image_type { IMAGE_FLOAT, IMAGE_UINT } image_type;

/* One channel: value (x, y) at data + (y * width + x) * stride bytes, top row first. */
typedef struct image_channel {
    const char *name; /* "R", "N.X"… */
    image_type type;
    bool color; /* stored as half in EXR unless asked otherwise */
    const void *data;
    size_t stride;
} image_channel;

/* A header entry: text when it is not NULL, else `count` numbers. */
typedef struct image_attribute {
    const char *name;
    const char *text;
    const double *numbers;
    size_t count;
} image_attribute;

typedef struct image {
    uint32_t width, height;
    uint32_t x, y, full_width, full_height; /* where the pixels lie in the full (uncropped) image */
    const image_channel *channels;          /* R, G, B first */
    size_t channel_count;
    const image_attribute *attributes;
    size_t attribute_count;
} image;

/* Writes the image whole or not at all; see fathom_film_write() for formats and options.
 * FATHOM_BAD_USAGE: unknown extension, display or view (the message lists those there are), no such config;
 * FATHOM_OUT_OF_RESOURCES: cannot be written; FATHOM_INTERNAL: the module cannot be loaded. */
fathom_status image_write(fathom_context *context, const image *img, const char *path,
                          const fathom_write_options *options);

/* Checks path and options as image_write() would, before anything is rendered for them; loads OpenColorIO
 * only when the format needs it and a display, view or config was named. */
fathom_status image_check(fathom_context *context, const char *path, const fathom_write_options *options);

/* Starts loading the module on a thread of its own. */
void image_prefetch(void);

#endif
