/* The memory of the tiles of all images: a file in memory and a file on the disk, both without a name. They
 * are mapped once, next to each other, so that no address ever changes.
 *
 * Each chunk has a state. Lookups read the mapped texels only if the state is not STORE_ABSENT. Chunks of the
 * memory file are never evicted; chunks of the disk file are, if they have not been used for a while.
 * Eviction frees only the memory of a chunk: a thread that still reads the chunk gets the same bytes from the
 * file. So lookups need no lock and no reader count.
 *
 * Mapping one chunk and evicting another costs as much as STORE_READS short reads of the file. So at the
 * limit, the first STORE_READS lookups of a chunk read from the file, and the next one maps it. More than
 * STORE_READS lookups in one block map it at once. */
#pragma once

#include "base/status.h"
#include "texture/pyramid.h"

#include <pthread.h>

/* States of a chunk. For a chunk that is not mapped, the state counts the lookups that read it from the file,
 * in steps of STORE_READ. */
enum { STORE_ABSENT = 0, STORE_IDLE = 1, STORE_USED = 3, STORE_READ = 4 };
#define STORE_READS 4u
#define STORE_BATCH 64u /* maximum number of chunks evicted together */

typedef struct store {
    int memory, disk; /* descriptors */
    unsigned char *bytes;
    uint64_t size, kept;      /* all bytes; bytes of the memory file, which come first */
    unsigned char *states;    /* one per chunk; atomic */
    unsigned char *filled;    /* whether the file has the chunk's data; atomic */
    pthread_mutex_t lock;     /* guards the members below */
    uint64_t limit, resident; /* bytes of the disk file in memory; `resident` is atomic */
    uint64_t most;            /* maximum of `resident` */
    uint64_t hand, dropped;   /* the next chunk to examine; number of evicted chunks */
} store;

/* kept: bytes in memory; disk: bytes on the disk, of which at most `limit` may be in memory. All in whole
 * chunks. */
fathom_status store_open(fathom_context *context, uint64_t kept, uint64_t disk, uint64_t limit, store *out);
void store_close(store *s);
/* The most bytes that tiles have taken in memory. */
uint64_t store_peak(const store *s);

/* The bytes must lie all in the memory file, or all in the disk file. False, with errno, when the disk or
 * memory is full. */
bool store_write(store *s, uint64_t offset, const void *bytes, size_t size);
/* Marks the chunk's data as present in the file. */
void store_fill(store *s, uint64_t chunk);
/* Requests a chunk, whose data the file has, for this many lookups. May map it and evict others. False: read
 * it from the file instead. Thread-safe. */
bool store_admit(store *s, uint64_t chunk, unsigned lookups);
/* Reads bytes of the disk file. False on failure. */
bool store_read(const store *s, uint64_t offset, void *bytes, size_t size);

static inline unsigned char store_state(const store *s, uint64_t chunk) {
    return __atomic_load_n(&s->states[chunk], __ATOMIC_ACQUIRE);
}
