/* The least and the largest value of an image over parts of it. */
#pragma once

#include "texture/texture.h"

/* Ranges of one channel, at level 0. */
typedef struct texture_ranges texture_ranges;

/* Decodes the image. *out is NULL for a mip-mapped file, whose tiles are read only when lookups need them.
 * Release with texture_ranges_free(), which takes NULL. */
fathom_status texture_ranges_find(texture_cache *cache, fathom_context *context, fathom_id texture,
                                  unsigned channel, texture_ranges **out);
void texture_ranges_free(texture_ranges *r);

/* Bounds of all lookups without a footprint at low <= (u, v) <= high; of the whole image if these are not
 * finite. They may be wider than necessary. If both are 0 or both 1, so is each lookup; others may exceed
 * them by a relative rounding error of 2^-22. */
typedef struct texture_range {
    float least, most;
} texture_range;
texture_range texture_range_over(const texture_ranges *r, const float low[2], const float high[2]);
