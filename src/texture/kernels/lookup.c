/* Texture lookups by coordinates and footprint. */
#include "base/kernel.h"
#include "math/mix.h"
#include "texture/cache.h"

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
/* Converts finite halves. Denormals are converted by a subtraction of normal floats, so that no operand is a
 * denormal float. */
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

/* `type`, `channels` and whether `color` is NULL are constants after inlining. NULL: linear, with the same
 * quotients as the table. */
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

/* ---- addresses of texels ---- */

/* For each lane of a block: the level that it reads, and four texels of the level, or one. */
typedef struct block_level {
    const pyramid_level *level[TEXTURE_BLOCK];
    /* Two columns and two rows of texels. The index of a texel in the level is the sum of a number for its
     * column and one for its row. */
    uint32_t column[2][TEXTURE_BLOCK], row[2][TEXTURE_BLOCK];
    float right[TEXTURE_BLOCK], below[TEXTURE_BLOCK]; /* weights of the second column and row */
    uint64_t place[4][TEXTURE_BLOCK]; /* byte offsets of the texels in the store; the second is right of the
                                         first */
} block_level;

typedef struct block {
    texture_cache *cache;
    unsigned count;
    const cache_slot *slot[TEXTURE_BLOCK];
    float u[TEXTURE_BLOCK], v[TEXTURE_BLOCK], width[TEXTURE_BLOCK];
    float chance[TEXTURE_BLOCK];
    uint32_t wrap_u[TEXTURE_BLOCK], wrap_v[TEXTURE_BLOCK], filter[TEXTURE_BLOCK];
    uint32_t across[TEXTURE_BLOCK], down[TEXTURE_BLOCK], last[TEXTURE_BLOCK]; /* of level 0; the last level */
    uint32_t level[TEXTURE_BLOCK];
    float share[TEXTURE_BLOCK]; /* weight of the next level */
    block_level at[2];
    cache_copy copy;
} block;

/* `lanes` is a constant after inlining, so that loops over 16 lanes vectorise. */

INLINE void gather_slots(block *b, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        const cache_slot *slot = b->slot[i];
        const pyramid *p = &slot->image->plan;
        b->wrap_u[i] = slot->wrap_u, b->wrap_v[i] = slot->wrap_v, b->filter[i] = slot->filter;
        b->across[i] = p->levels[0].width, b->down[i] = p->levels[0].height, b->last[i] = p->count - 1;
    }
}

/* Wraps u; the result is in [0, 1] for any u. */
INLINE void wrap(float *u, const uint32_t *mode, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        const float at = u[i], repeated = at - floorf(at), twice = at - 2 * floorf(0.5f * at);
        const float mirrored = twice > 1 ? 2 - twice : twice;
        float t = mode[i] == FATHOM_WRAP_REPEAT ? repeated : at;
        t = mode[i] == FATHOM_WRAP_MIRROR ? mirrored : t;
        t = t > 0 ? t : 0;
        u[i] = t < 1 ? t : 1;
    }
}

/* Finds the level whose texels have the area of the footprint, and the weight of the next level. On a surface
 * of the image's shape texels are square, and the footprint is as round in texels as on the surface. log2 is
 * approximated as linear between powers of two; the error is below 0.09. */
INLINE void find_levels(block *b, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        const float texels = b->width[i] * sqrtf((float)(int32_t)b->across[i] * (float)(int32_t)b->down[i]);
        uint32_t bits;
        memcpy(&bits, &texels, sizeof bits);
        const uint32_t level = (bits >> 23) - 127;
        const bool filtered = b->filter[i] >= FATHOM_TEXTURE_TRILINEAR && texels > 1;
        const bool between = filtered && level < b->last[i];
        b->share[i] = between ? (float)(int32_t)(bits & 0x7fffff) * 0x1p-23f : 0;
        b->level[i] = between ? level : (filtered ? b->last[i] : 0);
    }
}

/* The lookup reads one texel. */
INLINE bool takes_one(const block *b, unsigned i) {
    return b->filter[i] == FATHOM_TEXTURE_NEAREST || b->filter[i] == FATHOM_TEXTURE_STOCHASTIC;
}

/* Takes the second of two with probability `share`, and rescales *chance to be uniform in [0,1) again. */
INLINE bool second_by(float *chance, float share) {
    const bool second = *chance < share;
    *chance = second ? *chance / share : (*chance - share) / (1 - share);
    return second;
}

/* A number for each place, by a hash: the same place has the same texel in all maps, at any time. */
INLINE void choose_levels(block *b, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        uint32_t u, v;
        if (b->filter[i] != FATHOM_TEXTURE_STOCHASTIC) continue;
        memcpy(&u, &b->u[i], sizeof u), memcpy(&v, &b->v[i], sizeof v);
        b->chance[i] = (float)(mix_bits((uint64_t)u << 32 | v) >> 40) * 0x1p-24f;
        b->level[i] += second_by(&b->chance[i], b->share[i]);
        b->share[i] = 0;
    }
}

/* The size of a level, as in pyramid_plan(). */
INLINE uint32_t side_of(uint32_t side, uint32_t level) { return side >> level ? side >> level : 1; }

/* Finds the two texels whose centres are next to t along a side, and the weight of the second one. */
INLINE void find_pairs(const block *b, uint32_t next, const float *t, const uint32_t *side,
                       const uint32_t *mode, uint32_t (*to)[TEXTURE_BLOCK], float *share, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        const int32_t size = (int32_t)side_of(side[i], b->level[i] + next), last = size - 1;
        const float at = t[i] * (float)size - 0.5f, low = floorf(at);
        const int32_t k = (int32_t)low;
        const bool around = mode[i] == FATHOM_WRAP_REPEAT;
        const int32_t before = around ? last : 0, after = around ? 0 : last, inside = k < last ? k : last;
        share[i] = at - low;
        to[0][i] = (uint32_t)(k >= 0 ? inside : before);
        to[1][i] = (uint32_t)(k < last ? k + 1 : after);
    }
}

/* The texel that contains t. */
INLINE uint32_t nearest(float t, uint32_t size) {
    const uint32_t x = (uint32_t)(t * (float)size);
    return x < size ? x : size - 1;
}

/* Chooses one texel instead of four. */
INLINE void choose_texels(block *b, block_level *l, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        if (b->filter[i] == FATHOM_TEXTURE_NEAREST) {
            l->column[0][i] = nearest(b->u[i], b->across[i]);
            l->row[0][i] = nearest(b->v[i], b->down[i]);
        } else if (b->filter[i] == FATHOM_TEXTURE_STOCHASTIC) {
            const bool right = second_by(&b->chance[i], l->right[i]),
                       below = second_by(&b->chance[i], l->below[i]);
            l->column[0][i] = l->column[right][i];
            l->row[0][i] = l->row[below][i];
        }
    }
}

INLINE uint32_t column_of(uint32_t x) { return x / PYRAMID_TILE * PYRAMID_TILE_TEXELS + x % PYRAMID_TILE; }

INLINE uint32_t row_of(uint32_t y, uint32_t across, uint32_t stride) {
    return y / PYRAMID_TILE * across * PYRAMID_TILE_TEXELS + y % PYRAMID_TILE * stride;
}

INLINE uint64_t place_of(uint64_t offset, uint64_t shift, uint32_t column, uint32_t row) {
    return offset + ((uint64_t)(column + row) << shift);
}

/* Converts columns and rows to the numbers that give a texel's index. */
INLINE void number_texels(const block *b, uint32_t next, block_level *l, int lanes) {
    for (int i = 0; i < lanes; ++i) {
        const uint32_t width = side_of(b->across[i], b->level[i] + next),
                       height = side_of(b->down[i], b->level[i] + next);
        const uint32_t tiles = (width + PYRAMID_TILE - 1) / PYRAMID_TILE;
        const uint32_t stride = width <= PYRAMID_TILE && height <= PYRAMID_TILE ? width : PYRAMID_TILE;
        for (int k = 0; k < 2; ++k) {
            l->column[k][i] = column_of(l->column[k][i]);
            l->row[k][i] = row_of(l->row[k][i], tiles, stride);
        }
    }
}

/* Copies the levels' offsets to lanes first, because loops that read them through a pointer do not
 * vectorise. */
INLINE void place_texels(const block *b, uint32_t next, block_level *l, int lanes) {
    uint64_t offset[TEXTURE_BLOCK], shift[TEXTURE_BLOCK];
    for (int i = 0; i < lanes; ++i) {
        const uint32_t n = b->level[i] + (b->share[i] > 0 ? next : 0);
        l->level[i] = &b->slot[i]->image->plan.levels[n];
        offset[i] = l->level[i]->offset, shift[i] = l->level[i]->shift;
    }
    for (int i = 0; i < lanes; ++i) {
        const uint32_t *left = l->column[0], *right = l->column[1], *top = l->row[0], *low = l->row[1];
        l->place[0][i] = place_of(offset[i], shift[i], left[i], top[i]);
        l->place[1][i] = place_of(offset[i], shift[i], right[i], top[i]);
        l->place[2][i] = place_of(offset[i], shift[i], left[i], low[i]);
        l->place[3][i] = place_of(offset[i], shift[i], right[i], low[i]);
    }
}

INLINE void find_texels(block *b, unsigned k, bool some_single, int lanes) {
    block_level *l = &b->at[k];
    find_pairs(b, k, b->u, b->across, b->wrap_u, l->column, l->right, lanes);
    find_pairs(b, k, b->v, b->down, b->wrap_v, l->row, l->below, lanes);
    if (some_single) choose_texels(b, l, lanes);
    number_texels(b, k, l, lanes);
    place_texels(b, k, l, lanes);
    for (unsigned i = 0; i < b->count; ++i) {
        __builtin_prefetch(b->cache->store.bytes + l->place[0][i]);
        __builtin_prefetch(b->cache->store.bytes + l->place[2][i]);
    }
}

/* ---- filters ---- */

INLINE uint64_t chunk_of(uint64_t place) { return place >> PYRAMID_CHUNK_SHIFT; }

/* Number of the block's lookups whose first texel is in the chunk, at least 1. */
static unsigned neighbours(const block *b, uint64_t chunk) {
    unsigned count = 0;
    for (unsigned i = 0; i < b->count; ++i) {
        count += chunk_of(b->at[0].place[0][i]) == chunk;
        count += b->share[i] > 0 && chunk_of(b->at[1].place[0][i]) == chunk;
    }
    return count ? count : 1;
}

/* Gets the addresses of texels whose chunk may not be in memory. False: the image is broken. */
static __attribute__((noinline, cold)) bool fetch(block *b, const block_level *of, unsigned lane,
                                                  const uint64_t *places, unsigned count,
                                                  const unsigned char **at) {
    return cache_fetch(b->cache, b->slot[lane]->image, places, count, (size_t)1 << of->level[lane]->shift,
                       neighbours(b, chunk_of(places[0])), &b->copy, at);
}

INLINE unsigned state_of(const store *s, uint64_t place) { return store_state(s, chunk_of(place)); }

INLINE rgba_f32 between(const unsigned char *const at[4], float right, float below, image_texel type,
                        unsigned channels, const float *color, const float *alpha) {
    const rgba_f32 a = texel_at(at[0], type, channels, color, alpha);
    const rgba_f32 b = texel_at(at[1], type, channels, color, alpha);
    const rgba_f32 c = texel_at(at[2], type, channels, color, alpha);
    const rgba_f32 d = texel_at(at[3], type, channels, color, alpha);
    const rgba_f32 top = a + right * (b - a), low = c + right * (d - c);
    return top + below * (low - top);
}

/* Each type has its own code without a loop. */
#define BY_TYPE(call, type, channels)                                                                        \
    switch ((type)) {                                                                                        \
    case IMAGE_TEXEL_U8: return (channels) == 1 ? call(IMAGE_TEXEL_U8, 1) : call(IMAGE_TEXEL_U8, 4);         \
    case IMAGE_TEXEL_U16: return (channels) == 1 ? call(IMAGE_TEXEL_U16, 1) : call(IMAGE_TEXEL_U16, 4);      \
    case IMAGE_TEXEL_HALF: return (channels) == 1 ? call(IMAGE_TEXEL_HALF, 1) : call(IMAGE_TEXEL_HALF, 4);   \
    case IMAGE_TEXEL_FLOAT: break;                                                                           \
    }                                                                                                        \
    return (channels) == 1 ? call(IMAGE_TEXEL_FLOAT, 1) : call(IMAGE_TEXEL_FLOAT, 4)

INLINE rgba_f32 bilinear(block *b, const block_level *of, unsigned i, bool *broken) {
    const cache_image *img = b->slot[i]->image;
    const image_texel type = of->level[i]->type;
    const store *s = &b->cache->store;
    const uint64_t p[4] = {of->place[0][i], of->place[1][i], of->place[2][i], of->place[3][i]};
    const unsigned char *at[4] = {s->bytes + p[0], s->bytes + p[1], s->bytes + p[2], s->bytes + p[3]};
    const unsigned used = state_of(s, p[0]) & state_of(s, p[1]) & state_of(s, p[2]) & state_of(s, p[3]);
    if (__builtin_expect(used != STORE_USED, 0) && !fetch(b, of, i, p, 4, at)) {
        *broken = true;
        return grey(0);
    }
    const float *color = img->decoding.color, *alpha = img->decoding.alpha;
    if (type == IMAGE_TEXEL_U8 && img->plan.channels == 4 && color == alpha)
        return between(at, of->right[i], of->below[i], IMAGE_TEXEL_U8, 4, NULL, NULL);
#define CALL(type, channels) between(at, of->right[i], of->below[i], type, channels, color, alpha)
    BY_TYPE(CALL, type, img->plan.channels);
#undef CALL
}

static rgba_f32 single(block *b, unsigned i, bool *broken) {
    const cache_image *img = b->slot[i]->image;
    const uint64_t place = b->at[0].place[0][i];
    const unsigned char *at = b->cache->store.bytes + place;
    if (state_of(&b->cache->store, place) != STORE_USED && !fetch(b, &b->at[0], i, &place, 1, &at)) {
        *broken = true;
        return grey(0);
    }
#define CALL(type, channels) texel_at(at, type, channels, img->decoding.color, img->decoding.alpha)
    BY_TYPE(CALL, b->at[0].level[i]->type, img->plan.channels);
#undef CALL
}

/* The lookups in one of two levels. Not inlined, because its code is long. */
static __attribute__((noinline)) void filter_level(block *b, unsigned k, rgba_f32 found[TEXTURE_BLOCK]) {
    for (unsigned i = 0; i < b->count; ++i) {
        bool broken = false;
        if (k && !(b->share[i] > 0)) continue;
        if (takes_one(b, i)) {
            found[i] = single(b, i, &broken);
        } else {
            const rgba_f32 level = bilinear(b, &b->at[k], i, &broken);
            found[i] = k ? found[i] + b->share[i] * (level - found[i]) : level;
        }
        if (__builtin_expect(broken, 0)) found[i] = (rgba_f32){1, 0, 1, 1}, b->share[i] = 0;
    }
}

/* ---- blocks ---- */

/* Computes all addresses first, so that prefetched texels have time to arrive. */
INLINE void filter_lanes(block *b, float rgba[4][TEXTURE_BLOCK], int lanes) {
    rgba_f32 found[TEXTURE_BLOCK];
    bool two = false, some_single = false;
    gather_slots(b, lanes);
    wrap(b->u, b->wrap_u, lanes);
    wrap(b->v, b->wrap_v, lanes);
    find_levels(b, lanes);
    for (int i = 0; i < lanes; ++i) some_single |= takes_one(b, (unsigned)i);
    if (some_single) choose_levels(b, lanes);
    for (int i = 0; i < lanes; ++i) two |= b->share[i] > 0;
    find_texels(b, 0, some_single, lanes);
    if (two) find_texels(b, 1, false, lanes);
    filter_level(b, 0, found);
    if (two) filter_level(b, 1, found);
    for (unsigned i = 0; i < b->count; ++i) {
        for (int c = 0; c < 4; ++c) rgba[c][i] = found[i][c];
    }
}

/* Lanes past the count repeat the first one. Whole arrays are copied, because a copy of `count` lanes becomes
 * a slow `rep movs`. */
INLINE void load_lanes(block *b, const texture_queries *q, int lanes) {
    fathom_id texture[TEXTURE_BLOCK];
    memcpy(texture, q->texture, (size_t)lanes * sizeof *texture);
    memcpy(b->u, q->u, (size_t)lanes * sizeof *b->u);
    memcpy(b->v, q->v, (size_t)lanes * sizeof *b->v);
    memcpy(b->width, q->width, (size_t)lanes * sizeof *b->width);
    for (int i = (int)b->count; i < lanes; ++i)
        texture[i] = texture[0], b->u[i] = b->u[0], b->v[i] = b->v[0], b->width[i] = b->width[0];
    for (int i = 0; i < lanes; ++i) b->slot[i] = &b->cache->slots[texture[i]];
}

INLINE void look_up_lanes(block *b, const texture_queries *q, float rgba[4][TEXTURE_BLOCK], int lanes) {
    load_lanes(b, q, lanes);
    filter_lanes(b, rgba, lanes);
}

static void look_up_one(block *b, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]) {
    look_up_lanes(b, q, rgba, 1);
}

static void look_up(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]) {
    block b;
    b.cache = cache, b.count = q->count;
    if (q->count > 1)
        look_up_lanes(&b, q, rgba, TEXTURE_BLOCK);
    else if (q->count)
        look_up_one(&b, q, rgba);
}

static bool texel(texture_cache *cache, const cache_slot *slot, unsigned level, uint32_t x, uint32_t y,
                  float rgba[4]) {
    const pyramid_level *l = &slot->image->plan.levels[level];
    bool broken = false;
    block b;
    b.cache = cache, b.count = 1, b.slot[0] = slot, b.share[0] = 0;
    b.at[0].level[0] = l;
    b.at[0].place[0][0] = place_of(l->offset, l->shift, column_of(x), row_of(y, l->across, l->stride));
    const rgba_f32 found = single(&b, 0, &broken);
    memcpy(rgba, &found, sizeof found);
    return !broken;
}

extern const texture_kernels KERNEL(texture_kernels);
const texture_kernels KERNEL(texture_kernels) = {look_up, texel};
