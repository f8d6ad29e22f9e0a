#include "base/hash.h"

#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "hashes are the same on every machine");

/* Multiplication by an odd number and the xor-shift are both invertible, so a step loses no information of
 * the state or the word. The multiplier is 2^64 divided by the golden ratio, which distributes low bits well
 * (Knuth, The Art of Computer Programming, 6.4). */
static uint64_t step(uint64_t state, uint64_t word) {
    uint64_t x = (state ^ word) * 0x9e3779b97f4a7c15u;
    return x ^ x >> 32;
}

void hash_begin(hash *h) { *h = (hash){.state = 1}; }

static void put_byte(hash *h, unsigned char byte) {
    h->word |= (uint64_t)byte << 8 * h->waiting;
    if (++h->waiting < sizeof h->word) return;
    h->state = step(h->state, h->word);
    h->word = h->waiting = 0;
}

void hash_put(hash *h, const void *bytes, size_t size) {
    if (!size) return; /* `bytes` may be NULL then */
    const unsigned char *from = bytes, *end = from + size;
    h->length += size;
    while (h->waiting && from < end) put_byte(h, *from++);
    uint64_t state = h->state, word;
    for (; (size_t)(end - from) >= sizeof word; from += sizeof word) {
        memcpy(&word, from, sizeof word);
        state = step(state, word);
    }
    h->state = state;
    while (from < end) put_byte(h, *from++);
}

uint64_t hash_end(const hash *h) {
    const uint64_t state = h->waiting ? step(h->state, h->word) : h->state;
    return step(step(step(h->length, 0), state), 0);
}

uint64_t hash_of(const void *bytes, size_t size) {
    hash h;
    hash_begin(&h);
    hash_put(&h, bytes, size);
    return hash_end(&h);
}
