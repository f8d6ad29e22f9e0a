/* From channels as the film holds them to rows of interleaved pixels as files do. */
#ifndef IMAGE_PACK_H
#define IMAGE_PACK_H

#include "image/helper/module.h"
#include "image/srgb.h"

typedef struct image_packing {
    const image *img;
    const image_storage *storage; /* of each of its channels */
    size_t pixel_bytes;
    /* 8-bit files only: */
    float gain;             /* 2^exposure */
    const srgb_codes *srgb; /* of the built-in view */
} image_packing;

size_t pack_storage_size(image_storage storage);

/* Row y as it is. */
void pack_row(const image_packing *packing, uint32_t y, unsigned char *out);

/* Row y of R, G, B and perhaps A, in sRGB, as bytes. */
void pack_row_srgb(const image_packing *packing, uint32_t y, unsigned char *out);

/* Row y as a view takes it: 4 · width finite floats. */
void pack_row_for_view(const image_packing *packing, uint32_t y, float *rgba);
/* And what the view made of it, as bytes. */
void pack_row_from_view(const image_packing *packing, uint32_t y, const float *rgba, unsigned char *out);

#endif
