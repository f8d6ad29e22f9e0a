/* Hashes that nobody outside can foresee: for tables whose keys come from files.
 *
 * Whoever knows a hash can write a file whose names all fall into one place of a table, so that each new one
 * is compared with all before it. These go by a key that is drawn once for each process. Only places of
 * tables may depend on them: never an order, and never a pixel. */
#ifndef BASE_KEYED_HASH_H
#define BASE_KEYED_HASH_H

#include <stddef.h>
#include <stdint.h>

typedef struct hash_key {
    uint64_t half[2];
} hash_key;

/* SipHash-2-4 (Aumasson, Bernstein 2012), section 2. */
uint64_t sip_hash(hash_key key, const void *bytes, size_t size);

/* The process's key; any thread may ask. */
hash_key process_hash_key(void);

#endif
