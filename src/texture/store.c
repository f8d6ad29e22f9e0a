#include "texture/store.h"

#include "base/file.h"
#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* $TMPDIR; else /var/tmp if it is writable, because /tmp is often not on a disk; else /tmp. */
static const char *folder(void) {
    const char *named = getenv("TMPDIR");
    if (named && *named) return named;
    return access("/var/tmp", W_OK) == 0 ? "/var/tmp" : "/tmp";
}

static int open_nameless(void) {
    char path[PATH_MAX];
    const int descriptor = open(folder(), O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return descriptor;
    snprintf(path, sizeof path, "%s/fathom-textures-XXXXXX", folder());
    const int named = mkostemp(path, O_CLOEXEC);
    if (named >= 0) unlink(path);
    return named;
}

static fathom_status fail_file_size(fathom_context *context, uint64_t size) {
    return fail_file(
        context, FATHOM_OUT_OF_RESOURCES, folder(),
        "cannot hold a temporary file of %.1f MB for textures: %s; name another folder in $TMPDIR",
        (double)size * 1e-6, strerror(errno));
}

/* Maps a file at `at`, inside the reserved address range. */
static bool map_file(int descriptor, unsigned char *at, uint64_t size) {
    return descriptor >= 0 && ftruncate(descriptor, (off_t)size) == 0 &&
           mmap(at, size, PROT_READ, MAP_SHARED | MAP_NORESERVE | MAP_FIXED, descriptor, 0) != MAP_FAILED;
}

fathom_status store_open(fathom_context *context, uint64_t kept, uint64_t disk, uint64_t limit, store *out) {
    const uint64_t size = kept + disk;
    *out = (store){.memory = -1, .disk = -1, .size = size, .kept = kept, .limit = limit};
    pthread_mutex_init(&out->lock, NULL);
    out->hand = kept >> PYRAMID_CHUNK_SHIFT;
    if (!size) return FATHOM_OK;
    const size_t chunks = (size_t)(size >> PYRAMID_CHUNK_SHIFT);
    out->states = calloc(chunks, 2);
    if (!out->states) return fail_memory(context, 2 * chunks);
    out->filled = out->states + chunks;
    if (kept && !memory_has(kept)) return fail_memory(context, kept);
    void *bytes = mmap(NULL, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (bytes == MAP_FAILED) return fail_memory(context, size);
    out->bytes = bytes;
    if (kept) out->memory = memfd_create("fathom-textures", MFD_CLOEXEC);
    if (kept && !map_file(out->memory, out->bytes, kept)) return fail_memory(context, kept);
    if (disk) out->disk = open_nameless();
    if (disk && !map_file(out->disk, out->bytes + kept, disk)) return fail_file_size(context, disk);
    return FATHOM_OK;
}

void store_close(store *s) {
    if (s->bytes) munmap(s->bytes, s->size);
    if (s->memory >= 0) close(s->memory);
    if (s->disk >= 0) close(s->disk);
    free(s->states);
    pthread_mutex_destroy(&s->lock);
    *s = (store){.memory = -1, .disk = -1};
}

uint64_t store_peak(const store *s) {
    struct stat info;
    const bool known = s->memory >= 0 && fstat(s->memory, &info) == 0;
    return s->most + (known ? (uint64_t)info.st_blocks * 512 : 0);
}

bool store_write(store *s, uint64_t offset, const void *bytes, size_t size) {
    const bool kept = offset < s->kept;
    return file_write_at(kept ? s->memory : s->disk, kept ? offset : offset - s->kept, bytes, size);
}

static bool is_kept(const store *s, uint64_t chunk) { return chunk << PYRAMID_CHUNK_SHIFT < s->kept; }

void store_fill(store *s, uint64_t chunk) {
    __atomic_store_n(&s->filled[chunk], 1, __ATOMIC_RELEASE);
    if (is_kept(s, chunk)) __atomic_store_n(&s->states[chunk], STORE_USED, __ATOMIC_RELEASE);
}

bool store_read(const store *s, uint64_t offset, void *bytes, size_t size) {
    ssize_t n;
    do n = pread(s->disk, bytes, size, (off_t)(offset - s->kept));
    while (n < 0 && errno == EINTR);
    return n == (ssize_t)size;
}

static bool exchange(store *s, uint64_t chunk, unsigned char from, unsigned char to) {
    return __atomic_compare_exchange_n(&s->states[chunk], &from, to, false, __ATOMIC_RELAXED,
                                       __ATOMIC_RELAXED);
}

static void count_resident(store *s, uint64_t resident) {
    __atomic_store_n(&s->resident, resident, __ATOMIC_RELAXED);
    if (resident > s->most) s->most = resident;
}

static uint64_t chunk_count(const store *s) { return s->size >> PYRAMID_CHUNK_SHIFT; }

static bool is_mapped(unsigned char state) { return state == STORE_IDLE || state == STORE_USED; }

/* Evicts all chunks of [from, end), even if they are in use. Uses one call for many chunks, because each call
 * flushes the TLBs of all processors. */
static void drop_chunks(store *s, uint64_t from, uint64_t end) {
    uint64_t low = end, high = from, count = 0;
    for (uint64_t chunk = from; chunk < end; ++chunk) {
        if (!is_mapped(__atomic_exchange_n(&s->states[chunk], STORE_ABSENT, __ATOMIC_RELAXED))) continue;
        low = low < chunk ? low : chunk, high = chunk + 1, ++count;
    }
    if (!count) return;
    madvise(s->bytes + (low << PYRAMID_CHUNK_SHIFT), (high - low) << PYRAMID_CHUNK_SHIFT, MADV_DONTNEED);
    count_resident(s, s->resident - (count << PYRAMID_CHUNK_SHIFT)), s->dropped += count;
}

/* The number of chunks evicted together: a small fraction of the limit. */
static uint64_t batch_of(const store *s) {
    const uint64_t eighth = (s->limit >> PYRAMID_CHUNK_SHIFT) / 8;
    return eighth < 1 ? 1 : (eighth < STORE_BATCH ? eighth : STORE_BATCH);
}

/* Evicts the next chunks, unless most of them were used since the last pass of the clock's hand; `all`: in
 * any case. Resets the read counts of chunks that are not mapped. */
static void pass_hand(store *s, bool all) {
    const uint64_t from = s->hand, end = chunk_count(s), batch = batch_of(s);
    uint64_t used = 0, idle = 0, chunk = from;
    for (; chunk < end && used + idle < batch; ++chunk) {
        const unsigned char state = store_state(s, chunk);
        used += state == STORE_USED, idle += state == STORE_IDLE;
        if (state == STORE_USED) exchange(s, chunk, STORE_USED, STORE_IDLE);
        if (state >= STORE_READ) exchange(s, chunk, state, STORE_ABSENT);
    }
    if (all || idle >= used) drop_chunks(s, from, chunk);
    s->hand = chunk < end ? chunk : s->kept >> PYRAMID_CHUNK_SHIFT;
}

/* Other threads may use chunks as fast as the hand passes; then the third round evicts all. */
static void make_room(store *s) {
    const uint64_t batches = (s->limit >> PYRAMID_CHUNK_SHIFT) / batch_of(s) + 2;
    for (uint64_t i = 0; s->resident && s->resident + PYRAMID_CHUNK > s->limit; ++i)
        pass_hand(s, i > 2 * batches);
}

static void map_chunk(store *s, uint64_t chunk) {
    pthread_mutex_lock(&s->lock);
    const bool mapped = is_mapped(store_state(s, chunk));
    if (!mapped) {
        make_room(s);
        count_resident(s, s->resident + PYRAMID_CHUNK);
        __atomic_store_n(&s->states[chunk], STORE_USED, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(&s->lock);
#ifdef MADV_POPULATE_READ
    /* Costs less than a page fault. If it fails, page faults map the chunk. */
    if (!mapped) madvise(s->bytes + (chunk << PYRAMID_CHUNK_SHIFT), PYRAMID_CHUNK, MADV_POPULATE_READ);
#endif
}

bool store_admit(store *s, uint64_t chunk, unsigned lookups) {
    const unsigned char state = store_state(s, chunk);
    if (state == STORE_USED || (state == STORE_IDLE && exchange(s, chunk, STORE_IDLE, STORE_USED)))
        return true;
    const bool full = __atomic_load_n(&s->resident, __ATOMIC_RELAXED) + PYRAMID_CHUNK > s->limit;
    const unsigned reads = state + lookups * STORE_READ;
    if (full && state != STORE_IDLE && reads <= STORE_READS * STORE_READ) {
        /* Other threads may count at the same time; an error of a few reads does not matter. */
        exchange(s, chunk, state, (unsigned char)reads);
        return false;
    }
    map_chunk(s, chunk);
    return true;
}
