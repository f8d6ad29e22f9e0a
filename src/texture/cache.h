/* The parts of a texture cache that lookups read. */
#ifndef TEXTURE_CACHE_H
#define TEXTURE_CACHE_H

#include "texture/store.h"
#include "texture/texture.h"

/* What several textures may share. */
typedef struct cache_image {
    const fathom_texture *texture; /* the first of them */
    pyramid plan;
    image_texture_info info;
    pyramid_decoding decoding;
    image_texture *source;      /* a mip-mapped file that is open; guarded by the lock */
    pthread_mutex_t lock;       /* held while it is decoded, whole or in parts */
    bool decoded, broken;       /* atomic */
    float mean[4], least_alpha; /* once it is decoded */
} cache_image;

/* A texture. */
typedef struct cache_slot {
    cache_image *image;
    fathom_wrap wrap_u, wrap_v;
    fathom_texture_filter filter;
} cache_slot;

#define CACHE_OPEN 64 /* mip-mapped files that are open at once, at most */

struct texture_cache {
    const struct texture_kernels *kernels;
    const char *config;        /* of OpenColorIO; NULL: the built-in one */
    unsigned threads, helpers; /* processes that decode at once */
    size_t count, image_count;
    cache_slot *slots;
    cache_image *images;
    store store;
    float *tables[2][2];  /* of 8 and 16 bits; linear and sRGB; NULL: not needed */
    pthread_mutex_t lock; /* guards the members below; taken while an image's is held, never before one */
    cache_image *open[CACHE_OPEN];
    unsigned next_open;
    fathom_status status; /* of the first failure */
    const char *failed;   /* the image's name */
    image_message why;
};

/* Has the store hold a chunk with texels of the image; decodes the image if need be. False when it is broken.
 * Any thread. */
bool cache_fill(texture_cache *cache, cache_image *img, uint64_t chunk);
/* The same of up to four texels of `size` bytes, which that many lookups are about to ask for. at[i] is where
 * texel i may be read: in the store, or in `copy`. */
typedef struct cache_copy {
    _Alignas(16) unsigned char bytes[2048]; /* two rows of a tile and more, of texels up to 16 bytes */
} cache_copy;
bool cache_fetch(texture_cache *cache, cache_image *img, const uint64_t *places, unsigned count, size_t size,
                 unsigned lookups, cache_copy *copy, const unsigned char **at);

/* Opens the image's file, or bytes, in the helper. On failure `why` says why; "": memory is lacking. */
fathom_status cache_open_source(const texture_cache *cache, const fathom_texture *t, image_texture **out,
                                image_texture_info *info, image_message *why);
/* Closes the file that an image keeps open, if any. */
void cache_close_source(cache_image *img);

/* For messages. */
static inline const char *cache_name(const fathom_texture *t) {
    return t->name ? t->name : t->file ? t->file : "(texture in memory)";
}

#endif
