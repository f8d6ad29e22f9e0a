/* From channels as the film holds them to rows of interleaved pixels as files do. */
#ifndef IMAGE_PACK_H
#define IMAGE_PACK_H

#include "image/module/module.h"
#include "image/srgb.h"

typedef struct image_packing {
    const image *img;
    const image_storage *storage; /* of each of its channels */
    size_t pixel_bytes;
    /* 8-bit files only: */
    float gain;             /* 2^exposure */
    const srgb_codes *srgb; /* of the built-in view; others are the module's */
    const image_module *module;
    const image_view *view;
} image_packing;

size_t pack_storage_size(image_storage storage);

/* Row y as it is. */
void pack_row(const image_packing *packing, uint32_t y, unsigned char *out);

/* Row y of R, G, B and perhaps A, in sRGB, as bytes. */
void pack_row_srgb(const image_packing *packing, uint32_t y, unsigned char *out);

/* The same through the view. `scratch` has room for 4 · width floats. */
fathom_status pack_row_through_view(const image_packing *packing, uint32_t y, float *scratch,
                                    unsigned char *out, image_message *message);

#endif
