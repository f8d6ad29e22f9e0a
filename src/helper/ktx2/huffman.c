#include "helper/ktx2/huffman.h"

#include <stdlib.h>
#include <string.h>

/* The lengths of a table's codes are themselves coded. Symbols up to 16 are lengths; the others are runs. */
enum { ZEROS_SHORT = 17, ZEROS_LONG, REPEAT_SHORT, REPEAT_LONG, LENGTH_SYMBOLS };

/* Sorts the symbols of each length, in order of length. More codes than bits can tell apart are refused;
 * fewer are not, because a table of one symbol has one code of one bit. */
static huffman_result build(const uint8_t *lengths, unsigned count, huffman *out) {
    unsigned next[HUFFMAN_LENGTH_MAX + 2] = {0};
    uint32_t used = 0;
    for (unsigned i = 0; i < count; ++i) ++out->counts[lengths[i]];
    out->counts[0] = 0;
    for (unsigned n = 1; n <= HUFFMAN_LENGTH_MAX; ++n) {
        used += (uint32_t)out->counts[n] << (HUFFMAN_LENGTH_MAX - n);
        next[n + 1] = next[n] + out->counts[n];
    }
    if (used > UINT32_C(1) << HUFFMAN_LENGTH_MAX) return HUFFMAN_BROKEN;
    out->symbols = malloc((next[HUFFMAN_LENGTH_MAX + 1] + 1) * sizeof *out->symbols);
    if (!out->symbols) return HUFFMAN_NO_MEMORY;
    for (unsigned i = 0; i < count; ++i)
        if (lengths[i]) out->symbols[next[lengths[i]]++] = (uint16_t)i;
    return HUFFMAN_FINE;
}

int huffman_take(const huffman *table, bit_reader *bits) {
    uint32_t word = bits_peek(bits, HUFFMAN_LENGTH_MAX), code = 0, first = 0, index = 0;
    for (unsigned n = 1; n <= HUFFMAN_LENGTH_MAX; ++n, word >>= 1) {
        const uint32_t count = table->counts[n];
        code = code << 1 | (word & 1);
        first <<= 1;
        if (code - first < count) {
            bits->at += n;
            return table->symbols[index + code - first];
        }
        first += count, index += count;
    }
    return -1;
}

/* Reads the table that codes the lengths. */
static huffman_result read_length_codes(bit_reader *bits, huffman *out) {
    static const uint8_t order[LENGTH_SYMBOLS] = {17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                  11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
    uint8_t lengths[LENGTH_SYMBOLS] = {0};
    const uint32_t count = bits_take(bits, 5);
    if (count < 1 || count > LENGTH_SYMBOLS) return HUFFMAN_BROKEN;
    for (uint32_t i = 0; i < count; ++i) lengths[order[i]] = (uint8_t)bits_take(bits, 3);
    return build(lengths, LENGTH_SYMBOLS, out);
}

static bool read_lengths(bit_reader *bits, const huffman *codes, uint8_t *lengths, unsigned count) {
    for (unsigned i = 0; i < count;) {
        const int symbol = huffman_take(codes, bits);
        const uint8_t previous = i ? lengths[i - 1] : 0;
        uint8_t length = previous;
        unsigned run = 1;
        if (symbol < 0 || bits_are_over(bits)) return false;
        switch (symbol) {
        case ZEROS_SHORT: run = 3 + bits_take(bits, 3), length = 0; break;
        case ZEROS_LONG: run = 11 + bits_take(bits, 7), length = 0; break;
        case REPEAT_SHORT: run = 3 + bits_take(bits, 2); break;
        case REPEAT_LONG: run = 7 + bits_take(bits, 7); break;
        default: length = (uint8_t)symbol; break;
        }
        if (symbol >= REPEAT_SHORT && previous == 0) return false;
        if (run > count - i) return false;
        memset(lengths + i, length, run);
        i += run;
    }
    return true;
}

huffman_result huffman_read(bit_reader *bits, huffman *out) {
    uint8_t lengths[HUFFMAN_SYMBOLS_MAX];
    huffman codes = {.symbols = NULL};
    *out = codes;
    const unsigned count = bits_take(bits, 14);
    if (bits_are_over(bits)) return HUFFMAN_BROKEN;
    if (!count) return HUFFMAN_FINE;
    huffman_result result = read_length_codes(bits, &codes);
    if (result == HUFFMAN_FINE && !read_lengths(bits, &codes, lengths, count)) result = HUFFMAN_BROKEN;
    if (result == HUFFMAN_FINE) result = build(lengths, count, out);
    huffman_free(&codes);
    return result;
}

void huffman_free(huffman *table) {
    free(table->symbols);
    *table = (huffman){.symbols = NULL};
}
