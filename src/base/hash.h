/* A 64-bit hash of bytes, the same on every machine. It detects accidental changes, not forgeries. A change
 * within one block of eight bytes, at an offset that is a multiple of eight, always changes the hash. Any
 * other change leaves the hash equal with a probability of 2^-64. */
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef struct hash {
    uint64_t state, length;
    uint64_t word;    /* bytes that do not fill a word yet */
    unsigned waiting; /* the number of these bytes */
} hash;

void hash_begin(hash *h);
/* The hash does not depend on how the bytes are divided among calls. */
void hash_put(hash *h, const void *bytes, size_t size);
uint64_t hash_end(const hash *h);
/* The hash of these bytes alone. */
uint64_t hash_of(const void *bytes, size_t size);
