/* Lookups in the textures of a scene.
 *
 * The image helper decodes an image when it is first looked up, into mip-mapped tiles. A limit applies to the
 * tiles in memory; the others are in a temporary file without a name. Results do not depend on the limit, on
 * threads, or on the order of lookups. */
#pragma once

#include "base/status.h"

#include <fathom/texture.h>

typedef struct texture_cache texture_cache;

/* Reads the header of each texture's image. limit: bytes of tiles in memory. FATHOM_BAD_INPUT names the file
 * that is not an image, is too large, has no colours or has an unknown colour space. `scene` and `context`
 * have to outlive the cache. Release with texture_cache_close(), which takes NULL. */
fathom_status texture_cache_open(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                 texture_cache **out);
/* The same, but *bytes is only the memory that the tiles would take at most. */
fathom_status texture_cache_measure(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                    uint64_t *bytes);
/* The same of an open cache; NULL: 0. */
uint64_t texture_cache_bytes(const texture_cache *cache);
/* The most memory that tiles have taken so far. No lookup may run at the same time. */
uint64_t texture_cache_peak(const texture_cache *cache);
/* A hash of the files, such as LUTs, that the config in $OCIO names for the color spaces of the scene's
 * textures; 0 if it names none. If the config cannot be read, texture_cache_open() reports it. */
uint64_t texture_color_files(const fathom_scene *scene);
void texture_cache_close(texture_cache *cache);

/* Number of lookups in one block. */
#define TEXTURE_BLOCK 16
typedef struct texture_queries {
    unsigned count;
    fathom_id texture[TEXTURE_BLOCK];
    float u[TEXTURE_BLOCK], v[TEXTURE_BLOCK]; /* finite */
    float width[TEXTURE_BLOCK];               /* of the footprint, in u and v; 0: a point */
} texture_queries;

/* Returns linear Rec.709 or data, and alpha, which is 1 for images without alpha. Thread-safe. A broken
 * texture gives (1, 0, 1, 1), and texture_cache_check() returns the reason. */
void texture_lookup(texture_cache *cache, const texture_queries *queries, float rgba[4][TEXTURE_BLOCK]);

/* FATHOM_OK, or the failure of an earlier lookup: data of an image that cannot be decoded, texels that are
 * not finite, a full disk. Call it before a result of lookups is used. */
fathom_status texture_cache_check(texture_cache *cache, fathom_context *context);

/* Width and height of the image in texels. */
void texture_size(const texture_cache *cache, fathom_id texture, uint32_t *width, uint32_t *height);
/* The largest value of each colour among all texels, linear, or an upper bound of it: 1 for an image of
 * integers. Reads all other images as a whole. */
fathom_status texture_brightest(texture_cache *cache, fathom_context *context, fathom_id texture,
                                float rgb[3]);
/* *out: whether alpha is 1 everywhere; always false for a mip-mapped file with alpha. Decodes the image if it
 * has alpha. */
fathom_status texture_is_opaque(texture_cache *cache, fathom_context *context, fathom_id texture, bool *out);
