/* Where the tiles of all images lie: a file in memory and one on the disk, both without a name, mapped once
 * next to each other, so that no address ever changes.
 *
 * Each chunk has a state. Lookups read the mapped texels only while the chunk's state is not STORE_ABSENT;
 * memory stays, and chunks on the disk are dropped when they have not been used for long. Dropping a chunk
 * takes its memory alone: a thread that is still reading it gets the same bytes, again from the file. So
 * lookups need no lock and no count of readers.
 *
 * Mapping a chunk and dropping another for it costs as much as STORE_READS short reads of the file. So once
 * the limit is reached, a chunk is mapped when that many lookups have read it from the file, or when a block
 * of lookups has as many in it. */
#ifndef TEXTURE_STORE_H
#define TEXTURE_STORE_H

#include "base/status.h"
#include "texture/pyramid.h"

#include <pthread.h>

/* In the order of use. An absent chunk's state counts the lookups that read it from the file, in steps of
 * STORE_READ. */
enum { STORE_ABSENT = 0, STORE_IDLE = 1, STORE_USED = 3, STORE_READ = 4 };
#define STORE_READS 4u
#define STORE_BATCH 64u /* chunks that are dropped together, at most */

typedef struct store {
    int memory, disk; /* descriptors */
    unsigned char *bytes;
    uint64_t size, kept;      /* bytes in all; in memory, which are the first */
    unsigned char *states;    /* of the chunks; atomic */
    unsigned char *filled;    /* whether the file holds a chunk; atomic */
    pthread_mutex_t lock;     /* guards the members below */
    uint64_t limit, resident; /* bytes of the disk's; `resident` is atomic */
    uint64_t hand, dropped;   /* the next chunk to look at; how many were dropped */
} store;

/* kept: bytes in memory; disk: bytes on the disk, of which `limit` may be in memory. All in whole chunks. */
fathom_status store_open(fathom_context *context, uint64_t kept, uint64_t disk, uint64_t limit, store *out);
void store_close(store *s);

/* False, with errno, when the disk or memory is full. */
bool store_write_file(int descriptor, uint64_t offset, const void *bytes, size_t size);
/* The bytes lie all in memory, or all on the disk. */
bool store_write(store *s, uint64_t offset, const void *bytes, size_t size);
/* Says that the file holds a chunk. */
void store_fill(store *s, uint64_t chunk);
/* Asks to use a chunk that the file holds for so many lookups, for which others may be dropped. False: it has
 * to be read from the file. Any thread. */
bool store_admit(store *s, uint64_t chunk, unsigned lookups);
/* Of bytes on the disk. False: it failed. */
bool store_read(const store *s, uint64_t offset, void *bytes, size_t size);

static inline unsigned char store_state(const store *s, uint64_t chunk) {
    return __atomic_load_n(&s->states[chunk], __ATOMIC_ACQUIRE);
}

#endif
