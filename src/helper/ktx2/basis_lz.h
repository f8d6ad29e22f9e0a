/* BasisLZ: blocks of ETC1S, which are pairs of indices into two code books (KTX 2.0 specification, appendices
 * "BasisLZ Global Data" and "BasisLZ/ETC1S Bitstream Specification"). */
#pragma once

#include "helper/ktx2/huffman.h"
#include "image/helper/module.h"

typedef struct lz_endpoint {
    uint8_t color[3]; /* five bits each */
    uint8_t table;    /* of modifiers */
} lz_endpoint;

typedef struct lz_selector {
    uint8_t rows[4]; /* two bits a texel, the first texel lowest */
} lz_selector;

/* The parts that all slices of a file share. */
typedef struct lz_book {
    lz_endpoint *endpoints;
    lz_selector *selectors;
    uint32_t endpoint_count, selector_count, history; /* selectors that a slice remembers */
    huffman predictions, deltas, selector_codes, runs;
} lz_book;

/* Bytes that belong to one image: `flags` and the places of its slices in the image's level. */
typedef struct lz_image {
    uint32_t flags, color_at, color_size, alpha_at, alpha_size;
} lz_image;

/* Reads the global data, of a file with one layer and one face. *out is valid, and to be released, whatever
 * the result. `first`: the image of level 0. */
fathom_status lz_book_open(const uint8_t *global, size_t size, uint32_t level_count, lz_book *out,
                           lz_image *first, image_message *why);
void lz_book_close(lz_book *book);

/* A slice that is being decoded, from the top. */
typedef struct lz_slice lz_slice;

/* The bytes and the book stay the caller's. NULL when out of memory. */
lz_slice *lz_slice_open(const lz_book *book, const uint8_t *bytes, size_t size, uint32_t blocks_across);
void lz_slice_close(lz_slice *slice);

/* Decodes the next row of blocks to four rows of 4 × blocks_across texels, of three bytes of colour in four.
 * False if the data is broken. */
bool lz_slice_next(lz_slice *slice, uint8_t *texels);
