/* The internals of a texture cache, for lookups and decoding. */
#pragma once

#include "texture/store.h"
#include "texture/texture.h"

/* An image, which several textures may share. */
typedef struct cache_image {
    const fathom_texture *texture; /* the first texture of the image */
    const fathom_place *place;     /* where the scene's file names it; NULL: not known */
    pyramid plan;
    image_texture_info info;
    pyramid_decoding decoding;
    image_texture *source; /* an open mip-mapped file; guarded by the lock */
    pthread_mutex_t lock;  /* held while the image or a part of it is decoded */
    bool decoded, broken;  /* atomic */
    float least_alpha;     /* valid once the image is decoded */
} cache_image;

/* A texture. */
typedef struct cache_slot {
    cache_image *image;
    fathom_wrap wrap_u, wrap_v;
    fathom_texture_filter filter;
} cache_slot;

#define CACHE_OPEN 64 /* maximum number of mip-mapped files open at the same time */

struct texture_cache {
    const struct texture_kernels *kernels;
    const char *config;        /* of OpenColorIO; NULL: the built-in one */
    unsigned threads, helpers; /* helpers: processes that decode in parallel */
    size_t count, image_count;
    uint64_t limit, bytes; /* of tiles in memory; of all tiles */
    cache_slot *slots;
    cache_image *images;
    store store;
    float *tables[2][2];  /* for 8 and 16 bits; linear and sRGB; NULL: not needed */
    pthread_mutex_t lock; /* guards the members below; lock order: an image's lock first, then this one */
    cache_image *open[CACHE_OPEN];
    unsigned next_open;
    fathom_status status;      /* of the first failure */
    const cache_image *failed; /* its image */
    image_message why;
};

/* Makes sure that the store has this chunk of the image; decodes the image if necessary. False if the image
 * is broken. Thread-safe. */
bool cache_fill(texture_cache *cache, cache_image *img, uint64_t chunk);
/* The same for up to four texels of `size` bytes, at byte offsets `places`. lookups: how many lookups of the
 * block are about to read them. at[i] is the address of texel i: in the store, or in `copy`. */
typedef struct cache_copy {
    _Alignas(16) unsigned char bytes[2048]; /* more than two rows of a tile, of texels up to 16 bytes */
} cache_copy;
bool cache_fetch(texture_cache *cache, cache_image *img, const uint64_t *places, unsigned count, size_t size,
                 unsigned lookups, cache_copy *copy, const unsigned char **at);

/* Opens the image's file, or its bytes, in the helper. On failure `why` has the reason; "": out of memory. */
fathom_status cache_open_source(const texture_cache *cache, const fathom_texture *t, image_texture **out,
                                image_texture_info *info, image_message *why);
/* Closes the file that an image keeps open, if any. */
void cache_close_source(cache_image *img);

/* For messages. */
static inline const char *cache_name(const fathom_texture *t) {
    return t->name ? t->name : t->file ? t->file : "(texture in memory)";
}

/* Lookups, compiled for each instruction set; see base/kernel.h. */
typedef struct texture_kernels {
    /* texture_lookup() */
    void (*look_up)(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]);
    /* One texel of a level. False when the image is broken. */
    bool (*texel)(texture_cache *cache, const cache_slot *slot, unsigned level, uint32_t x, uint32_t y,
                  float rgba[4]);
} texture_kernels;

const texture_kernels *texture_kernels_best(void);
