/* Image files: writing films, reading images, comparing them. */
#ifndef FATHOM_IMAGE_H
#define FATHOM_IMAGE_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- writing ---- */

typedef struct fathom_write_options {
    size_t size;
    float exposure;      /* stops, applied before the view transform and not to EXR; default 0 */
    const char *ocio;    /* OpenColorIO config file; NULL: $OCIO, else the built-in sRGB config */
    const char *display; /* NULL: the config's default */
    const char *view;    /* NULL: the display's default */
    bool float_color; /* EXR: R G B A albedo as 32-bit float instead of half, whose maximum is 65504; default
                         false */
    const char *command; /* what made the image, a line of text for the header; NULL or "": none */
} fathom_write_options;

FATHOM_DEFAULT(fathom_write_options)

/* Call it before rendering. It finds everything that would make fathom_film_write() fail, except a full disk:
 * an unknown extension, display or view, a folder that cannot be written to, a missing image helper.
 * Statuses as fathom_film_write(). */
FATHOM_API fathom_status fathom_write_check(fathom_context *context, const char *path,
                                            const fathom_write_options *options);
/* FATHOM_BAD_USAGE when the format of `path` does not hold so many pixels. */
FATHOM_API fathom_status fathom_write_check_size(fathom_context *context, const char *path, uint32_t width,
                                                 uint32_t height);
/* True when the view is the built-in sRGB: neither a config ($OCIO counts) nor another display or view is
 * named.
 */
FATHOM_API bool fathom_write_is_srgb(const fathom_write_options *options);
/* True when writing there starts the image helper; false for unknown extensions. */
FATHOM_API bool fathom_write_needs_helper(const char *path, const fathom_write_options *options);

/* The format follows the extension: .exr (scene-linear, all channels), .png, .jpg, .jpeg, .tif, .tiff (8-bit,
 * through the view). $SOURCE_DATE_EPOCH, seconds since 1970, is the date in the file where it is set;
 * FATHOM_BAD_USAGE when it is no such number. The file appears whole or not at all. */
FATHOM_API fathom_status fathom_film_write(fathom_context *context, const fathom_film *film, const char *path,
                                           const fathom_write_options *options);
/* All channels as uncompressed, scene-linear EXR of 32-bit values, whatever the extension, with hardly any
 * memory: for pixels whose own file cannot be written. The file appears whole or not at
 * all. FATHOM_OUT_OF_RESOURCES. */
FATHOM_API fathom_status fathom_film_write_plain(fathom_context *context, const fathom_film *film,
                                                 const char *path);
/* Saves the pixels of a film whose own file `path` cannot be written: as fathom_film_write_plain(), next to
 * `path`, or else in the working folder, in $TMPDIR or in /tmp. "out.png" becomes "out.rescue.exr", or the
 * first of "out.rescue-2.exr"… that is not there yet. `saved` gets the path, cut to `size` bytes; PATH_MAX
 * holds all. FATHOM_OUT_OF_RESOURCES: there is no such place, and `saved` is "". */
FATHOM_API fathom_status fathom_film_rescue(fathom_context *context, const fathom_film *film,
                                            const char *path, char *saved, size_t size);
/* Starts the image helper in the background, so that the first write does not wait for it. EXR, and PNG in
 * the built-in sRGB view, do without it. The helper is a separate process that runs OpenImageIO and
 * OpenColorIO. It ends with this process; if it ends earlier, only one call fails. */
FATHOM_API void fathom_image_prefetch(void);
/* The helper's libraries, "OpenImageIO 2.4.7.1, OpenColorIO 2.1.2", cut to `size` bytes; waits for its start.
 * FATHOM_OUT_OF_RESOURCES, with the reason, when it is missing or has ended. */
FATHOM_API fathom_status fathom_image_libraries(fathom_context *context, char *out, size_t size);

/* ---- reading ---- */

typedef struct fathom_image fathom_image;

/* Reads every channel in the file's order: unsigned 32-bit channels as ids, the others as float (8- and
 * 16-bit integers as fractions of their maximum), without any change of colour or alpha. Release with
 * fathom_image_destroy(). FATHOM_BAD_INPUT when the file is missing or is no image. */
FATHOM_API fathom_status fathom_image_read(fathom_context *context, const char *path,
                                           const fathom_image **out);
FATHOM_API void fathom_image_destroy(const fathom_image *image);

/* width or height may be NULL. */
FATHOM_API void fathom_image_size(const fathom_image *image, uint32_t *width, uint32_t *height);
/* The name of a channel, by its place in the file; NULL past the last. Valid as long as the image. */
FATHOM_API const char *fathom_image_channel_name(const fathom_image *image, size_t index);
/* One channel by its name: value (x, y) is (y * width + x) * *stride bytes from the first, top row first.
 * NULL when the image has no such channel, or one of the other type. Valid as long as the image. */
FATHOM_API const float *fathom_image_channel(const fathom_image *image, const char *name, size_t *stride);
FATHOM_API const uint32_t *fathom_image_channel_id(const fathom_image *image, const char *name,
                                                   size_t *stride);

/* ---- comparing ---- */

typedef struct fathom_image_difference {
    size_t size;
    double largest;      /* of one value; infinite where only one of the two is a finite number */
    uint32_t x, y;       /* where that is */
    const char *channel; /* in which; the first image's. "": the two are equal */
    double rmse;         /* root mean square over all values */
    uint64_t pixels;     /* with a value that differs by more than the tolerance */
} fathom_image_difference;

/* Compares all channels as stored. Equal infinities and two NaN do not differ. FATHOM_CHECK_FAILED when the
 * two have not the same size, crop and channels: the message says which. tolerance: >= 0. */
FATHOM_API fathom_status fathom_image_compare(fathom_context *context, const fathom_image *a,
                                              const fathom_image *b, double tolerance,
                                              fathom_image_difference *out);

/* Pixels per degree of visual angle: a 4K screen 0.7 m wide, seen from 0.7 m; and the limits. */
#define FATHOM_FLIP_PPD 67.0
#define FATHOM_FLIP_PPD_LEAST 1.0
#define FATHOM_FLIP_PPD_MOST 500.0

typedef struct fathom_flip {
    size_t size;
    double mean;        /* over all pixels, [0,1] */
    uint64_t nonfinite; /* pixels that are not finite in one of the two: each counts as 1 */
} fathom_flip;

/* FLIP, the visible difference when alternating between two images on a screen (Andersson et al., 2020), on
 * their sRGB values. Values of .exr, .hdr and .pfm files are taken as linear, those of other files as sRGB.
 * FATHOM_CHECK_FAILED as fathom_image_compare(); FATHOM_BAD_INPUT without the channels R, G and B;
 * FATHOM_BAD_USAGE when ppd is out of range. */
FATHOM_API fathom_status fathom_image_flip(fathom_context *context, const fathom_image *a,
                                           const fathom_image *b, double ppd, fathom_flip *out);

#ifdef __cplusplus
}
#endif
#endif
