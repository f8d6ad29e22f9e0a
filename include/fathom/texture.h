/* Images that scenes use as textures. */
#ifndef FATHOM_TEXTURE_H
#define FATHOM_TEXTURE_H

#include <fathom/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Color space of an image. Alpha is always linear. */
typedef enum fathom_color_space {
    FATHOM_COLOR_AUTO, /* maps of numbers and directions (roughness, normals): linear. Maps of colours: as the
                          image says, which KTX 2.0 files, PNGs of gamma 1 and files of
                          fathom_texture_write() do; else linear for half and float, and sRGB for integers */
    FATHOM_COLOR_SRGB, /* colours of Rec.709 through the curve of IEC 61966-2-1 */
    FATHOM_COLOR_LINEAR, /* linear Rec.709, or data: the numbers are used unchanged */
    FATHOM_COLOR_NAMED   /* color_space_name, a space of the OpenColorIO config */
} fathom_color_space;

/* What lies outside [0,1). */
typedef enum fathom_wrap {
    FATHOM_WRAP_REPEAT,
    FATHOM_WRAP_MIRROR, /* every other repetition is mirrored */
    FATHOM_WRAP_CLAMP   /* the texels of the edge are repeated */
} fathom_wrap;

typedef enum fathom_texture_filter {
    FATHOM_TEXTURE_NEAREST,   /* the nearest texel of level 0 */
    FATHOM_TEXTURE_LINEAR,    /* bilinear in level 0 */
    FATHOM_TEXTURE_TRILINEAR, /* bilinear in the two mip levels whose texels are about as wide as the
                                 footprint, and linear between the two */
    FATHOM_TEXTURE_STOCHASTIC /* one of the up to eight texels of FATHOM_TEXTURE_TRILINEAR, chosen at random
                                 by weight, from a hash of the position. Not for bump maps */
} fathom_texture_filter;

/* Limits of an image. */
#define FATHOM_TEXTURE_SIDE 65536u                /* texels on a side */
#define FATHOM_TEXTURE_TEXELS (UINT64_C(1) << 32) /* in all */

/* An image and how it is looked up. (u, v) = (0, 0) is the upper left corner of the image and (1, 1) the
 * lower right one. KTX 2.0, and any format that OpenImageIO reads; its content decides, not its name. */
typedef struct fathom_texture {
    size_t size;
    const char *file;  /* a path; NULL: `bytes` holds the image */
    const void *bytes; /* the content of an image file; a PPM header makes one of plain pixels: "P6 W H 255\n"
                          and R G B bytes, top row first */
    size_t byte_count;
    const char
        *mime; /* the declared type of `bytes`, "image/png"; NULL: none. A warning says if it is wrong */
    const char *name;               /* for messages; NULL: the file */
    fathom_color_space color_space; /* default FATHOM_COLOR_AUTO */
    const char *color_space_name;   /* of FATHOM_COLOR_NAMED */
    fathom_wrap wrap_u, wrap_v;     /* default FATHOM_WRAP_REPEAT */
    fathom_texture_filter filter;   /* default FATHOM_TEXTURE_TRILINEAR */
} fathom_texture;

FATHOM_DEFAULT(fathom_texture)

/* Copies texts and bytes. Equal textures get one id. FATHOM_BAD_INPUT when the file is missing, unreadable or
 * empty. Its contents are checked before anything is rendered. */
FATHOM_API fathom_status fathom_scene_add_texture(fathom_scene *scene, const fathom_texture *texture,
                                                  fathom_id *out);

/* Writes the image as a tiled TIFF file with all mip levels. A render reads single tiles of such a file.
 * Texels keep the type and the color space of the image; a named space is converted to linear Rec.709. The
 * levels are averages of linear values, so maps of numbers and directions need FATHOM_COLOR_LINEAR. Alpha
 * that is 1 everywhere is omitted. FATHOM_BAD_USAGE unless `path` ends in .tx, .tif or .tiff, and the config
 * has the named color space; else as fathom_scene_add_texture() and fathom_film_write(). */
FATHOM_API fathom_status fathom_texture_write(fathom_context *context, const fathom_texture *texture,
                                              const char *path);

#ifdef __cplusplus
}
#endif
#endif
