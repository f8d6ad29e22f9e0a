/* Where the tiles of all images lie: one file without a name, mapped once, so that no address ever changes.
 *
 * Each chunk has a state. Lookups read the mapped texels only while the chunk's state is not STORE_ABSENT;
 * the one store is memory and stays, and the chunks of the other, on the disk, are dropped when they have not
 * been used for long. Dropping a chunk takes its memory alone: a thread that is still reading it gets the
 * same bytes, again from the file. So lookups need no lock and no count of readers.
 *
 * Mapping a chunk and dropping another for it costs as much as STORE_READS short reads of the file. So once
 * the limit is reached, a chunk is mapped when that many lookups have read it from the file. */
#ifndef TEXTURE_STORE_H
#define TEXTURE_STORE_H

#include "base/status.h"
#include "texture/pyramid.h"

#include <pthread.h>

/* In the order of use. An absent chunk's state counts the lookups that read it from the file, in steps of
 * STORE_READ. */
enum { STORE_ABSENT = 0, STORE_IDLE = 1, STORE_USED = 3, STORE_READ = 4 };
#define STORE_READS 4u

typedef struct store {
    int descriptor;
    unsigned char *bytes;
    uint64_t size;
    unsigned char *states;    /* of the chunks; atomic */
    unsigned char *filled;    /* whether the file holds a chunk; atomic */
    bool dropping;            /* whether chunks are dropped */
    pthread_mutex_t lock;     /* guards the members below */
    uint64_t limit, resident; /* bytes; `resident` is atomic */
    uint64_t hand, dropped;   /* the next chunk to look at; how many were dropped */
} store;

/* limit: bytes of chunks in memory; 0: the store is memory, and nothing is dropped. */
fathom_status store_open(fathom_context *context, uint64_t size, uint64_t limit, store *out);
void store_close(store *s);

/* False, with errno, when the disk or memory is full. */
bool store_write(store *s, uint64_t offset, const void *bytes, size_t size);
/* Says that the file holds a chunk. */
void store_fill(store *s, uint64_t chunk);
/* Asks to use a chunk that the file holds, for which others may be dropped. False: it has to be read from the
 * file. Any thread. */
bool store_admit(store *s, uint64_t chunk);
/* False: the disk failed. */
bool store_read(const store *s, uint64_t offset, void *bytes, size_t size);

static inline unsigned char store_state(const store *s, uint64_t chunk) {
    return __atomic_load_n(&s->states[chunk], __ATOMIC_ACQUIRE);
}

#endif
