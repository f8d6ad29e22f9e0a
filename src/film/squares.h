/* How an image is divided: into waves of 32 × 32 pixels, and these into squares of 4 × 4. A batch is a list
 * of squares with one sample of each pixel. The grid is fixed to the image, not to tiles, crops or
 * threads. */
#pragma once

#include "math/lanes.h"
#include "sample/sample.h"

#include <stdbool.h>

#define WAVE_SIDE 32
#define WAVE_SLOTS (WAVE_SIDE * WAVE_SIDE)
#define WAVE_SQUARES (WAVE_SLOTS / LANES) /* of 4 × 4 pixels */

/* The pixels of a wave: the rendered part of its 32 × 32 square, in image coordinates, half open. */
typedef struct wave_region {
    uint32_t x0, y0, x1, y1;
    uint32_t left, top; /* the square's corner */
} wave_region;

static inline uint32_t min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }
static inline uint32_t max_u32(uint32_t a, uint32_t b) { return a > b ? a : b; }

/* The waves that cover a rectangle of the image, row by row. */
typedef struct wave_grid {
    uint32_t x0, y0, x1, y1; /* the rectangle, half open */
    uint32_t across, count;
} wave_grid;

static inline wave_grid wave_grid_of(uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    const uint32_t across = (x1 + WAVE_SIDE - 1) / WAVE_SIDE - x0 / WAVE_SIDE,
                   down = (y1 + WAVE_SIDE - 1) / WAVE_SIDE - y0 / WAVE_SIDE;
    return (wave_grid){x0, y0, x1, y1, across, across * down};
}

/* The wave of the pixel (x, y). */
static inline uint32_t wave_grid_at(const wave_grid *g, uint32_t x, uint32_t y) {
    return (y / WAVE_SIDE - g->y0 / WAVE_SIDE) * g->across + x / WAVE_SIDE - g->x0 / WAVE_SIDE;
}

static inline wave_region wave_grid_region(const wave_grid *g, uint32_t wave) {
    const uint32_t left = (g->x0 / WAVE_SIDE + wave % g->across) * WAVE_SIDE,
                   top = (g->y0 / WAVE_SIDE + wave / g->across) * WAVE_SIDE;
    return (wave_region){max_u32(left, g->x0),
                         max_u32(top, g->y0),
                         min_u32(left + WAVE_SIDE, g->x1),
                         min_u32(top + WAVE_SIDE, g->y1),
                         left,
                         top};
}

/* The slot of the pixel at (x, y) relative to the corner of the wave: ordered by squares of 4 × 4, then by
 * rows. */
static inline uint32_t wave_slot(uint32_t x, uint32_t y) {
    return (y / 4 * (WAVE_SIDE / 4) + x / 4) * LANES + y % 4 * 4 + x % 4;
}

/* One sample of each pixel of a 4 × 4 square. Its corner is a multiple of 4. */
typedef struct wave_square {
    uint32_t left, top, index, group;
} wave_square;

/* The samples of a pixel form one group or four. Each group has its own scramble, as if its pixel were at
 * another column of the image. So the means of the groups are independent of each other. Images are at most
 * 2^16 pixels wide, so these columns do not overlap. */
#define SAMPLE_GROUPS 4u
#define SAMPLE_GROUP_COLUMNS (1u << 20)

/* The key of the sample at pixel (left + k % 4, top + k / 4). */
static inline sample_key wave_square_key(const wave_square *s, uint32_t k) {
    return (sample_key){s->left + k % 4 + s->group * SAMPLE_GROUP_COLUMNS, s->top + k / 4, s->index};
}

/* Square s of the region's wave, counted row by row. Its pixels have the slots from s * 16 on. */
static inline wave_square wave_square_at(const wave_region *r, uint32_t s) {
    const uint32_t across = WAVE_SIDE / 4;
    return (wave_square){r->left + s % across * 4, r->top + s / across * 4, 0, 0};
}

/* Sample n of a pixel; samples go to the groups in turn. */
static inline wave_square wave_square_sample(wave_square s, uint32_t n, uint32_t groups) {
    s.index = n / groups, s.group = n % groups;
    return s;
}

/* The number of samples of a group among the first n samples of a pixel. */
static inline uint32_t wave_group_count(uint32_t n, uint32_t group, uint32_t groups) {
    return (n + groups - 1 - group) / groups;
}

static inline bool wave_square_is_whole(const wave_region *r, const wave_square *s) {
    return s->left >= r->x0 && s->left + 4 <= r->x1 && s->top >= r->y0 && s->top + 4 <= r->y1;
}

/* The pixels of the square that lie in the region, as bits: pixel (left + k % 4, top + k / 4) is bit k. */
static inline uint32_t wave_square_pixels(const wave_region *r, const wave_square *s) {
    uint32_t bits = 0;
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = s->left + k % 4, y = s->top + k / 4;
        bits |= x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1 ? 1u << k : 0;
    }
    return bits;
}

/* The squares that hold pixels of the region, as bits. */
static inline uint64_t wave_region_bits(wave_region r) {
    uint64_t bits = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        const wave_square q = wave_square_at(&r, s);
        bits |= (uint64_t)(q.left < r.x1 && q.left + 4 > r.x0 && q.top < r.y1 && q.top + 4 > r.y0) << s;
    }
    return bits;
}

/* Lists the squares of these bits row by row, with sample index 0; returns their number. */
static inline uint32_t wave_list_squares(const wave_region *r, uint64_t bits, wave_square out[WAVE_SQUARES]) {
    uint32_t count = 0;
    for (; bits; bits &= bits - 1) out[count++] = wave_square_at(r, (uint32_t)__builtin_ctzll(bits));
    return count;
}

/* Squares in any order; a square may occur with several samples. In the square at `place`, pixel (x, y) has
 * the slot place * 16 + (y - top) * 4 + x - left. */
typedef struct wave_batch {
    wave_square squares[WAVE_SQUARES];
    uint32_t count;
} wave_batch;

/* The first hit of each slot's sample, for the AOVs. */
typedef struct first_hits {
    float z[WAVE_SLOTS], n[3][WAVE_SLOTS], p[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    float motion[4][WAVE_SLOTS]; /* forward u and v, backward u and v */
    uint32_t object[WAVE_SLOTS], primitive[WAVE_SLOTS], instance[WAVE_SLOTS];
} first_hits;

/* The samples of a batch, by slot. */
typedef struct wave_samples {
    float *radiance[3];
    first_hits *first;              /* NULL when no AOV needs it */
    float (*layers)[WAVE_SLOTS];    /* three for each layer of film_parts; NULL: there are none */
    uint32_t (*mattes)[WAVE_SLOTS]; /* ids for each matte of film_parts, 0 for no hit; NULL: there are none */
} wave_samples;
