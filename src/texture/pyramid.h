/* An image as mip-mapped tiles: where each texel lies, and how the levels are made. */
#ifndef TEXTURE_PYRAMID_H
#define TEXTURE_PYRAMID_H

#include "base/status.h"
#include "image/helper/module.h"

#define PYRAMID_LEVELS 17u
#define PYRAMID_TILE IMAGE_TILE
#define PYRAMID_TILE_TEXELS (PYRAMID_TILE * PYRAMID_TILE)
/* Memory is taken and dropped in chunks of this size; larger levels begin with one. A chunk holds whole
 * tiles. The kernel brings in as much around a page that is missing. */
#define PYRAMID_CHUNK ((uint64_t)1 << PYRAMID_CHUNK_SHIFT)
#define PYRAMID_CHUNK_SHIFT 16u

/* Texel (x, y) of a level is the one of index (y / 64 * across + x / 64) * 64² + y % 64 * stride + x % 64. */
typedef struct pyramid_level {
    uint64_t offset; /* of its first texel, in bytes; in the tail from its begin until it is placed */
    uint32_t width, height;
    uint32_t across, stride;
    unsigned shift; /* a texel has 2^shift bytes */
    image_texel type;
} pyramid_level;

/* Levels that fit in a tile lie together, as plain rows: the tail. It and each level before it have places of
 * their own, in whole chunks: part `tail` is the tail, and the others are the levels of their number. */
typedef struct pyramid {
    unsigned channels;    /* 1, or 4 */
    unsigned count, tail; /* levels; the first of the tail */
    uint64_t tail_bytes;
    pyramid_level levels[PYRAMID_LEVELS];
} pyramid;

/* first: the type of level 0; other: that of the others. */
void pyramid_plan(pyramid *p, uint32_t width, uint32_t height, unsigned channels, image_texel first,
                  image_texel other);

/* Bytes of a part. */
uint64_t pyramid_part_bytes(const pyramid *p, unsigned part);
/* Says where a part lies; once for each. */
void pyramid_place(pyramid *p, unsigned part, uint64_t offset);

/* The colours that numbers stand for. */
typedef struct pyramid_decoding {
    unsigned sent_channels; /* 1 to 4; 2 is grey and alpha */
    image_texel sent;
    bool srgb;
    const float *color, *alpha; /* of 256 or 65536 integers; NULL for half and float */
} pyramid_decoding;

/* Tables of the integers of a type; `srgb` NULL: linear. */
void pyramid_fill_table(float *table, image_texel type, bool srgb);

/* `count` texels as they were sent to what level 0 keeps, and to floats of p->channels each. */
void pyramid_decode(const pyramid *p, const pyramid_decoding *d, const void *sent, size_t count,
                    float *linear);
void pyramid_keep(const pyramid *p, const pyramid_level *level, const pyramid_decoding *d, const void *sent,
                  const float *linear, size_t count, void *kept);
/* The first number that is not finite, of `count`; `count` if there is none. */
size_t pyramid_find_bad(const float *linear, size_t count);

/* Makes all levels from the rows of level 0, in order. Each texel is the mean of the area that it covers in
 * the level before, so the mean of each level is that of the image. */
typedef bool (*pyramid_write)(void *user, uint64_t offset, const void *bytes, size_t size);
typedef struct pyramid_builder pyramid_builder;
/* NULL without memory. */
pyramid_builder *pyramid_builder_open(const pyramid *p, const pyramid_decoding *d, pyramid_write write,
                                      void *user);
/* False when `write` was, or when a number is not finite: then *bad, in [0, width × channels), else SIZE_MAX.
 */
bool pyramid_builder_row(pyramid_builder *b, const void *sent, size_t *bad);
/* Ends it. The mean of the rows, and the smallest alpha. */
void pyramid_builder_close(pyramid_builder *b, float mean[4], float *least_alpha);

#endif
