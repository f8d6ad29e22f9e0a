#include "base/file.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* The file is laid over an anonymous mapping that is one page longer: the bytes after it are zero and
 * readable even when it ends with a page. */
static fathom_status map_descriptor(fathom_context *context, const char *path, int descriptor,
                                    file_map *out) {
    struct stat info;
    if (fstat(descriptor, &info) != 0)
        return fail(context, FATHOM_BAD_INPUT, "%s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return fail(context, FATHOM_BAD_INPUT, "%s: is a folder, expected a file", path);
    if (!S_ISREG(info.st_mode)) return fail(context, FATHOM_BAD_INPUT, "%s: is not a regular file", path);
    if (info.st_size == 0) return fail(context, FATHOM_BAD_INPUT, "%s: the file is empty", path);
    size_t size = (size_t)info.st_size, page = (size_t)sysconf(_SC_PAGESIZE);
    size_t reserved = (size + FILE_PADDING + page - 1) / page * page;
    void *base = mmap(NULL, reserved, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (base == MAP_FAILED) return fail_memory(context, reserved);
    if (mmap(base, size, PROT_READ, MAP_PRIVATE | MAP_FIXED, descriptor, 0) == MAP_FAILED) {
        int error = errno;
        munmap(base, reserved);
        return fail(context, FATHOM_BAD_INPUT, "%s: cannot be mapped: %s", path, strerror(error));
    }
    *out = (file_map){base, size, reserved};
    return FATHOM_OK;
}

fathom_status file_open(fathom_context *context, const char *path, file_map *out) {
    *out = (file_map){0};
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return fail(context, FATHOM_BAD_INPUT, "%s: %s", path, strerror(errno));
    fathom_status status = map_descriptor(context, path, descriptor, out);
    close(descriptor);
    return status;
}

void file_close(file_map *map) {
    if (map->bytes) munmap((void *)(uintptr_t)map->bytes, map->reserved);
    *map = (file_map){0};
}

void file_rest(const file_map *map, size_t begin, size_t end) {
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    begin = (begin + page - 1) / page * page, end = end / page * page;
    if (begin < end) madvise((void *)(uintptr_t)(map->bytes + begin), end - begin, MADV_DONTNEED);
}

struct file_writer {
    fathom_context *context;
    FILE *stream;
    int error;
    char *path, *temporary;
};

/* Names of the temporary files there are now, for file_writer_abort_all(); further ones are not known to it.
 */
#define TEMPORARIES_MAX 16
static _Atomic(char *) temporaries[TEMPORARIES_MAX];

static void temporaries_swap(char *old, char *now) {
    for (size_t i = 0; i < TEMPORARIES_MAX; ++i) {
        char *expected = old;
        if (atomic_compare_exchange_strong(&temporaries[i], &expected, now)) return;
    }
}

void file_writer_abort_all(void) {
    for (size_t i = 0; i < TEMPORARIES_MAX; ++i) {
        const char *name = atomic_load(&temporaries[i]);
        if (name) unlink(name);
    }
}

static void writer_free(file_writer *writer) {
    if (writer->temporary) temporaries_swap(writer->temporary, NULL);
    free(writer->path);
    free(writer->temporary);
    free(writer);
}

/* The temporary name keeps the extension, by which libraries choose the format: "out.exr" ->
 * "out.tmp4711.exr". */
static char *temporary_name(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    if (!dot) dot = path + strlen(path);
    size_t room = strlen(path) + 32;
    char *name = malloc(room);
    if (name) snprintf(name, room, "%.*s.tmp%ld%s", (int)(dot - path), path, (long)getpid(), dot);
    return name;
}

fathom_status file_writer_open(fathom_context *context, const char *path, file_writer **out) {
    *out = NULL;
    file_writer *writer = calloc(1, sizeof *writer);
    if (!writer) return fail_memory(context, sizeof *writer);
    writer->context = context;
    writer->path = strdup(path);
    writer->temporary = temporary_name(path);
    if (!writer->path || !writer->temporary) {
        writer_free(writer);
        return fail_memory(context, strlen(path));
    }
    temporaries_swap(NULL, writer->temporary);
    writer->stream = fopen(writer->temporary, "wbe");
    if (!writer->stream) {
        fathom_status status =
            fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be written: %s", path, strerror(errno));
        writer_free(writer);
        return status;
    }
    setvbuf(writer->stream, NULL, _IOFBF, 1u << 20);
    *out = writer;
    return FATHOM_OK;
}

const char *file_writer_temporary(const file_writer *writer) { return writer->temporary; }

int file_writer_descriptor(const file_writer *writer) { return fileno(writer->stream); }

void file_writer_put(file_writer *writer, const void *bytes, size_t size) {
    if (writer->error || !size) return;
    if (fwrite(bytes, 1, size, writer->stream) != size) writer->error = errno ? errno : EIO;
}

fathom_status file_writer_commit(file_writer *writer) {
    fathom_context *context = writer->context;
    int error = writer->error;
    if (fclose(writer->stream) != 0 && !error) error = errno;
    if (!error && rename(writer->temporary, writer->path) != 0) error = errno;
    fathom_status status = FATHOM_OK;
    if (error) {
        unlink(writer->temporary);
        status = fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be written: %s", writer->path,
                      strerror(error));
    }
    writer_free(writer);
    return status;
}

void file_writer_abort(file_writer *writer) {
    if (!writer) return;
    fclose(writer->stream);
    unlink(writer->temporary);
    writer_free(writer);
}

fathom_status file_check_writable(fathom_context *context, const char *path) {
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be written: is not a regular file", path);
    }
    char *folder = file_beside(path, ".");
    if (!folder) return fail_memory(context, strlen(path) + 2);
    int error = faccessat(AT_FDCWD, folder, W_OK | X_OK, AT_EACCESS) == 0 ? 0 : errno;
    free(folder);
    if (error == ENOENT || error == ENOTDIR) {
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be written: its folder does not exist",
                    path);
    }
    if (error) {
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be written: its folder: %s", path,
                    strerror(error));
    }
    return FATHOM_OK;
}

void file_extension(const char *path, char out[16]) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    size_t length = 0;
    if (dot && strlen(dot + 1) < 16) {
        for (const char *c = dot + 1; *c; ++c) out[length++] = (char)tolower((unsigned char)*c);
    }
    out[length] = '\0';
}

char *file_beside(const char *base, const char *name) {
    const char *slash = strrchr(base, '/');
    size_t folder = name[0] == '/' || !slash ? 0 : (size_t)(slash - base) + 1;
    size_t room = folder + strlen(name) + 1;
    char *path = malloc(room);
    if (path) {
        memcpy(path, base, folder);
        memcpy(path + folder, name, room - folder);
    }
    return path;
}
