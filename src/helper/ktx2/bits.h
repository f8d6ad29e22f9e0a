/* Bits of a byte array, the least significant bit of each byte first. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Reading beyond the end returns zeros: ask bits_are_over() afterwards. */
typedef struct bit_reader {
    const uint8_t *bytes;
    size_t size;
    size_t at; /* in bits */
} bit_reader;

/* count: 0 to 24 */
static inline uint32_t bits_peek(const bit_reader *b, unsigned count) {
    const size_t first = b->at / 8;
    uint32_t word = 0;
    for (unsigned i = 0; i < 4 && first + i < b->size; ++i) word |= (uint32_t)b->bytes[first + i] << (8 * i);
    return (word >> (b->at % 8)) & ((UINT32_C(1) << count) - 1);
}

static inline uint32_t bits_take(bit_reader *b, unsigned count) {
    const uint32_t value = bits_peek(b, count);
    b->at += count;
    return value;
}

static inline bool bits_are_over(const bit_reader *b) { return b->at > 8 * b->size; }

static inline uint32_t u32_at(const uint8_t *bytes) {
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}
