/* A number that tells bytes from other bytes, at the speed of memory: against accidents, not against forgers.
 *
 * Any change within eight bytes that lie at a multiple of eight changes it for certain, any other but for one
 * in 2^64. The same on every machine, for the same bytes. */
#ifndef BASE_HASH_H
#define BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define HASH_LANES 4

typedef struct hash {
    uint64_t lane[HASH_LANES];
    uint64_t length;
    unsigned char rest[8 * HASH_LANES]; /* bytes that wait for a whole row of lanes */
    size_t waiting;
} hash;

void hash_begin(hash *h);
/* In any pieces: only their bytes and order count. */
void hash_put(hash *h, const void *bytes, size_t size);
uint64_t hash_end(const hash *h);

#endif
