#include "base/murmur.h"

static uint32_t rotate(uint32_t x, unsigned bits) { return x << bits | x >> (32 - bits); }

static uint32_t mixed(uint32_t word) { return rotate(word * 0xcc9e2d51u, 15) * 0x1b873593u; }

static uint32_t word_of(const char *bytes, size_t count) {
    uint32_t word = 0;
    for (size_t i = 0; i < count; ++i) word |= (uint32_t)(unsigned char)bytes[i] << 8 * i;
    return word;
}

uint32_t murmur_hash(const char *bytes, size_t size) {
    uint32_t h = 0;
    for (size_t i = 0; i < size / 4; ++i)
        h = rotate(h ^ mixed(word_of(bytes + 4 * i, 4)), 13) * 5 + 0xe6546b64u;
    h ^= mixed(word_of(bytes + size / 4 * 4, size % 4)) ^ (uint32_t)size;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}
