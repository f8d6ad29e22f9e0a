/* A block: the code of its mode, hints for encoders of other formats, the component of the second plane, the
 * number of the partition, the quantised end points of each subset, the weights of each texel. Equations are
 * ASTC's (Khronos Data Format Specification 1.4, chapter 23); the modes and the order of the fields are those
 * of Basis Universal's "UASTC LDR 4x4 Texture Specification". */
#include "helper/ktx2/uastc.h"

#include "helper/ktx2/bits.h"

enum { TEXELS = 16, SUBSETS_MAX = 3, VALUES_MAX = 18, SOLID = 8, MERGED = 7, MODES = 19 };

/* LA: luminance and alpha. */
typedef enum components { LA = 2, RGB = 3, RGBA = 4 } components;

typedef struct mode {
    uint8_t code, code_bits; /* least significant bit first */
    uint8_t hint_bits;
    components components;
    uint8_t subsets, planes, weight_bits;
    uint16_t levels; /* of an end point's component */
} mode;

static const mode modes[MODES] = {
    {0x01, 4, 15, RGB, 1, 1, 4, 192},  {0x35, 6, 15, RGB, 1, 1, 2, 256},  {0x1d, 5, 15, RGB, 2, 1, 3, 16},
    {0x03, 5, 15, RGB, 3, 1, 2, 12},   {0x13, 5, 15, RGB, 2, 1, 2, 40},   {0x0b, 5, 15, RGB, 1, 1, 3, 256},
    {0x1b, 5, 15, RGB, 1, 2, 2, 160},  {0x07, 5, 15, RGB, 2, 1, 2, 40},   {0x17, 5, 0, RGBA, 0, 0, 0, 0},
    {0x0f, 5, 23, RGBA, 2, 1, 2, 16},  {0x02, 3, 17, RGBA, 1, 1, 4, 48},  {0x00, 2, 17, RGBA, 1, 2, 2, 48},
    {0x06, 3, 17, RGBA, 1, 1, 3, 192}, {0x1f, 5, 23, RGBA, 1, 2, 1, 256}, {0x0d, 5, 23, RGBA, 1, 1, 2, 256},
    {0x05, 7, 23, LA, 1, 1, 4, 256},   {0x15, 6, 23, LA, 2, 1, 2, 256},   {0x25, 6, 23, LA, 1, 2, 2, 256},
    {0x09, 4, 15, RGB, 1, 1, 5, 32}};

/* ---- partitions ---- */

/* The numbers that ASTC gives the partitions that it shares with BC7. Mode 7 has the partitions into two that
 * merge two subsets of BC7's three. */
static const uint16_t seeds_two[] = {28, 20,  16,  29, 91,  9,   107, 72,  149, 204, 50,  114, 496, 17,  78,
                                     39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
static const uint16_t seeds_three[] = {260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};
static const uint16_t seeds_merged[] = {36,  48,  61,  137, 161, 183, 226, 281, 302, 307,
                                        479, 495, 593, 594, 605, 799, 812, 988, 993};

static uint32_t hash(uint32_t p) {
    p ^= p >> 15, p -= p << 17, p += p << 7, p += p << 4;
    p ^= p >> 5, p += p << 16, p ^= p >> 7, p ^= p >> 3;
    p ^= p << 6, p ^= p >> 17;
    return p;
}

/* ASTC's partition function for blocks of fewer than 31 texels: a plane wave for each subset, whose direction
 * and offset come from a hash of the partition's number. The strongest wave has the texel. */
static void partition(unsigned seed, unsigned subsets, uint8_t of_texel[TEXELS]) {
    const uint32_t random = hash(seed + (subsets - 1) * 1024);
    const unsigned fine = seed & 2 ? 4 : 5, coarse = subsets == 3 ? 6 : 5;
    const unsigned shift_x = seed & 1 ? fine : coarse, shift_y = seed & 1 ? coarse : fine;
    for (unsigned i = 0; i < TEXELS; ++i) {
        uint32_t strongest = 0;
        for (unsigned s = 0; s < subsets; ++s) {
            const uint32_t x = (random >> (8 * s)) & 15, y = (random >> (8 * s + 4)) & 15;
            const uint32_t wave = ((x * x >> shift_x) * 2 * (i % 4) + (y * y >> shift_y) * 2 * (i / 4) +
                                   (random >> (14 - 4 * s))) &
                                  63;
            if (s && wave <= strongest) continue;
            strongest = wave, of_texel[i] = (uint8_t)s;
        }
    }
}

static bool read_partition(bit_reader *bits, const mode *m, uint8_t of_texel[TEXELS]) {
    const bool merged = m == &modes[MERGED];
    const uint16_t *seeds = m->subsets == 3 ? seeds_three : merged ? seeds_merged : seeds_two;
    const size_t count = m->subsets == 3 ? sizeof seeds_three
                         : merged        ? sizeof seeds_merged
                                         : sizeof seeds_two;
    const uint32_t index = m->subsets > 1 ? bits_take(bits, m->subsets == 3 ? 4 : 5) : 0;
    if (m->subsets > 1 && index >= count / sizeof *seeds) return false;
    for (unsigned i = 0; i < TEXELS; ++i) of_texel[i] = 0;
    if (m->subsets > 1) partition(seeds[index], m->subsets, of_texel);
    return true;
}

/* ---- end points ---- */

/* Reads digits of a base that is no power of two, `group` of them to a number. A group at the end that is not
 * full has as many bits as its digits need. */
static void read_digits(bit_reader *bits, unsigned base, unsigned count, uint8_t *digits) {
    const unsigned group = base == 3 ? 5 : 3;
    for (unsigned i = 0; i < count; i += group) {
        const unsigned n = count - i < group ? count - i : group;
        unsigned most = 1, length = 0;
        for (unsigned k = 0; k < n; ++k) most *= base;
        while (1u << length < most) ++length;
        uint32_t number = bits_take(bits, length);
        for (unsigned k = 0; k < n; ++k, number /= base) digits[i + k] = (uint8_t)(number % base);
    }
}

/* ASTC's unquantisation of a digit and bits above it: D·C + B in nine bits, where B repeats the bits but the
 * lowest, which mirrors the scale. */
static uint8_t unquantise(uint32_t levels, uint32_t digit, uint32_t low) {
    static const struct {
        uint16_t levels, multiplier, shift, step;
    } table[] = {{12, 278, 0, 93}, {48, 65, 0, 22}, {192, 257, 4, 5}, {40, 261, 1, 26}, {160, 257, 3, 6}};
    const uint32_t mirror = low & 1 ? 511 : 0;
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i) {
        if (table[i].levels != levels) continue;
        const uint32_t spread = (low >> 1) * table[i].multiplier >> table[i].shift;
        const uint32_t value = (digit * table[i].step + spread) ^ mirror;
        return (uint8_t)((mirror & 0x80) | value >> 2);
    }
    return 0;
}

/* Repeats the bits of a value from the top down until it has eight. */
static uint8_t widen(uint32_t value, unsigned bits) {
    value <<= 8 - bits;
    for (unsigned n = bits; n < 8; n *= 2) value |= value >> n;
    return (uint8_t)value;
}

static void read_values(bit_reader *bits, const mode *m, unsigned count, uint8_t values[VALUES_MAX]) {
    uint8_t digits[VALUES_MAX] = {0};
    const unsigned base = m->levels % 3 == 0 ? 3 : m->levels % 5 == 0 ? 5 : 1;
    unsigned low_bits = 0;
    while (base << low_bits < m->levels) ++low_bits;
    if (base > 1) read_digits(bits, base, count, digits);
    for (unsigned i = 0; i < count; ++i) {
        const uint32_t low = bits_take(bits, low_bits);
        values[i] = base > 1 ? unquantise(m->levels, digits[i], low) : widen(low, low_bits);
    }
}

/* The two ends of each subset: R, G, B, A. */
typedef struct ends {
    uint8_t from[4], to[4];
} ends;

static void read_ends(bit_reader *bits, const mode *m, ends out[SUBSETS_MAX]) {
    uint8_t values[VALUES_MAX] = {0};
    const unsigned each = 2 * (unsigned)m->components;
    read_values(bits, m, m->subsets * each, values);
    for (unsigned s = 0; s < m->subsets; ++s) {
        const uint8_t *v = values + s * each;
        for (unsigned c = 0; c < 4; ++c) {
            const unsigned from = m->components == LA ? 2 * (c / 3) : 2 * c;
            const bool opaque = c == 3 && m->components == RGB;
            out[s].from[c] = opaque ? 255 : v[from];
            out[s].to[c] = opaque ? 255 : v[from + 1];
        }
    }
}

/* ---- weights ---- */

/* 0 to 64 */
static uint8_t unquantise_weight(uint32_t value, unsigned bits) {
    value <<= 6 - bits;
    for (unsigned n = bits; n < 6; n *= 2) value |= value >> n;
    return (uint8_t)(value + (value > 32));
}

/* The highest bit of the first weight of each subset is 0, and not stored. */
static void read_weights(bit_reader *bits, const mode *m, const uint8_t of_texel[TEXELS],
                         uint8_t weights[TEXELS][2]) {
    unsigned seen = 0;
    for (unsigned i = 0; i < TEXELS; ++i) {
        const unsigned subset = 1u << of_texel[i], stored = m->weight_bits - (seen & subset ? 0u : 1u);
        seen |= subset;
        for (unsigned plane = 0; plane < m->planes; ++plane)
            weights[i][plane] = unquantise_weight(bits_take(bits, stored), m->weight_bits);
    }
}

/* ---- blocks ---- */

static uint8_t mix(uint32_t from, uint32_t to, uint32_t weight) {
    return (uint8_t)((from * 257 * (64 - weight) + to * 257 * weight + 32) >> 14);
}

static const mode *read_mode(bit_reader *bits) {
    for (unsigned i = 0; i < MODES; ++i) {
        if (bits_peek(bits, modes[i].code_bits) != modes[i].code) continue;
        bits->at += modes[i].code_bits;
        return &modes[i];
    }
    return NULL;
}

static void read_solid(bit_reader *bits, uint8_t texels[TEXELS][4]) {
    for (unsigned c = 0; c < 4; ++c) {
        const uint8_t value = (uint8_t)bits_take(bits, 8);
        for (unsigned i = 0; i < TEXELS; ++i) texels[i][c] = value;
    }
}

bool uastc_decode(const uint8_t block[UASTC_BLOCK], uint8_t texels[TEXELS][4]) {
    bit_reader bits = {.bytes = block, .size = UASTC_BLOCK};
    uint8_t of_texel[TEXELS], weights[TEXELS][2] = {{0}};
    ends pair[SUBSETS_MAX] = {{{0}, {0}}};
    const mode *m = read_mode(&bits);
    if (!m) return false;
    if (m == &modes[SOLID]) {
        read_solid(&bits, texels);
        return true;
    }
    bits.at += m->hint_bits;
    /* The component that the second plane is of. */
    uint32_t second = 4;
    if (m->planes == 2) second = m->components == LA ? 3 : bits_take(&bits, 2);
    if (!read_partition(&bits, m, of_texel)) return false;
    read_ends(&bits, m, pair);
    read_weights(&bits, m, of_texel, weights);
    for (unsigned i = 0; i < TEXELS; ++i) {
        const ends *e = &pair[of_texel[i]];
        for (unsigned c = 0; c < 4; ++c) texels[i][c] = mix(e->from[c], e->to[c], weights[i][c == second]);
    }
    return true;
}
