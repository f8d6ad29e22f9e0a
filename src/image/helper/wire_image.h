/* An image's description in the shared memory: everything but its pixels. */
#ifndef IMAGE_HELPER_WIRE_IMAGE_H
#define IMAGE_HELPER_WIRE_IMAGE_H

#include "image/helper/module.h"
#include "image/helper/wire.h"

/* storage: of each channel; NULL: none is told. */
void wire_put_image(wire_buffer *b, const image *img, const image_storage *storage);

/* The image's arrays are to be released with wire_image_free(); texts lie in the memory, and pixels are NULL.
 * False when it is not whole or memory runs out. */
typedef struct wire_image {
    image img;
    image_channel *channels;
    image_storage *storage;
    image_attribute *attributes;
    double *numbers;
} wire_image;

bool wire_take_image(wire_cursor *c, wire_image *out);
void wire_image_free(wire_image *w);

/* Planes of a read image follow its description, each of width × height values of four bytes, from a multiple
 * of this. */
#define WIRE_ALIGNED 64

#endif
