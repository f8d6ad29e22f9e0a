/* Lookups, compiled for each instruction set; see base/kernel.h. */
#pragma once

#include "texture/cache.h"

typedef struct texture_kernels {
    /* texture_lookup() */
    void (*look_up)(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]);
    /* One texel of a level. False when the image is broken. */
    bool (*texel)(texture_cache *cache, const cache_slot *slot, unsigned level, uint32_t x, uint32_t y,
                  float rgba[4]);
} texture_kernels;

const texture_kernels *texture_kernels_best(void);
/* The kernels that this processor supports, from the simplest to the best; NULL past the last. */
const texture_kernels *texture_kernels_at(unsigned index);
