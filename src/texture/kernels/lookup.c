/* Texels by place and footprint. */
#include "base/kernel.h"
#include "texture/kernels.h"

#include <math.h>
#include <string.h>
#ifdef __F16C__
#include <immintrin.h>
#endif

/* R, G, B and alpha. */
typedef float rgba_f32 __attribute__((vector_size(16)));
typedef uint32_t rgba_u32 __attribute__((vector_size(16)));

#define INLINE static inline __attribute__((always_inline))

/* ---- texels ---- */

#ifdef __F16C__
INLINE float from_half(const uint16_t *n) { return _cvtsh_ss(*n); }

INLINE rgba_f32 from_halves(const uint16_t n[4]) { return _mm_cvtph_ps(_mm_loadl_epi64((const void *)n)); }
#else
/* Finite halves. Denormals are built by a subtraction, so that no operand is denormal as a float. */
INLINE rgba_f32 lifted_halves(rgba_u32 half) {
    const rgba_u32 magnitude = (half & 0x7fff) << 13, sign = (half & 0x8000) << 16;
    const rgba_u32 small = (rgba_u32)(magnitude < (1u << 23));
    const rgba_u32 normal = magnitude + (112u << 23), shifted = magnitude + (113u << 23);
    rgba_f32 lifted;
    memcpy(&lifted, &shifted, sizeof lifted);
    lifted -= 0x1p-14f;
    rgba_u32 bits;
    memcpy(&bits, &lifted, sizeof bits);
    bits = (bits & small) | (normal & ~small) | sign;
    rgba_f32 out;
    memcpy(&out, &bits, sizeof out);
    return out;
}

INLINE float from_half(const uint16_t *n) { return lifted_halves((rgba_u32){*n})[0]; }

INLINE rgba_f32 from_halves(const uint16_t n[4]) { return lifted_halves((rgba_u32){n[0], n[1], n[2], n[3]}); }
#endif

INLINE rgba_f32 grey(float value) { return (rgba_f32){value, value, value, 1}; }

typedef unsigned char rgba_u8 __attribute__((vector_size(4)));

/* `type`, `channels` and whether `color` is NULL are constants where this is inlined. NULL: linear; the
 * quotients are those of the table. */
INLINE rgba_f32 texel_at(const unsigned char *at, image_texel type, unsigned channels, const float *color,
                         const float *alpha) {
    switch (type) {
    case IMAGE_TEXEL_U8:
        if (!color) {
            rgba_u8 n;
            memcpy(&n, at, sizeof n);
            return __builtin_convertvector(n, rgba_f32) / 255.0f;
        }
        if (channels == 1) return grey(color[*at]);
        return (rgba_f32){color[at[0]], color[at[1]], color[at[2]], alpha[at[3]]};
    case IMAGE_TEXEL_U16: {
        const uint16_t *n = (const void *)at;
        if (channels == 1) return grey(color[*n]);
        return (rgba_f32){color[n[0]], color[n[1]], color[n[2]], alpha[n[3]]};
    }
    case IMAGE_TEXEL_HALF: {
        const uint16_t *n = (const void *)at;
        if (channels == 1) return grey(from_half(n));
        return from_halves(n);
    }
    case IMAGE_TEXEL_FLOAT: break;
    }
    const float *n = (const void *)at;
    if (channels == 1) return grey(*n);
    return (rgba_f32){n[0], n[1], n[2], n[3]};
}

/* ---- places ---- */

/* In [0, 1], whatever u is. */
INLINE float wrapped(float u, fathom_wrap mode) {
    float t = u;
    if (mode == FATHOM_WRAP_REPEAT) t = u - floorf(u);
    if (mode == FATHOM_WRAP_MIRROR) {
        t = u - 2 * floorf(0.5f * u);
        t = t > 1 ? 2 - t : t;
    }
    t = t > 0 ? t : 0;
    return t < 1 ? t : 1;
}

/* Two texels next to each other, the second of weight `share`. */
typedef struct pair {
    uint32_t first, second;
    float share;
} pair;

INLINE pair pair_at(float t, uint32_t size, fathom_wrap mode) {
    const float at = t * (float)size - 0.5f, low = floorf(at);
    const int32_t i = (int32_t)low, last = (int32_t)size - 1;
    const bool around = mode == FATHOM_WRAP_REPEAT;
    pair p = {.share = at - low};
    p.first = (uint32_t)(i >= 0 ? (i < last ? i : last) : (around ? last : 0));
    p.second = (uint32_t)(i < last ? i + 1 : (around ? 0 : last));
    return p;
}

/* Offsets of a column and of a row: a texel lies at the level's offset and both. */
INLINE uint64_t column_of(const pyramid_level *l, uint32_t x) {
    return (uint64_t)(x / PYRAMID_TILE * PYRAMID_TILE_TEXELS + x % PYRAMID_TILE) << l->shift;
}

INLINE uint64_t row_of(const pyramid_level *l, uint32_t y) {
    const uint64_t tiles = (uint64_t)(y / PYRAMID_TILE * l->across) * PYRAMID_TILE_TEXELS;
    return (tiles + y % PYRAMID_TILE * l->stride) << l->shift;
}

INLINE uint64_t place_of(const pyramid_level *l, uint32_t x, uint32_t y) {
    return l->offset + column_of(l, x) + row_of(l, y);
}

/* ---- filters ---- */

/* Chunks that the lookups of a block begin in; of two levels each. */
typedef struct block_chunks {
    unsigned count;
    uint64_t chunks[2 * TEXTURE_BLOCK];
} block_chunks;

typedef struct lookup {
    texture_cache *cache;
    const cache_slot *slot;
    float u, v; /* wrapped */
    unsigned level;
    float share;  /* of the next level */
    float chance; /* negative: none */
    bool broken;
    const block_chunks *block; /* NULL: it is alone */
} lookup;

/* The lookups of the block in a chunk, this one among them. */
static unsigned neighbours(const lookup *at, uint64_t chunk) {
    unsigned count = 0;
    for (unsigned i = 0; at->block && i < at->block->count; ++i) count += at->block->chunks[i] == chunk;
    return count ? count : 1;
}

/* Where the texels may be read. False: the image is broken. */
INLINE bool reachable(const lookup *look, const pyramid_level *l, const uint64_t *places, unsigned count,
                      cache_copy *copy, const unsigned char **at) {
    const store *s = &look->cache->store;
    unsigned used = STORE_USED;
    for (unsigned i = 0; i < count; ++i) {
        used &= store_state(s, places[i] >> PYRAMID_CHUNK_SHIFT);
        at[i] = s->bytes + places[i];
    }
    if (__builtin_expect(used == STORE_USED, 1)) return true;
    return cache_fetch(look->cache, look->slot->image, places, count, (size_t)1 << l->shift,
                       neighbours(look, places[0] >> PYRAMID_CHUNK_SHIFT), copy, at);
}

INLINE rgba_f32 between(const unsigned char *const at[4], const pair *x, const pair *y, image_texel type,
                        unsigned channels, const float *color, const float *alpha) {
    const rgba_f32 a = texel_at(at[0], type, channels, color, alpha);
    const rgba_f32 b = texel_at(at[1], type, channels, color, alpha);
    const rgba_f32 c = texel_at(at[2], type, channels, color, alpha);
    const rgba_f32 d = texel_at(at[3], type, channels, color, alpha);
    const rgba_f32 top = a + x->share * (b - a), low = c + x->share * (d - c);
    return top + y->share * (low - top);
}

/* Each type has its own loop-free code. */
#define BY_TYPE(call, type, channels)                                                                        \
    switch ((type)) {                                                                                        \
    case IMAGE_TEXEL_U8: return (channels) == 1 ? call(IMAGE_TEXEL_U8, 1) : call(IMAGE_TEXEL_U8, 4);         \
    case IMAGE_TEXEL_U16: return (channels) == 1 ? call(IMAGE_TEXEL_U16, 1) : call(IMAGE_TEXEL_U16, 4);      \
    case IMAGE_TEXEL_HALF: return (channels) == 1 ? call(IMAGE_TEXEL_HALF, 1) : call(IMAGE_TEXEL_HALF, 4);   \
    case IMAGE_TEXEL_FLOAT: break;                                                                           \
    }                                                                                                        \
    return (channels) == 1 ? call(IMAGE_TEXEL_FLOAT, 1) : call(IMAGE_TEXEL_FLOAT, 4)

static rgba_f32 bilinear(lookup *at, unsigned level) {
    cache_image *img = at->slot->image;
    const pyramid_level *l = &img->plan.levels[level];
    const pair x = pair_at(at->u, l->width, at->slot->wrap_u),
               y = pair_at(at->v, l->height, at->slot->wrap_v);
    const uint64_t left = l->offset + column_of(l, x.first), right = l->offset + column_of(l, x.second);
    const uint64_t top = row_of(l, y.first), low = row_of(l, y.second);
    const uint64_t p[4] = {left + top, right + top, left + low, right + low};
    const unsigned char *texels[4];
    cache_copy copy;
    if (!reachable(at, l, p, 4, &copy, texels)) {
        at->broken = true;
        return grey(0);
    }
    const float *color = img->decoding.color, *alpha = img->decoding.alpha;
    if (l->type == IMAGE_TEXEL_U8 && img->plan.channels == 4 && color == alpha)
        return between(texels, &x, &y, IMAGE_TEXEL_U8, 4, NULL, NULL);
#define CALL(type, channels) between(texels, &x, &y, type, channels, color, alpha)
    BY_TYPE(CALL, l->type, img->plan.channels);
#undef CALL
}

static rgba_f32 single(lookup *at, unsigned level, uint32_t x, uint32_t y) {
    cache_image *img = at->slot->image;
    const pyramid_level *l = &img->plan.levels[level];
    const uint64_t p = place_of(l, x, y);
    const unsigned char *from;
    cache_copy copy;
    if (!reachable(at, l, &p, 1, &copy, &from)) {
        at->broken = true;
        return grey(0);
    }
#define CALL(type, channels) texel_at(from, type, channels, img->decoding.color, img->decoding.alpha)
    BY_TYPE(CALL, l->type, img->plan.channels);
#undef CALL
}

static rgba_f32 nearest(lookup *at) {
    const pyramid_level *l = &at->slot->image->plan.levels[0];
    const uint32_t x = (uint32_t)(at->u * (float)l->width), y = (uint32_t)(at->v * (float)l->height);
    return single(at, 0, x < l->width ? x : l->width - 1, y < l->height ? y : l->height - 1);
}

/* Takes the second of two with probability `share`; *chance is then uniform in [0,1) anew. */
INLINE bool second_by(float *chance, float share) {
    const bool second = *chance < share;
    *chance = second ? *chance / share : (*chance - share) / (1 - share);
    return second;
}

static rgba_f32 by_chance(lookup *at) {
    float chance = at->chance;
    const pyramid_level *l = &at->slot->image->plan.levels[at->level];
    const pair x = pair_at(at->u, l->width, at->slot->wrap_u),
               y = pair_at(at->v, l->height, at->slot->wrap_v);
    const bool right = second_by(&chance, x.share), below = second_by(&chance, y.share);
    return single(at, at->level, right ? x.second : x.first, below ? y.second : y.first);
}

/* The level whose texels are as wide as the footprint, and the share of the next one. log2 is taken as linear
 * between powers of two, which is off by less than 0.09. */
INLINE unsigned level_of(const cache_slot *slot, float width, float *share) {
    const pyramid *p = &slot->image->plan;
    const uint32_t w = p->levels[0].width, h = p->levels[0].height;
    const float texels = width * (float)(w > h ? w : h);
    *share = 0;
    if (slot->filter != FATHOM_TEXTURE_TRILINEAR || !(texels > 1)) return 0;
    uint32_t bits;
    memcpy(&bits, &texels, sizeof bits);
    const unsigned level = (bits >> 23) - 127;
    if (level + 1 >= p->count) return p->count - 1;
    *share = (float)(bits & 0x7fffff) * 0x1p-23f;
    return level;
}

INLINE lookup begin(texture_cache *cache, const cache_slot *slot, float u, float v, float width,
                    const float *chance) {
    lookup at = {cache, slot, wrapped(u, slot->wrap_u), wrapped(v, slot->wrap_v), 0, 0, -1, false, NULL};
    at.level = level_of(slot, width, &at.share);
    if (!chance || slot->filter == FATHOM_TEXTURE_NEAREST) return at;
    at.chance = *chance;
    if (second_by(&at.chance, at.share)) ++at.level;
    at.share = 0;
    return at;
}

INLINE rgba_f32 finish(lookup *at) {
    rgba_f32 found;
    if (at->slot->filter == FATHOM_TEXTURE_NEAREST)
        found = nearest(at);
    else if (at->chance >= 0)
        found = by_chance(at);
    else
        found = bilinear(at, at->level);
    if (at->share > 0) found += at->share * (bilinear(at, at->level + 1) - found);
    return __builtin_expect(at->broken, 0) ? (rgba_f32){1, 0, 1, 1} : found;
}

/* Asks for the memory of the texels at the place, and of those below. */
INLINE void fetch_ahead(const lookup *at, unsigned level, block_chunks *block) {
    const cache_image *img = at->slot->image;
    const pyramid_level *l = &img->plan.levels[level];
    const uint32_t x = (uint32_t)(at->u * (float)(l->width - 1)),
                   y = (uint32_t)(at->v * (float)(l->height - 1));
    const uint64_t place = place_of(l, x, y);
    const unsigned char *from = at->cache->store.bytes + place;
    block->chunks[block->count++] = place >> PYRAMID_CHUNK_SHIFT;
    __builtin_prefetch(from);
    __builtin_prefetch(from + ((size_t)l->stride << l->shift));
}

static bool texel(texture_cache *cache, const cache_slot *slot, unsigned level, uint32_t x, uint32_t y,
                  float rgba[4]) {
    lookup at = {.cache = cache, .slot = slot};
    const rgba_f32 found = single(&at, level, x, y);
    memcpy(rgba, &found, sizeof found);
    return !at.broken;
}

static void mean(texture_cache *cache, const cache_slot *slot, float u, float v, float width, float rgba[4]) {
    lookup at = begin(cache, slot, u, v, width, NULL);
    const rgba_f32 found = finish(&at);
    memcpy(rgba, &found, sizeof found);
}

static void look_up(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]) {
    lookup at[TEXTURE_BLOCK];
    block_chunks block = {.count = 0};
    for (unsigned i = 0; i < q->count; ++i) {
        at[i] = begin(cache, &cache->slots[q->texture[i]], q->u[i], q->v[i], q->width[i],
                      q->stochastic ? &q->chance[i] : NULL);
        at[i].block = &block;
        fetch_ahead(&at[i], at[i].level, &block);
        if (at[i].share > 0) fetch_ahead(&at[i], at[i].level + 1, &block);
    }
    for (unsigned i = 0; i < q->count; ++i) {
        const rgba_f32 found = finish(&at[i]);
        for (int c = 0; c < 4; ++c) rgba[c][i] = found[c];
    }
}

extern const texture_kernels KERNEL(texture_kernels);
const texture_kernels KERNEL(texture_kernels) = {look_up, mean, texel};
