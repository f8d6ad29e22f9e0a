/* An image as mip-mapped tiles: the layout of texels, and the computation of levels. */
#pragma once

#include "base/status.h"
#include "image/helper/module.h"

#define PYRAMID_LEVELS 17u
#define PYRAMID_TILE IMAGE_TILE
#define PYRAMID_TILE_TEXELS (PYRAMID_TILE * PYRAMID_TILE)
/* Memory is mapped and evicted in chunks of this size. Each part begins with a new chunk. A chunk holds whole
 * tiles. The size is that of Linux's fault-around, which maps this many bytes around a missing page. */
#define PYRAMID_CHUNK ((uint64_t)1 << PYRAMID_CHUNK_SHIFT)
#define PYRAMID_CHUNK_SHIFT 16u

/* Texel (x, y) of a level has the index (y / 64 * across + x / 64) * 64² + y % 64 * stride + x % 64. */
typedef struct pyramid_level {
    uint64_t offset; /* of its first texel, in bytes; in the part until pyramid_place() adds the part's own */
    uint32_t width, height;
    uint32_t across, stride;
    unsigned shift; /* a texel has 2^shift bytes */
    image_texel type;
} pyramid_level;

/* The tail holds all levels that fit in a tile, one after another, as plain rows. The tail, and each level
 * before it, is a part: it takes whole chunks, with a position of its own. Part number `tail` is the tail; a
 * smaller number is that of a level. */
typedef struct pyramid {
    unsigned channels;    /* 1, or 4 */
    unsigned count, tail; /* number of levels; the first level of the tail */
    uint64_t tail_bytes;
    pyramid_level levels[PYRAMID_LEVELS];
} pyramid;

/* first: the type of level 0; other: the type of all other levels. */
void pyramid_plan(pyramid *p, uint32_t width, uint32_t height, unsigned channels, image_texel first,
                  image_texel other);

/* Bytes of a part. */
uint64_t pyramid_part_bytes(const pyramid *p, unsigned part);
/* Sets the position of a part. Call it once for each part. */
void pyramid_place(pyramid *p, unsigned part, uint64_t offset);

/* How to convert stored numbers to linear values. */
typedef struct pyramid_decoding {
    unsigned sent_channels; /* 1 to 4; 2 is grey and alpha */
    image_texel sent;
    bool srgb;
    const float *color, *alpha; /* tables for 256 or 65536 integers; NULL for half and float */
} pyramid_decoding;

/* Fills the table for the integers of a type: decoded from sRGB if `srgb`, else linear. */
void pyramid_fill_table(float *table, image_texel type, bool srgb);

/* pyramid_decode() converts `count` texels from the helper to p->channels floats each. pyramid_keep()
 * converts them to the level's type: to integers from `sent`, to half and float from `linear`. */
void pyramid_decode(const pyramid *p, const pyramid_decoding *d, const void *sent, size_t count,
                    float *linear);
void pyramid_keep(const pyramid *p, const pyramid_level *level, const pyramid_decoding *d, const void *sent,
                  const float *linear, size_t count, void *kept);
/* The index of the first of `count` numbers that is not finite; `count` if all are finite. */
size_t pyramid_find_bad(const float *linear, size_t count);

/* Makes all levels from the rows of level 0, in order. Each texel is the mean of the area that it covers in
 * the level before, so all levels have the mean of the image. */
typedef bool (*pyramid_write)(void *user, uint64_t offset, const void *bytes, size_t size);
typedef struct pyramid_builder pyramid_builder;
/* NULL when out of memory. */
pyramid_builder *pyramid_builder_open(const pyramid *p, const pyramid_decoding *d, pyramid_write write,
                                      void *user);
/* False if `write` returned false (*bad is SIZE_MAX), or if a number is not finite (*bad is its index, in [0,
 * width × channels)). */
bool pyramid_builder_row(pyramid_builder *b, const void *sent, size_t *bad);
/* Releases the builder. Returns the smallest alpha. */
void pyramid_builder_close(pyramid_builder *b, float *least_alpha);
