/* Cells of 4 × 4 texels, and a pyramid of their ranges over them: each level has half the cells of the one
 * before. A question takes the finest level on which the part spans few cells. */
#include "texture/ranges.h"

#include "base/threads.h"
#include "texture/cache.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#define CELL_SHIFT 2u
#define MOST_CELLS 8u /* on a side of the part */

typedef struct grid {
    uint32_t width, height;
    texture_range *cells;
} grid;

struct texture_ranges {
    uint32_t width, height;
    fathom_wrap wrap_u, wrap_v;
    texture_range all;
    unsigned count; /* may be 0 if all texels are equal */
    grid levels[PYRAMID_LEVELS];
};

static void widen(texture_range *r, texture_range by) {
    r->least = fminf(r->least, by.least), r->most = fmaxf(r->most, by.most);
}

static uint32_t halved(uint32_t cells) { return (cells + 1) / 2; }

static bool make_grid(grid *g, uint32_t width, uint32_t height) {
    const size_t count = (size_t)width * height;
    *g = (grid){width, height, malloc(count * sizeof *g->cells)};
    for (size_t i = 0; g->cells && i < count; ++i) g->cells[i] = (texture_range){INFINITY, -INFINITY};
    return g->cells != NULL;
}

static bool make_grids(texture_ranges *r) {
    uint32_t width = ((r->width - 1) >> CELL_SHIFT) + 1, height = ((r->height - 1) >> CELL_SHIFT) + 1;
    while (make_grid(&r->levels[r->count++], width, height)) {
        if (width == 1 && height == 1) return true;
        width = halved(width), height = halved(height);
    }
    return false;
}

typedef struct filling {
    texture_cache *cache;
    const cache_slot *slot;
    unsigned channel;
    const texture_ranges *r;
    atomic_bool broken;
} filling;

static void add_texels(void *user, size_t begin, size_t end) {
    filling *f = user;
    const grid *g = &f->r->levels[0];
    const size_t last = f->r->height < end << CELL_SHIFT ? f->r->height : end << CELL_SHIFT;
    float rgba[4];
    for (size_t y = begin << CELL_SHIFT; y < last; ++y) {
        texture_range *row = g->cells + (y >> CELL_SHIFT) * g->width;
        for (uint32_t x = 0; x < f->r->width; ++x) {
            if (!f->cache->kernels->texel(f->cache, f->slot, 0, x, (uint32_t)y, rgba)) {
                atomic_store(&f->broken, true);
                return;
            }
            widen(&row[x >> CELL_SHIFT], (texture_range){rgba[f->channel], rgba[f->channel]});
        }
    }
}

static void add_levels(const texture_ranges *r) {
    for (unsigned k = 1; k < r->count; ++k) {
        const grid *from = &r->levels[k - 1], *to = &r->levels[k];
        for (uint32_t y = 0; y < from->height; ++y)
            for (uint32_t x = 0; x < from->width; ++x)
                widen(&to->cells[(size_t)(y / 2) * to->width + x / 2],
                      from->cells[(size_t)y * from->width + x]);
    }
}

static fathom_status fill_grids(texture_cache *cache, fathom_context *context, filling *f,
                                texture_ranges *r) {
    if (!make_grids(r))
        return fail_memory(context,
                           ((uint64_t)r->width * r->height >> 2 * CELL_SHIFT) * sizeof(texture_range));
    loop_parallel(cache->threads, r->levels[0].height, 8, add_texels, f);
    if (atomic_load(&f->broken)) return texture_cache_check(cache, context);
    add_levels(r);
    r->all = r->levels[r->count - 1].cells[0];
    return FATHOM_OK;
}

fathom_status texture_ranges_find(texture_cache *cache, fathom_context *context, fathom_id texture,
                                  unsigned channel, texture_ranges **out) {
    const cache_slot *slot = &cache->slots[texture];
    const image_texture_info *info = &slot->image->info;
    *out = NULL;
    if (info->mipmapped) return FATHOM_OK;
    bool opaque = false;
    fathom_status status = channel < 3 ? FATHOM_OK : texture_is_opaque(cache, context, texture, &opaque);
    texture_ranges *r = status == FATHOM_OK ? calloc(1, sizeof *r) : NULL;
    if (!r) return status == FATHOM_OK ? fail_memory(context, sizeof *r) : status;
    *r = (texture_ranges){info->width, info->height, slot->wrap_u, slot->wrap_v, .all = {1, 1}};
    if (!opaque) status = fill_grids(cache, context, &(filling){cache, slot, channel, r, false}, r);
    if (status == FATHOM_OK)
        *out = r;
    else
        texture_ranges_free(r);
    return status;
}

void texture_ranges_free(texture_ranges *r) {
    if (!r) return;
    for (unsigned k = 0; k < r->count; ++k) free(r->levels[k].cells);
    free(r);
}

/* ---- questions ---- */

/* Texels along a side, the last one included. */
typedef struct span {
    uint32_t first, last;
} span;

/* Rounded coordinates move by less than a texel. */
#define MOST_TEXELS 0x1p20f

/* The texels that lookups between two coordinates may read, as one or two spans. Rounding of the coordinates,
 * and the wrap, may add one on each side. */
static unsigned spans_of(float low, float high, uint32_t size, fathom_wrap wrap, span out[2]) {
    const float from = low * (float)size, to = high * (float)size;
    out[0] = (span){0, size - 1};
    if (!(from > -MOST_TEXELS && to < MOST_TEXELS && to - from < (float)size - 4)) return 1;
    int64_t first = (int64_t)floorf(from - 0.5f) - 1, last = (int64_t)floorf(to - 0.5f) + 2;
    const int64_t side = size;
    if (wrap == FATHOM_WRAP_CLAMP) {
        first = first < 0 ? 0 : first < side ? first : side - 1;
        last = last < 0 ? 0 : last < side ? last : side - 1;
        out[0] = (span){(uint32_t)first, (uint32_t)last};
        return 1;
    }
    const int64_t turn = (first >= 0 ? first : first - side + 1) / side;
    first -= turn * side, last -= turn * side;
    if (last < side) {
        const bool mirrored = wrap == FATHOM_WRAP_MIRROR && turn & 1;
        out[0] = mirrored ? (span){(uint32_t)(side - 1 - last), (uint32_t)(side - 1 - first)}
                          : (span){(uint32_t)first, (uint32_t)last};
        return 1;
    }
    if (wrap == FATHOM_WRAP_MIRROR) return 1;
    out[0] = (span){(uint32_t)first, size - 1};
    out[1] = (span){0, (uint32_t)(last - side)};
    return 2;
}

static unsigned level_of(const texture_ranges *r, span x, span y) {
    unsigned k = 0;
    while (k + 1 < r->count && ((x.last >> (CELL_SHIFT + k)) - (x.first >> (CELL_SHIFT + k)) >= MOST_CELLS ||
                                (y.last >> (CELL_SHIFT + k)) - (y.first >> (CELL_SHIFT + k)) >= MOST_CELLS))
        ++k;
    return k;
}

static void widen_by(texture_range *out, const texture_ranges *r, span x, span y) {
    const unsigned k = level_of(r, x, y), shift = CELL_SHIFT + k;
    const grid *g = &r->levels[k];
    for (uint32_t j = y.first >> shift; j <= y.last >> shift; ++j)
        for (uint32_t i = x.first >> shift; i <= x.last >> shift; ++i)
            widen(out, g->cells[(size_t)j * g->width + i]);
}

texture_range texture_range_over(const texture_ranges *r, const float low[2], const float high[2]) {
    texture_range out = {INFINITY, -INFINITY};
    span x[2], y[2];
    if (r->all.least == r->all.most) return r->all;
    const unsigned across = spans_of(low[0], high[0], r->width, r->wrap_u, x),
                   down = spans_of(low[1], high[1], r->height, r->wrap_v, y);
    for (unsigned j = 0; j < down; ++j)
        for (unsigned i = 0; i < across; ++i) widen_by(&out, r, x[i], y[j]);
    return out;
}
