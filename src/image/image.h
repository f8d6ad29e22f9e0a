/* Image files. The library itself writes EXR, and PNG in sRGB. Other formats, reading, and other views need
 * OpenImageIO and OpenColorIO, which run in their own process, the image helper. The helper starts when the
 * first image needs it, in parallel with other work, because its 260 libraries take a quarter of a second to
 * load. Its failures do not end this process. The library looks for the helper's program in the folder
 * `fathom` next to the file that holds this code, then in the library folders near that file. */
#pragma once

#include "base/status.h"

#include <fathom/image.h>
#include <string.h>

typedef enum image_type { IMAGE_FLOAT, IMAGE_UINT } image_type;

/* One channel: value (x, y) at data + (y * width + x) * stride bytes, top row first. */
typedef struct image_channel {
    const char *name; /* "R", "N.X"… */
    image_type type;
    bool color; /* stored as half in EXR by default */
    const void *data;
    size_t stride;
} image_channel;

/* A header entry: text, or 1, 3 or 16 numbers if text is NULL. EXR stores these as a double, a vector of
 * doubles or a matrix of floats. The other formats keep texts for which they have a field (Software,
 * ImageDescription; PNG: any). */
typedef struct image_attribute {
    const char *name;
    const char *text;
    const double *numbers;
    size_t count;
} image_attribute;

/* Entries with this prefix describe EXR channels; other formats skip them. They come last. */
#define IMAGE_MATTE_ENTRY "cryptomatte/"

typedef struct image {
    uint32_t width, height;
    uint32_t x, y, full_width, full_height; /* position of the pixels in the full (uncropped) image. Pixels of
                                               a file may lie outside of it; x and y are then modulo 2^32 */
    const image_channel *channels;          /* R, G, B first */
    size_t channel_count;
    const image_attribute *attributes;
    size_t attribute_count;
    uint32_t bits; /* of a number in the file that was read */
} image;

/* The first channel with this name, or NULL. */
static inline const image_channel *image_find_channel(const image *img, const char *name) {
    for (size_t i = 0; i < img->channel_count; ++i) {
        if (strcmp(img->channels[i].name, name) == 0) return &img->channels[i];
    }
    return NULL;
}

/* Writes the whole image or nothing; see fathom_film_write() for formats and options.
 *
 * EXR: scene-linear values, with infinities and NaN; a finite value beyond half's range becomes the largest
 * half, so that a bright pixel stays a number. The other formats hold R, G and B (PNG and TIFF also A, not
 * premultiplied): value · 2^exposure, then the display and view, then round(255 v) with v clamped to [0,1];
 * NaN becomes 0. The file is marked as sRGB if the view ends in sRGB. A user's config must name linear
 * Rec.709 by one of its usual names or have the role aces_interchange; otherwise its role scene_linear is
 * used as linear Rec.709.
 *
 * FATHOM_BAD_USAGE: unknown extension, display or view (the message lists the known ones), or no such config;
 * FATHOM_BAD_INPUT: the config is broken; FATHOM_OUT_OF_RESOURCES: cannot be written, or the image helper is
 * missing or ended. */
fathom_status image_write(fathom_context *context, const image *img, const char *path,
                          const fathom_write_options *options);

/* As image_write() to .exr, but with memory for one row only: no compression, all colours as 32-bit floats.
 * For saving pixels when everything else fails. FATHOM_OUT_OF_RESOURCES. */
fathom_status exr_write_plain(fathom_context *context, const image *img, const char *path);

/* As image_write(), to a file that is then removed: measures the time. */
fathom_status image_rehearse(fathom_context *context, const image *img, const char *path,
                             const fathom_write_options *options);

/* Checks path and options before rendering: that the extension is known, that the folder is writable, and
 * that the helper exists if it is needed. Calls the helper only for a view other than the built-in sRGB. */
fathom_status image_check(fathom_context *context, const char *path, const fathom_write_options *options);
/* FATHOM_BAD_USAGE if the image is too large for the format. */
fathom_status image_check_size(fathom_context *context, const char *path, uint32_t width, uint32_t height);

/* True if the view is the built-in sRGB: the options name no config, display or other view, and $OCIO is not
 * set. */
bool image_view_is_srgb(const fathom_write_options *options);

/* A hash of the files, such as LUTs, that the config names for the view; 0 if it names none, or cannot be
 * opened, which writing reports. */
uint64_t image_config_files(const fathom_write_options *options);

/* True when $SOURCE_DATE_EPOCH is set: equal renders then give equal files, so files must not contain the
 * time or speed of the render (reproducible-builds.org/specs/source-date-epoch). */
bool image_date_is_given(void);

/* True when writing there needs the helper; false for unknown extensions. */
bool image_needs_module(const char *path, const fathom_write_options *options);

/* Reads every channel in the file's order: unsigned 32-bit channels as IMAGE_UINT, the others as float (8-
 * and 16-bit integers as fractions of their maximum), without any change of colour or alpha, but no entries
 * of the header. Release with image_release(). FATHOM_BAD_INPUT when the file is missing or is no image. */
fathom_status image_read(fathom_context *context, const char *path, const image **out);
void image_release(const image *img);

/* Starts the helper without waiting for it. */
void image_prefetch(void);

/* The helper's libraries, "OpenImageIO 2.4.7.1, OpenColorIO 2.1.2"; waits for its start.
 * FATHOM_OUT_OF_RESOURCES as image_write(). */
fathom_status image_libraries(fathom_context *context, char out[256]);

/* FATHOM_OUT_OF_RESOURCES with the reason if the helper failed to start, so that a render for a file that
 * cannot be written stops early; otherwise FATHOM_OK. Thread-safe. */
fathom_status image_prefetch_status(fathom_context *context);
