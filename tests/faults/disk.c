/* For LD_PRELOAD: a disk that fails. $FAULT_CALL is write, fsync or rename, $FAULT_FILE a part of the names
 * of the files that are struck, $FAULT_ERROR the number of the error, and $FAULT_AFTER, for write, how many
 * bytes go well before it. The C library's own calls of itself cannot be caught: streams are by fwrite and
 * fclose. */
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_long written;

static long number(const char *name) {
    const char *text = getenv(name);
    return text ? strtol(text, NULL, 10) : 0;
}

static int strikes(const char *call, const char *file) {
    const char *named = getenv("FAULT_CALL"), *part = getenv("FAULT_FILE");
    return named && part && strcmp(named, call) == 0 && strstr(file, part) != NULL;
}

static int strikes_descriptor(const char *call, int descriptor) {
    char link[64], file[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, file, sizeof file - 1);
    if (length < 0) return 0;
    file[length] = '\0';
    return strikes(call, file);
}

/* Whether these bytes are the ones too many. */
static int too_many(int descriptor, size_t bytes) {
    if (!strikes_descriptor("write", descriptor)) return 0;
    if (atomic_fetch_add(&written, (long)bytes) + (long)bytes <= number("FAULT_AFTER")) return 0;
    errno = (int)number("FAULT_ERROR");
    return 1;
}

#define NEXT(name) ((__typeof__(&name))(dlsym(RTLD_NEXT, #name)))

ssize_t write(int descriptor, const void *bytes, size_t count) {
    return too_many(descriptor, count) ? -1 : NEXT(write)(descriptor, bytes, count);
}

ssize_t pwrite(int descriptor, const void *bytes, size_t count, off_t offset) {
    return too_many(descriptor, count) ? -1 : NEXT(pwrite)(descriptor, bytes, count, offset);
}

ssize_t pwrite64(int descriptor, const void *bytes, size_t count, off64_t offset) {
    return too_many(descriptor, count) ? -1 : NEXT(pwrite64)(descriptor, bytes, count, offset);
}

size_t fwrite(const void *bytes, size_t size, size_t count, FILE *stream) {
    return too_many(fileno(stream), size * count) ? 0 : NEXT(fwrite)(bytes, size, count, stream);
}

int fsync(int descriptor) {
    if (!strikes_descriptor("fsync", descriptor)) return NEXT(fsync)(descriptor);
    errno = (int)number("FAULT_ERROR");
    return -1;
}

int rename(const char *from, const char *to) {
    if (!strikes("rename", to)) return NEXT(rename)(from, to);
    errno = (int)number("FAULT_ERROR");
    return -1;
}
