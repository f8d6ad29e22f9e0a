/* The interface between C and the C++ libraries OpenImageIO and OpenColorIO. fathom_image.so implements it
 * for the image helper, and image_calls for the library. No call throws: each returns a status, with the
 * reason in `message`. */
#pragma once

#include "image/image.h"

/* Increases with every change of this file: a module of another build is refused before any call. */
#define IMAGE_MODULE_VERSION 14
#define IMAGE_MODULE_SYMBOL "fathom_image_module"

typedef struct image_message {
    char text[1024];
} image_message;

typedef enum image_format { IMAGE_EXR, IMAGE_PNG, IMAGE_JPEG, IMAGE_TIFF } image_format;

typedef enum image_texel { IMAGE_TEXEL_U8, IMAGE_TEXEL_U16, IMAGE_TEXEL_HALF, IMAGE_TEXEL_FLOAT } image_texel;

static inline size_t image_texel_size(image_texel texel) {
    return texel == IMAGE_TEXEL_U8 ? 1 : texel == IMAGE_TEXEL_FLOAT ? 4 : 2;
}

/* A file to write. Its bytes go to `file` in order, or to `descriptor` by offset, which the writer closes.
 * `path` is for messages. After the call only `file` and `descriptor` are used. */
struct file_writer; /* base/file.h */

typedef struct image_target {
    const char *path;
    struct file_writer *file;
    int descriptor;
    image_format format;
    unsigned threads;
    bool srgb;         /* mark the pixels as sRGB */
    const char *date;  /* "2026:11:22 16:45:33", for formats that hold one; NULL: now */
    bool mipmapped;    /* only TIFF: tiles of IMAGE_TILE; smaller levels follow */
    image_texel texel; /* bytes, unless the file is mip-mapped */
    const image *img;  /* sizes, texts, names of channels; pixels are not used */
} image_target;

/* A display and view of a config. NULL: the built-in config, the config's default display, the display's
 * view. */
typedef struct image_view_request {
    const char *config, *display, *view;
} image_view_request;

typedef struct image_writer image_writer;
typedef struct image_view image_view;

typedef struct image_writer_calls {
    fathom_status (*open)(const image_target *target, image_writer **out, image_message *message);
    /* Writes the next `count` rows: pixels of interleaved channels, all of the same type. */
    fathom_status (*rows)(image_writer *writer, uint32_t count, const void *pixels, image_message *message);
    /* Ends the writer, even on failure; `finish` false abandons the file. */
    fathom_status (*close)(image_writer *writer, bool finish, image_message *message);
} image_writer_calls;

/* ---- textures: images that are read in parts ---- */

/* The tiles of mip-mapped files that are read in place lie within tiles of this size. */
#define IMAGE_TILE 64u

/* The content comes from `path`. If path is NULL, it comes from `descriptor`, which the reader closes. */
typedef struct image_texture_request {
    const char *path;
    int descriptor;
    const char *config; /* of OpenColorIO; NULL: the built-in one */
    const char
        *space; /* texels are converted from this space to linear Rec.709; NULL: they are not converted */
    uint64_t most_side, most_texels; /* larger images are rejected */
    unsigned threads;
    unsigned helpers; /* processes that the library may choose from; 0: one */
} image_texture_request;

/* The entry ImageDescription of a mip-mapped file that `fathom texture` wrote: how its numbers are encoded,
 * and so how they were averaged. */
#define IMAGE_SAYS_LINEAR "fathom:transfer=linear"
#define IMAGE_SAYS_SRGB "fathom:transfer=sRGB"

/* How the file says that its colours are encoded. Most files do not say. */
typedef enum image_transfer {
    IMAGE_TRANSFER_UNKNOWN,
    IMAGE_TRANSFER_LINEAR,
    IMAGE_TRANSFER_SRGB,
    IMAGE_TRANSFER_OTHER
} image_transfer;

typedef struct image_texture_info {
    uint32_t width, height;
    uint32_t channels; /* 1: grey; 2: grey, alpha; 3: R, G, B; 4: R, G, B, alpha; not premultiplied */
    image_texel sent;  /* the type of the texels that read() returns */
    image_texel kept;  /* the type that keeps its precision */
    uint32_t band;     /* read() takes rows in multiples of this, or up to the end */
    bool
        mipmapped; /* tiles at most IMAGE_TILE wide; each level half the size of the previous, rounded down */
    bool integers; /* the file has integers, also where `sent` are floats, as for those of 32 bits */
    char format[32]; /* "png", "openexr" */
    image_transfer transfer;
} image_texture_info;

/* Texels [x0, x1) × [y0, y1). Level 0 unless the file is mip-mapped; then x0 and y0 are multiples of
 * IMAGE_TILE, and x1 and y1 too, or the level ends there. Otherwise whole rows, in order from the top. */
typedef struct image_region {
    uint32_t level, x0, y0, x1, y1;
} image_region;

typedef struct image_texture image_texture;

typedef struct image_texture_calls {
    fathom_status (*open)(const image_texture_request *request, image_texture **out, image_texture_info *info,
                          image_message *message);
    /* Reads interleaved texels; `bytes` is the size of the region. */
    fathom_status (*read)(image_texture *texture, const image_region *region, void *texels, size_t bytes,
                          image_message *message);
    void (*close)(image_texture *texture);
} image_texture_calls;

typedef struct image_module {
    unsigned version;
    image_writer_calls writer; /* for JPEG and TIFF */

    fathom_status (*read)(const char *path, unsigned threads, const image **out, image_message *message);
    void (*release)(const image *img);

    /* *srgb: whether the result of the view is sRGB. */
    fathom_status (*view_open)(const image_view_request *request, image_view **out, bool *srgb,
                               image_message *message);
    /* Works in place on `count` pixels of four floats, all finite. The result does not depend on the number
     * of threads. */
    fathom_status (*view_apply)(const image_view *view, unsigned threads, float *rgba, size_t count,
                                image_message *message);
    void (*view_close)(image_view *view);
    /* *out: a hash of the files, such as LUTs, that the config names for a view. If space is not NULL, for
     * textures of this color space instead. 0: the config names none. */
    fathom_status (*view_files)(const image_view_request *request, const char *space, uint64_t *out,
                                image_message *message);

    image_texture_calls texture;
    /* Begins the next level of a mip-mapped file, after all rows of the previous one. Each rows() call for it
     * has a multiple of IMAGE_TILE rows, except the last one. */
    fathom_status (*writer_level)(image_writer *writer, uint32_t width, uint32_t height,
                                  image_message *message);

    const char *libraries; /* "OpenImageIO 2.4.7.1, OpenColorIO 2.1.2" */
} image_module;

#ifdef __cplusplus
fathom_status image_view_open(const image_view_request *request, image_view **out, bool *srgb,
                              image_message *message) noexcept;
fathom_status image_view_apply(const image_view *view, unsigned threads, float *rgba, size_t count,
                               image_message *message) noexcept;
void image_view_close(image_view *view) noexcept;
fathom_status image_view_files(const image_view_request *request, const char *space, uint64_t *out,
                               image_message *message) noexcept;
extern const image_texture_calls image_texture_table;
#endif
