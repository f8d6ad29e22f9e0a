#include "texture/cache.h"

#include "base/kernel.h"

KERNEL_BEST(texture_kernels)

void texture_lookup(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]) {
    cache->kernels->look_up(cache, q, rgba);
}
