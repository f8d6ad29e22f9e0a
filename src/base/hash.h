/* A 64-bit hash of bytes, the same on every machine: against accidents, not against forgers. A change within
 * eight bytes at a multiple of eight always changes it; any other change with odds of 1 in 2^64 does not. */
#ifndef BASE_HASH_H
#define BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

typedef struct hash {
    uint64_t state, length;
    uint64_t word;    /* an incomplete one */
    unsigned waiting; /* bytes in it */
} hash;

void hash_begin(hash *h);
/* The sizes of the pieces do not matter. */
void hash_put(hash *h, const void *bytes, size_t size);
uint64_t hash_end(const hash *h);

#endif
