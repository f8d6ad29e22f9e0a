/* Files mapped for reading, and the guard: a SIGBUS handler for files that shrink while they are mapped.
 *
 * A thread that reads a mapped page past the end of its file gets SIGBUS; it may be a thread of Embree. The
 * guard maps zeros there and marks the file as lost. Work continues, and file_check() reports the loss later.
 * The handler searches a table of mappings without a lock. If the version of a slot is odd, or changes while
 * the slot is read, another thread is changing that slot. The slot of the faulting page cannot be among
 * these. */
#include "base/file.h"

#include "base/opened.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the table of mappings ---- */

typedef struct slot {
    atomic_uint version;
    atomic_uintptr_t begin, end; /* of the mapping; 0: free */
    atomic_bool lost;
} slot;

#define SLOTS 4096 /* beyond this number, files are copied */
static slot slots[SLOTS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards all changes to the table */

static void slot_set(slot *s, uintptr_t begin, uintptr_t end) {
    atomic_fetch_add(&s->version, 1);
    atomic_store(&s->begin, begin);
    atomic_store(&s->end, end);
    atomic_store(&s->lost, false);
    atomic_fetch_add(&s->version, 1);
}

/* NULL when all are taken. */
static slot *slot_take(const void *base, size_t bytes) {
    slot *s = slots, *end = slots + SLOTS;
    pthread_mutex_lock(&lock);
    while (s < end && s->begin) ++s;
    if (s < end) slot_set(s, (uintptr_t)base, (uintptr_t)base + bytes);
    pthread_mutex_unlock(&lock);
    return s < end ? s : NULL;
}

static void slot_return(slot *s) {
    pthread_mutex_lock(&lock);
    slot_set(s, 0, 0);
    pthread_mutex_unlock(&lock);
}

/* ---- the guard ---- */

/* The slot whose mapping contains the address, and the end of that mapping. */
static slot *find_slot(uintptr_t address, uintptr_t *end) {
    for (slot *s = slots; s < slots + SLOTS; ++s) {
        unsigned version = atomic_load(&s->version);
        uintptr_t begin = atomic_load(&s->begin);
        *end = atomic_load(&s->end);
        bool whole = version % 2 == 0 && version == atomic_load(&s->version);
        if (whole && begin && address >= begin && address < *end) return s;
    }
    return NULL;
}

static uintptr_t page_bytes; /* sysconf() may not be called in a signal handler */
static struct sigaction before;

/* Makes only calls that are safe in a signal handler; mmap() is a plain system call. */
static void on_bus_error(int number, siginfo_t *info, void *machine) {
    int error = errno;
    uintptr_t address = (uintptr_t)info->si_addr, end;
    slot *s = info->si_code > 0 ? find_slot(address, &end) : NULL; /* otherwise a process sent the signal */
    if (s) {
        /* All following pages of the mapping lie past the end of the file too. */
        uintptr_t page = address / page_bytes * page_bytes;
        atomic_store(&s->lost, true);
        void *zeros =
            mmap((void *)page, end - page, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
        errno = error;
        if (zeros != MAP_FAILED) return;
    }
    if (before.sa_flags & SA_SIGINFO) {
        before.sa_sigaction(number, info, machine);
    } else if (before.sa_handler != SIG_DFL && before.sa_handler != SIG_IGN) {
        before.sa_handler(number);
    } else if (before.sa_handler == SIG_DFL || info->si_code > 0) { /* a fault cannot be ignored */
        signal(number, SIG_DFL);
        raise(number);
    }
}

static void install_guard(void) {
    page_bytes = (uintptr_t)sysconf(_SC_PAGESIZE);
    struct sigaction action = {.sa_sigaction = on_bus_error, .sa_flags = SA_SIGINFO | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGBUS, &action, &before);
}

void fathom_guard_files(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, install_guard);
}

/* ---- mapping ---- */

/* FATHOM_OUT_OF_RESOURCES for lack of memory or descriptors, else FATHOM_BAD_INPUT. */
static fathom_status status_of(int error) {
    bool exhausted = error == ENOMEM || error == EMFILE || error == ENFILE;
    return exhausted ? FATHOM_OUT_OF_RESOURCES : FATHOM_BAD_INPUT;
}

struct file_record {
    slot *slot;
    struct stat stamp; /* of the file when it was mapped */
    char path[];
};

/* Maps the file over a longer anonymous mapping, so that zeros follow it even if it fills its last page. */
static fathom_status map_bytes(fathom_context *context, const char *path, int descriptor,
                               const struct stat *info, slot *guarded, file_map *map) {
    size_t length = strlen(path) + 1;
    map->record = calloc(1, sizeof *map->record + length);
    if (!map->record) {
        slot_return(guarded);
        return fail_memory(context, sizeof *map->record + length);
    }
    *map->record = (struct file_record){.slot = guarded, .stamp = *info};
    memcpy(map->record->path, path, length);
    void *base = (void *)(uintptr_t)map->bytes;
    if (mmap(base, map->size, PROT_READ, MAP_PRIVATE | MAP_FIXED, descriptor, 0) != MAP_FAILED)
        return FATHOM_OK;
    return fail_file(context, status_of(errno), path, "cannot be mapped: %s", strerror(errno));
}

static fathom_status fail_truncated(fathom_context *context, const char *path, size_t left, size_t size) {
    return fail_file(context, FATHOM_BAD_INPUT, path,
                     "was truncated while it was read: %zu bytes are left of %zu; try again when it is whole",
                     left, size);
}

static fathom_status copy_bytes(fathom_context *context, const char *path, int descriptor, file_map *map) {
    unsigned char *base = (unsigned char *)(uintptr_t)map->bytes;
    if (mprotect(base, map->reserved, PROT_READ | PROT_WRITE) != 0)
        return fail_memory(context, map->reserved);
    for (size_t done = 0; done < map->size;) {
        ssize_t got = read(descriptor, base + done, map->size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return fail_file(context, status_of(errno), path, "%s", strerror(errno));
        if (got == 0) return fail_truncated(context, path, done, map->size);
        done += (size_t)got;
    }
    return FATHOM_OK;
}

static fathom_status open_descriptor(fathom_context *context, const char *path, int descriptor,
                                     file_map *out) {
    struct stat info;
    if (fstat(descriptor, &info) != 0)
        return fail_file(context, status_of(errno), path, "%s", strerror(errno));
    if (S_ISDIR(info.st_mode))
        return fail_file(context, FATHOM_BAD_INPUT, path, "is a folder, expected a file");
    if (!S_ISREG(info.st_mode))
        return fail_file(context, FATHOM_BAD_INPUT, path, "is not a regular file; expected one on a disk");
    if (context_is_output(context, &info))
        return fail_file(context, FATHOM_BAD_USAGE, path,
                         "is input and output at once; expected another output");
    if (info.st_size == 0) return fail_file(context, FATHOM_BAD_INPUT, path, "the file is empty");
    size_t size = (size_t)info.st_size, page = (size_t)sysconf(_SC_PAGESIZE);
    size_t reserved = (size + FILE_PADDING + page - 1) / page * page;
    void *base = mmap(NULL, reserved, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (base == MAP_FAILED) return fail_memory(context, reserved);
    *out = (file_map){.bytes = base, .size = size, .reserved = reserved};
    slot *guarded = context_copies_files(context) ? NULL : slot_take(base, reserved);
    return guarded ? map_bytes(context, path, descriptor, &info, guarded, out)
                   : copy_bytes(context, path, descriptor, out);
}

fathom_status file_open(fathom_context *context, const char *path, file_map *out) {
    *out = (file_map){0};
    /* The flags avoid waiting for a pipe and acquiring a controlling terminal. */
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) return fail_file(context, status_of(errno), path, "%s", strerror(errno));
    fathom_status status = open_descriptor(context, path, descriptor, out);
    close(descriptor);
    if (status == FATHOM_OK && !context_add_opened(context, path))
        status = fail_memory(context, strlen(path));
    if (status != FATHOM_OK) file_close(out);
    return status;
}

void file_close(file_map *map) {
    if (map->bytes) munmap((void *)(uintptr_t)map->bytes, map->reserved);
    if (map->record) slot_return(map->record->slot);
    free(map->record);
    *map = (file_map){0};
}

fathom_status file_check(fathom_context *context, const file_map *map) {
    const struct file_record *record = map->record;
    if (!record) return FATHOM_OK;
    struct stat now, then = record->stamp;
    const char *path = record->path;
    /* A mapping keeps its file even if the path now refers to another file. */
    const bool same = stat(path, &now) == 0 && now.st_dev == then.st_dev && now.st_ino == then.st_ino;
    if (same && now.st_size < then.st_size)
        return fail_truncated(context, path, (size_t)now.st_size, map->size);
    if (atomic_load(&record->slot->lost))
        return fail_file(
            context, FATHOM_BAD_INPUT, path,
            "was truncated while it was read, or cannot be read to its end; try again when it is whole");
    if (same && (now.st_size != then.st_size || now.st_mtim.tv_sec != then.st_mtim.tv_sec ||
                 now.st_mtim.tv_nsec != then.st_mtim.tv_nsec))
        return fail_file(context, FATHOM_BAD_INPUT, path,
                         "was changed while it was read; try again when nothing writes to it");
    return FATHOM_OK;
}

fathom_status file_finish(fathom_context *context, file_map *map, fathom_status status) {
    /* If the file changed, that explains any error found in it. */
    fathom_status changed =
        status == FATHOM_OK || status == FATHOM_BAD_INPUT ? file_check(context, map) : FATHOM_OK;
    file_close(map);
    return changed == FATHOM_OK ? status : changed;
}

void file_rest(const file_map *map, size_t begin, size_t end) {
    if (!map->record) return; /* the contents of a copy would be lost */
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    begin = (begin + page - 1) / page * page, end = end / page * page;
    if (begin < end) madvise((void *)(uintptr_t)(map->bytes + begin), end - begin, MADV_DONTNEED);
}
