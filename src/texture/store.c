#include "texture/store.h"

#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* $TMPDIR; else a folder that is on a disk, as /tmp often is not. */
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
        "cannot hold a temporary file of %.1f GB for textures: %s; name another folder in $TMPDIR",
        (double)size * 1e-9, strerror(errno));
}

/* Maps a file of its own at `at`, inside the reserved addresses. */
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

bool store_write_file(int descriptor, uint64_t offset, const void *bytes, size_t size) {
    const char *from = bytes;
    while (size) {
        const ssize_t n = pwrite(descriptor, from, size, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = ENOSPC;
        if (n <= 0) return false;
        from += n, size -= (size_t)n, offset += (uint64_t)n;
    }
    return true;
}

bool store_write(store *s, uint64_t offset, const void *bytes, size_t size) {
    const bool kept = offset < s->kept;
    return store_write_file(kept ? s->memory : s->disk, kept ? offset : offset - s->kept, bytes, size);
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
}

/* A chunk that was used since the hand came by gets another round; one that was read is forgotten. */
static void pass_hand(store *s) {
    const uint64_t chunk = s->hand;
    const unsigned char state = store_state(s, chunk);
    s->hand = s->hand + 1 < s->size >> PYRAMID_CHUNK_SHIFT ? s->hand + 1 : s->kept >> PYRAMID_CHUNK_SHIFT;
    if (state == STORE_USED) {
        exchange(s, chunk, STORE_USED, STORE_IDLE);
    } else if (state >= STORE_READ) {
        exchange(s, chunk, state, STORE_ABSENT);
    } else if (state == STORE_IDLE && exchange(s, chunk, STORE_IDLE, STORE_ABSENT)) {
        madvise(s->bytes + (chunk << PYRAMID_CHUNK_SHIFT), PYRAMID_CHUNK, MADV_DONTNEED);
        count_resident(s, s->resident - PYRAMID_CHUNK), ++s->dropped;
    }
}

static void map_chunk(store *s, uint64_t chunk) {
    pthread_mutex_lock(&s->lock);
    const unsigned char state = store_state(s, chunk);
    if (state != STORE_IDLE && state != STORE_USED) {
        while (s->resident && s->resident + PYRAMID_CHUNK > s->limit) pass_hand(s);
        count_resident(s, s->resident + PYRAMID_CHUNK);
        __atomic_store_n(&s->states[chunk], STORE_USED, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(&s->lock);
}

bool store_admit(store *s, uint64_t chunk, unsigned lookups) {
    const unsigned char state = store_state(s, chunk);
    if (state == STORE_USED || (state == STORE_IDLE && exchange(s, chunk, STORE_IDLE, STORE_USED)))
        return true;
    const bool full = __atomic_load_n(&s->resident, __ATOMIC_RELAXED) + PYRAMID_CHUNK > s->limit;
    const unsigned reads = state + lookups * STORE_READ;
    if (full && state != STORE_IDLE && reads <= STORE_READS * STORE_READ) {
        /* Others may count at the same time; a few reads more or less do not matter. */
        exchange(s, chunk, state, (unsigned char)reads);
        return false;
    }
    map_chunk(s, chunk);
    return true;
}
