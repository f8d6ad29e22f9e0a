#include "base/hash.h"

#include <string.h>

/* Multiplication by an odd number and the xor-shift are both invertible, so a step loses nothing of the lane
 * or the word. The multiplier is 2^64 over the golden ratio, which spreads low bits well (Knuth, The Art of
 * Computer Programming, 6.4). */
static uint64_t step(uint64_t lane, uint64_t word) {
    uint64_t x = (lane ^ word) * 0x9e3779b97f4a7c15u;
    return x ^ x >> 32;
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "hashes are the same on every machine");

static uint64_t read_word(const unsigned char *bytes) {
    uint64_t word;
    memcpy(&word, bytes, sizeof word);
    return word;
}

/* Four lanes, so that multiplications overlap. */
static void put_rows(hash *h, const unsigned char *bytes, size_t rows) {
    uint64_t a = h->lane[0], b = h->lane[1], c = h->lane[2], d = h->lane[3];
    for (; rows; --rows, bytes += sizeof h->rest) {
        a = step(a, read_word(bytes)), b = step(b, read_word(bytes + 8));
        c = step(c, read_word(bytes + 16)), d = step(d, read_word(bytes + 24));
    }
    h->lane[0] = a, h->lane[1] = b, h->lane[2] = c, h->lane[3] = d;
}

void hash_begin(hash *h) { *h = (hash){.lane = {1, 2, 3, 4}}; }

/* Fills the waiting row. Returns the bytes taken. */
static size_t fill_row(hash *h, const unsigned char *bytes, size_t size) {
    size_t room = sizeof h->rest - h->waiting, take = size < room ? size : room;
    memcpy(h->rest + h->waiting, bytes, take);
    h->waiting += take;
    if (h->waiting == sizeof h->rest) {
        put_rows(h, h->rest, 1);
        h->waiting = 0;
    }
    return take;
}

void hash_put(hash *h, const void *bytes, size_t size) {
    const unsigned char *from = bytes;
    if (!size) return;
    h->length += size;
    if (h->waiting) {
        size_t taken = fill_row(h, from, size);
        from += taken, size -= taken;
    }
    if (h->waiting) return;
    size_t rows = size / sizeof h->rest;
    put_rows(h, from, rows);
    from += rows * sizeof h->rest, size -= rows * sizeof h->rest;
    if (size) fill_row(h, from, size);
}

uint64_t hash_end(const hash *h) {
    hash all = *h;
    if (all.waiting) {
        memset(all.rest + all.waiting, 0, sizeof all.rest - all.waiting);
        put_rows(&all, all.rest, 1);
    }
    uint64_t x = step(h->length, 0);
    for (int i = 0; i < HASH_LANES; ++i) x = step(x, all.lane[i]);
    return step(x, 0);
}
