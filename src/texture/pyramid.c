#include "texture/pyramid.h"

#include "base/srgb.h"
#include "image/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static unsigned shift_of(unsigned channels, image_texel type) {
    return (channels == 4 ? 2u : 0u) + (type == IMAGE_TEXEL_U8 ? 0u : type == IMAGE_TEXEL_FLOAT ? 2u : 1u);
}

static uint64_t whole_chunks(uint64_t bytes) { return (bytes + PYRAMID_CHUNK - 1) & ~(PYRAMID_CHUNK - 1); }

static uint64_t level_bytes(const pyramid_level *l) {
    if (l->stride < PYRAMID_TILE) return ((uint64_t)l->stride * l->height) << l->shift;
    const uint64_t down = (l->height + PYRAMID_TILE - 1) / PYRAMID_TILE;
    return (l->across * down * PYRAMID_TILE_TEXELS) << l->shift;
}

void pyramid_plan(pyramid *p, uint32_t width, uint32_t height, unsigned channels, image_texel first,
                  image_texel other) {
    *p = (pyramid){.channels = channels};
    for (uint32_t w = width, h = height;
         p->count<PYRAMID_LEVELS; w = w> 1 ? w / 2 : 1, h = h > 1 ? h / 2 : 1) {
        const image_texel type = p->count ? other : first;
        const bool tail = w <= PYRAMID_TILE && h <= PYRAMID_TILE;
        p->tail += !tail;
        p->levels[p->count++] = (pyramid_level){.width = w,
                                                .height = h,
                                                .across = (w + PYRAMID_TILE - 1) / PYRAMID_TILE,
                                                .stride = tail ? w : PYRAMID_TILE,
                                                .shift = shift_of(channels, type),
                                                .type = type};
        if (w == 1 && h == 1) break;
    }
    for (unsigned i = p->tail; i < p->count; ++i) {
        p->levels[i].offset = p->tail_bytes;
        p->tail_bytes += (level_bytes(&p->levels[i]) + 15) & ~(uint64_t)15;
    }
    p->tail_bytes = whole_chunks(p->tail_bytes);
}

uint64_t pyramid_part_bytes(const pyramid *p, unsigned part) {
    return part == p->tail ? p->tail_bytes : whole_chunks(level_bytes(&p->levels[part]));
}

void pyramid_place(pyramid *p, unsigned part, uint64_t offset) {
    const unsigned end = part == p->tail ? p->count : part + 1;
    for (unsigned i = part; i < end; ++i) p->levels[i].offset += offset;
}

/* ---- numbers ---- */

void pyramid_fill_table(float *table, image_texel type, bool srgb) {
    const unsigned most = type == IMAGE_TEXEL_U8 ? 255 : 65535;
    for (unsigned i = 0; i <= most; ++i) {
        const double value = (double)i / most;
        table[i] = (float)(srgb ? srgb_decoded(value) : value);
    }
}

static float float_from_half(uint16_t half) {
    const uint32_t magnitude = half & 0x7fffu, sign = (half & 0x8000u) << 16;
    if (magnitude < 0x400) return (sign ? -1.0f : 1.0f) * (float)magnitude * 0x1p-24f;
    const uint32_t bits =
        sign | (magnitude >= 0x7c00 ? (magnitude << 13) + (224u << 23) : (magnitude << 13) + (112u << 23));
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#define INLINE static inline __attribute__((always_inline))

/* Number i of a row from the helper. `type` and `srgb` are constants after inlining. */
INLINE float number_at(const float *table, image_texel type, bool srgb, const void *sent, size_t i) {
    float value = 0;
    switch (type) {
    case IMAGE_TEXEL_U8: return table[((const unsigned char *)sent)[i]];
    case IMAGE_TEXEL_U16: return table[((const uint16_t *)sent)[i]];
    case IMAGE_TEXEL_HALF: value = float_from_half(((const uint16_t *)sent)[i]); break;
    case IMAGE_TEXEL_FLOAT: value = ((const float *)sent)[i]; break;
    }
    return srgb ? (float)srgb_decoded((double)value) : value;
}

/* Converts n channels of a type to `channels` floats per texel. */
INLINE void decode_row(const pyramid_decoding *d, image_texel type, bool srgb, size_t n, unsigned channels,
                       const void *sent, size_t count, float *restrict linear) {
    const float *color = d->color, *alpha = d->alpha;
    for (size_t i = 0; i < count; ++i) {
        linear[channels * i] = number_at(color, type, srgb, sent, n * i);
        if (channels == 1) continue;
        for (size_t c = 1; c < 3; ++c)
            linear[4 * i + c] = number_at(color, type, srgb, sent, n * i + (n > 2 ? c : 0));
        linear[4 * i + 3] = n % 2 ? 1 : number_at(alpha, type, false, sent, n * i + n - 1);
    }
}

/* Each type and number of channels has its own loop. */
INLINE void decode_type(const pyramid_decoding *d, image_texel type, bool srgb, unsigned channels,
                        const void *sent, size_t count, float *linear) {
    if (channels == 1)
        decode_row(d, type, srgb, d->sent_channels, 1, sent, count, linear);
    else if (d->sent_channels == 3)
        decode_row(d, type, srgb, 3, 4, sent, count, linear);
    else if (d->sent_channels == 4)
        decode_row(d, type, srgb, 4, 4, sent, count, linear);
    else
        decode_row(d, type, srgb, 2, 4, sent, count, linear);
}

void pyramid_decode(const pyramid *p, const pyramid_decoding *d, const void *sent, size_t count,
                    float *linear) {
    switch (d->sent) {
    case IMAGE_TEXEL_U8: decode_type(d, IMAGE_TEXEL_U8, d->srgb, p->channels, sent, count, linear); break;
    case IMAGE_TEXEL_U16: decode_type(d, IMAGE_TEXEL_U16, d->srgb, p->channels, sent, count, linear); break;
    case IMAGE_TEXEL_HALF: decode_type(d, IMAGE_TEXEL_HALF, d->srgb, p->channels, sent, count, linear); break;
    case IMAGE_TEXEL_FLOAT:
        decode_type(d, IMAGE_TEXEL_FLOAT, d->srgb, p->channels, sent, count, linear);
        break;
    }
}

/* Adds a missing alpha, and uses grey for all three colours. n and size are constants after inlining. */
INLINE void keep_row(size_t n, size_t size, const unsigned char *restrict sent, size_t count,
                     unsigned char *restrict kept) {
    for (size_t i = 0; i < count; ++i, sent += n * size, kept += 4 * size) {
        for (size_t c = 0; c < 3; ++c) memcpy(kept + c * size, sent + (n > 2 ? c : 0) * size, size);
        if (n == 2)
            memcpy(kept + 3 * size, sent + size, size);
        else
            memset(kept + 3 * size, 255, size);
    }
}

/* Level 0 stores integers unchanged. */
static void keep_integers(const pyramid *p, const pyramid_decoding *d, const void *sent, size_t count,
                          void *kept) {
    const size_t n = d->sent_channels;
    const bool bytes = d->sent == IMAGE_TEXEL_U8;
    if (n == p->channels)
        memcpy(kept, sent, count * n * image_texel_size(d->sent));
    else if (n == 3)
        bytes ? keep_row(3, 1, sent, count, kept) : keep_row(3, 2, sent, count, kept);
    else
        bytes ? keep_row(2, 1, sent, count, kept) : keep_row(2, 2, sent, count, kept);
}

void pyramid_keep(const pyramid *p, const pyramid_level *level, const pyramid_decoding *d, const void *sent,
                  const float *linear, size_t count, void *kept) {
    const size_t numbers = count * p->channels;
    switch (level->type) {
    case IMAGE_TEXEL_U8:
    case IMAGE_TEXEL_U16: keep_integers(p, d, sent, count, kept); break;
    case IMAGE_TEXEL_HALF:
        for (size_t i = 0; i < numbers; ++i) ((uint16_t *)kept)[i] = half_from_float(linear[i]);
        break;
    case IMAGE_TEXEL_FLOAT: memcpy(kept, linear, numbers * sizeof *linear); break;
    }
}

size_t pyramid_find_bad(const float *linear, size_t count) {
    int32_t most = 0;
    for (size_t i = 0; i < count; ++i) {
        int32_t bits;
        memcpy(&bits, &linear[i], sizeof bits);
        bits &= 0x7fffffff;
        most = bits > most ? bits : most;
    }
    const bool bad = most >= 0x7f800000;
    for (size_t i = 0; bad && i < count; ++i) {
        if (!isfinite(linear[i])) return i;
    }
    return count;
}

/* ---- levels ---- */

/* A level under construction. */
typedef struct making {
    uint32_t rows;        /* rows added so far */
    unsigned char *strip; /* a row of tiles */
    unsigned char *kept;  /* a row of texels */
    float *halved;        /* a row as wide as the next level's */
    float *sum;           /* the next level's row so far */
} making;

struct pyramid_builder {
    pyramid p;
    pyramid_decoding decoding;
    pyramid_write write;
    void *user;
    float *linear;
    float least_alpha;
    making levels[PYRAMID_LEVELS];
};

static uint32_t rows_together(const pyramid_level *l) {
    return l->stride < PYRAMID_TILE || l->height < PYRAMID_TILE ? l->height : PYRAMID_TILE;
}

static size_t strip_bytes(const pyramid_level *l) {
    if (l->stride < PYRAMID_TILE) return (size_t)level_bytes(l);
    return ((size_t)l->across * PYRAMID_TILE_TEXELS) << l->shift;
}

static bool make_room(pyramid_builder *b, unsigned i) {
    const pyramid_level *l = &b->p.levels[i];
    making *m = &b->levels[i];
    const size_t next = ((size_t)l->width / 2 + 1) * b->p.channels;
    m->strip = calloc(1, strip_bytes(l));
    m->kept = malloc((size_t)l->width << l->shift);
    m->halved = malloc(next * sizeof *m->halved);
    m->sum = calloc(next, sizeof *m->sum);
    return m->strip && m->kept && m->halved && m->sum;
}

static void free_builder(pyramid_builder *b) {
    for (unsigned i = 0; i < b->p.count; ++i)
        free(b->levels[i].strip), free(b->levels[i].kept), free(b->levels[i].halved), free(b->levels[i].sum);
    free(b->linear);
    free(b);
}

pyramid_builder *pyramid_builder_open(const pyramid *p, const pyramid_decoding *d, pyramid_write write,
                                      void *user) {
    pyramid_builder *b = calloc(1, sizeof *b);
    if (!b) return NULL;
    b->p = *p, b->decoding = *d, b->write = write, b->user = user, b->least_alpha = 1;
    b->linear = malloc((size_t)p->levels[0].width * p->channels * sizeof *b->linear);
    bool fine = b->linear != NULL;
    for (unsigned i = 0; fine && i < p->count; ++i) fine = make_room(b, i);
    if (fine) return b;
    free_builder(b);
    return NULL;
}

/* Adds the next row to the level's strip of tiles, and writes the strip when it is full. */
static bool add_to_strip(pyramid_builder *b, unsigned i) {
    const pyramid_level *l = &b->p.levels[i];
    making *m = &b->levels[i];
    const uint32_t y = m->rows++, together = rows_together(l), in_strip = y % PYRAMID_TILE;
    for (uint32_t x = 0; x < l->width; x += PYRAMID_TILE) {
        const uint32_t count = l->width - x < PYRAMID_TILE ? l->width - x : PYRAMID_TILE;
        const size_t at = (size_t)(x / PYRAMID_TILE) * PYRAMID_TILE_TEXELS + (size_t)in_strip * l->stride;
        memcpy(m->strip + (at << l->shift), m->kept + ((size_t)x << l->shift), (size_t)count << l->shift);
    }
    if (m->rows % together && m->rows != l->height) return true;
    const size_t size = strip_bytes(l);
    return b->write(b->user, l->offset + y / PYRAMID_TILE * size, m->strip, size);
}

INLINE void halve_even(const float *row, size_t to, size_t channels, float *restrict out) {
    for (size_t j = 0; j < to; ++j)
        for (size_t c = 0; c < channels; ++c)
            out[j * channels + c] = 0.5f * (row[2 * j * channels + c] + row[(2 * j + 1) * channels + c]);
}

/* Reduces a row of `from` texels to `to` texels. Texel j covers [j from / to, (j + 1) from / to). */
static void halve(const float *row, uint32_t from, uint32_t to, unsigned channels, float *out) {
    if (from == 2 * to) {
        channels == 4 ? halve_even(row, to, 4, out) : halve_even(row, to, 1, out);
        return;
    }
    for (uint32_t j = 0; j < to; ++j) {
        const uint64_t begin = (uint64_t)j * from, end = begin + from;
        for (unsigned c = 0; c < channels; ++c) out[j * channels + c] = 0;
        for (uint64_t i = begin / to; i * to < end; ++i) {
            const uint64_t low = i * to > begin ? i * to : begin,
                           high = (i + 1) * to < end ? (i + 1) * to : end;
            const float weight = (float)(high - low) / (float)from;
            for (unsigned c = 0; c < channels; ++c) out[j * channels + c] += weight * row[i * channels + c];
        }
    }
}

static bool add_row(pyramid_builder *b, unsigned i, uint32_t y, const void *sent, const float *linear);

/* Halves row y, and adds it to the rows of the next level that it overlaps. */
static bool pass_on(pyramid_builder *b, unsigned i, uint32_t y, const float *linear) {
    if (i + 1 == b->p.count) return true;
    const pyramid_level *l = &b->p.levels[i], *next = l + 1;
    making *m = &b->levels[i];
    const size_t numbers = (size_t)next->width * b->p.channels;
    const uint64_t from = l->height, to = next->height;
    halve(linear, l->width, next->width, b->p.channels, m->halved);
    for (uint64_t j = y * to / from; j * from < (y + UINT64_C(1)) * to; ++j) {
        const uint64_t low = y * to > j * from ? y * to : j * from;
        const uint64_t high =
            (y + UINT64_C(1)) * to < (j + 1) * from ? (y + UINT64_C(1)) * to : (j + 1) * from;
        const float weight = (float)(high - low) / (float)from;
        for (size_t k = 0; k < numbers; ++k) m->sum[k] += weight * m->halved[k];
        if (high != (j + 1) * from) continue;
        if (!add_row(b, i + 1, (uint32_t)j, NULL, m->sum)) return false;
        memset(m->sum, 0, numbers * sizeof *m->sum);
    }
    return true;
}

static bool add_row(pyramid_builder *b, unsigned i, uint32_t y, const void *sent, const float *linear) {
    const pyramid_level *l = &b->p.levels[i];
    pyramid_keep(&b->p, l, &b->decoding, sent, linear, l->width, b->levels[i].kept);
    return add_to_strip(b, i) && pass_on(b, i, y, linear);
}

static void note_alpha(pyramid_builder *b) {
    const size_t width = b->p.levels[0].width;
    for (size_t x = 0; b->decoding.sent_channels % 2 == 0 && x < width; ++x)
        b->least_alpha = b->linear[4 * x + 3] < b->least_alpha ? b->linear[4 * x + 3] : b->least_alpha;
}

bool pyramid_builder_row(pyramid_builder *b, const void *sent, size_t *bad) {
    const size_t width = b->p.levels[0].width, numbers = width * b->p.channels;
    pyramid_decode(&b->p, &b->decoding, sent, width, b->linear);
    *bad = pyramid_find_bad(b->linear, numbers);
    if (*bad < numbers) return false;
    *bad = SIZE_MAX;
    note_alpha(b);
    return add_row(b, 0, b->levels[0].rows, sent, b->linear);
}

void pyramid_builder_close(pyramid_builder *b, float *least_alpha) {
    if (!b) return;
    *least_alpha = b->least_alpha;
    free_builder(b);
}
