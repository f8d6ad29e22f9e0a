/* Writing a whole file or none.
 *
 * Bytes go to a temporary file next to the target. It takes the target's name once they are on the disk, so a
 * killed process or a power cut leaves either the old file or the new one. The writer holds a lock (flock) on
 * its temporary file, and the lock ends with the process: an unlocked temporary file is left over from a
 * killed process and may be removed. */
#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

struct file_writer {
    fathom_context *context;
    FILE *stream;
    int error;
    char *path, *temporary; /* `temporary` is NULL when writing to memory */
    char *bytes;            /* only when writing to memory: the stream's content after a flush */
    size_t size;
};

/* ---- for a signal handler ---- */

/* The existing temporary files, for fathom_file_abandon_all(). Further ones are not removed by it. */
#define TEMPORARIES_MAX 16
static _Atomic(char *) temporaries[TEMPORARIES_MAX];

static void temporaries_swap(char *old, char *now) {
    for (size_t i = 0; i < TEMPORARIES_MAX; ++i) {
        char *expected = old;
        if (atomic_compare_exchange_strong(&temporaries[i], &expected, now)) return;
    }
}

void fathom_file_abandon_also(char *path) { temporaries_swap(NULL, path); }

void fathom_file_abandon_no_more(char *path) { temporaries_swap(path, NULL); }

void fathom_file_abandon_all(void) {
    for (size_t i = 0; i < TEMPORARIES_MAX; ++i) {
        const char *name = atomic_load(&temporaries[i]);
        if (name) unlink(name);
    }
}

/* ---- names of temporary files ---- */

#define MARK ".fathom-tmp"
#define NUMBERS 16 /* bytes for the process id and the attempt */
#define EXTENSION_MOST 16

/* Sets *extension to its start, and returns how many bytes before it are kept. */
static size_t split(const char *name, const char **extension) {
    const char *dot = name + file_stem_length(name);
    *extension = strlen(dot) <= EXTENSION_MOST ? dot : name + strlen(name);
    const size_t stem = (size_t)(*extension - name),
                 most = NAME_MAX - strlen(MARK) - NUMBERS - strlen(*extension);
    return stem <= most ? stem : file_name_cut(name, most);
}

/* A temporary name next to `path`. It keeps the extension, by which libraries choose the format: "out.exr"
 * becomes "out.fathom-tmp4711.exr", or "out.fathom-tmp4711-1.exr" at the next attempt; 4711 is the process
 * id. Names that are too long are cut before the extension. NULL: no memory. */
static char *temporary_name(const char *path, unsigned attempt) {
    const char *name = file_name(path), *extension;
    const size_t kept = (size_t)(name - path) + split(name, &extension),
                 room = strlen(path) + strlen(MARK) + 32;
    char *out = malloc(room), again[16] = "";
    if (attempt) snprintf(again, sizeof again, "-%u", attempt);
    if (out) snprintf(out, room, "%.*s" MARK "%ld%s%s", (int)kept, path, (long)getpid(), again, extension);
    return out;
}

/* True if `name` is that of a temporary file for `target`; both without folders. */
static bool temporary_is_of(const char *name, const char *target) {
    const char *extension;
    const size_t kept = split(target, &extension);
    if (strncmp(name, target, kept) != 0) return false;
    const char *rest = name + kept;
    if (strncmp(rest, MARK, strlen(MARK)) != 0) return false;
    rest += strlen(MARK);
    size_t digits = strspn(rest, "0123456789");
    if (!digits) return false;
    rest += digits;
    if (*rest == '-') rest += 1 + strspn(rest + 1, "0123456789");
    return strcmp(rest, extension) == 0;
}

/* ---- temporary files ---- */

/* Locks the file and checks that it has not been removed since it was opened. On a file system without locks
 * it counts as locked, and no file counts as left over. */
static bool lock_named(int descriptor) {
    struct stat info;
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return errno != EWOULDBLOCK;
    return fstat(descriptor, &info) == 0 && info.st_nlink > 0;
}

static void remove_unlocked(int folder, const char *name) {
    int descriptor = openat(folder, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) return;
    struct stat info;
    if (fstat(descriptor, &info) == 0 && S_ISREG(info.st_mode) && flock(descriptor, LOCK_EX | LOCK_NB) == 0)
        unlinkat(folder, name, 0);
    close(descriptor);
}

void fathom_file_remove_left_over(const char *path) {
    if (!path) return;
    char *beside = file_beside(path, ".");
    DIR *folder = beside ? opendir(beside) : NULL;
    free(beside);
    if (!folder) return;
    for (const struct dirent *entry; (entry = readdir(folder));)
        if (temporary_is_of(entry->d_name, file_name(path))) remove_unlocked(dirfd(folder), entry->d_name);
    closedir(folder);
}

/* ---- writing ---- */

static fathom_status cannot_write(fathom_context *context, const char *path, int error) {
    return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be written: %s", strerror(error));
}

static void writer_free(file_writer *writer) {
    if (writer->temporary) temporaries_swap(writer->temporary, NULL);
    free(writer->path);
    free(writer->temporary);
    free(writer->bytes);
    free(writer);
}

/* Processes in two containers may have the same id and write to the same folder, so several names are
 * tried. */
#define ATTEMPTS 100u

/* Never opens an existing file: somebody else may have put another file there under that name. */
static int open_new(const char *name, mode_t mode) {
    int descriptor = open(name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
    remove_unlocked(AT_FDCWD, name);
    errno = EEXIST;
    return -1;
}

/* Returns -1 and sets errno on failure. A file that replaces another is private until it gets the permissions
 * of the old file. The name is noted before there is a file, so that no signal in between leaves one. */
static int open_temporary(file_writer *writer) {
    struct stat old;
    const bool replaces = lstat(writer->path, &old) == 0 && S_ISREG(old.st_mode);
    for (unsigned attempt = 0; attempt < ATTEMPTS; ++attempt) {
        writer->temporary = temporary_name(writer->path, attempt);
        if (!writer->temporary) return -1;
        temporaries_swap(NULL, writer->temporary);
        int descriptor = open_new(writer->temporary, replaces ? 0600 : 0666);
        if (descriptor < 0 && errno != EEXIST) return -1;
        if (descriptor >= 0 && lock_named(descriptor)) {
            if (replaces) (void)!fchmod(descriptor, old.st_mode & 0777);
            return descriptor;
        }
        if (descriptor >= 0) close(descriptor);
        temporaries_swap(writer->temporary, NULL);
        free(writer->temporary);
        writer->temporary = NULL;
    }
    errno = EBUSY;
    return -1;
}

/* NULL: no memory. */
static file_writer *writer_make(fathom_context *context, const char *path) {
    file_writer *writer = calloc(1, sizeof *writer);
    if (!writer) return NULL;
    writer->context = context;
    writer->path = strdup(path);
    if (writer->path) return writer;
    writer_free(writer);
    return NULL;
}

fathom_status file_writer_open_memory(fathom_context *context, const char *name, file_writer **out) {
    *out = NULL;
    file_writer *writer = writer_make(context, name);
    if (!writer) return fail_memory(context, sizeof *writer);
    writer->stream = open_memstream(&writer->bytes, &writer->size);
    if (!writer->stream) {
        writer_free(writer);
        return fail_memory(context, 1);
    }
    *out = writer;
    return FATHOM_OK;
}

fathom_status file_writer_open(fathom_context *context, const char *path, file_writer **out) {
    *out = NULL;
    file_writer *writer = writer_make(context, path);
    if (!writer) return fail_memory(context, sizeof *writer);
    int descriptor = open_temporary(writer);
    writer->stream = descriptor < 0 ? NULL : fdopen(descriptor, "wb");
    if (!writer->stream) {
        fathom_status status = cannot_write(context, path, errno);
        if (descriptor >= 0) close(descriptor), unlink(writer->temporary);
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

static void seek(file_writer *writer, off_t at, int from) {
    if (!writer->error && fseeko(writer->stream, at, from) != 0) writer->error = errno;
}

void file_writer_put_at(file_writer *writer, uint64_t at, const void *bytes, size_t size) {
    seek(writer, (off_t)at, SEEK_SET);
    file_writer_put(writer, bytes, size);
    seek(writer, 0, SEEK_END);
}

void file_writer_print(file_writer *writer, const char *format, ...) {
    va_list args;
    va_start(args, format);
    if (!writer->error && vfprintf(writer->stream, format, args) < 0) writer->error = errno ? errno : EIO;
    va_end(args);
}

/* Some file systems do not support syncing; the errors that say so are ignored. */
static int sync_descriptor(int descriptor) {
    if (fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS) return 0;
    return errno;
}

/* Syncs the folder, so that the new name is on the disk. Does nothing if the folder cannot be opened. */
static int sync_folder(const char *path) {
    char *beside = file_beside(path, ".");
    int descriptor = beside ? open(beside, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    free(beside);
    if (descriptor < 0) return 0;
    int error = sync_descriptor(descriptor);
    close(descriptor);
    return error;
}

void file_writer_sync(file_writer *writer) {
    if (fflush(writer->stream) != 0 && !writer->error) writer->error = errno;
    int error = writer->error ? 0 : sync_descriptor(fileno(writer->stream));
    if (error) writer->error = error;
}

/* Renames before closing the stream, because closing ends the lock that protects the file. */
fathom_status file_writer_commit(file_writer *writer) {
    fathom_context *context = writer->context;
    file_writer_sync(writer);
    int error = writer->error;
    bool renamed = !error && rename(writer->temporary, writer->path) == 0;
    if (!error && !renamed) error = errno;
    if (fclose(writer->stream) != 0 && !error) error = errno;
    if (!error) error = sync_folder(writer->path);
    fathom_status status = FATHOM_OK;
    if (error) {
        if (!renamed) unlink(writer->temporary);
        status = cannot_write(context, writer->path, error);
    }
    writer_free(writer);
    return status;
}

fathom_status file_writer_take(file_writer *writer, unsigned char **bytes, size_t *size) {
    bool fine = fclose(writer->stream) == 0 && !writer->error;
    fathom_status status = fine ? FATHOM_OK : fail_memory(writer->context, writer->size);
    *bytes = fine ? (unsigned char *)writer->bytes : NULL;
    *size = fine ? writer->size : 0;
    if (fine) writer->bytes = NULL;
    writer_free(writer);
    return status;
}

void file_writer_abort(file_writer *writer) {
    if (!writer) return;
    if (writer->temporary) unlink(writer->temporary);
    fclose(writer->stream);
    writer_free(writer);
}

/* ---- checks before writing ---- */

/* Quotas and full disks are detected only by writing something. */
#define PROBE_BYTES 4096u

static fathom_status probe(fathom_context *context, const char *path) {
    static const char zeros[PROBE_BYTES];
    file_writer *writer;
    fathom_status status = file_writer_open(context, path, &writer);
    if (status != FATHOM_OK) return status;
    file_writer_put(writer, zeros, sizeof zeros);
    int error = fflush(writer->stream) == 0 ? writer->error : errno;
    file_writer_abort(writer);
    return error ? cannot_write(context, path, error) : FATHOM_OK;
}

/* The errno with which replacing the file would fail later, or 0. A file without write permission could be
 * replaced, but is refused: its owner clearly wants to keep it. */
static int refusal(const char *path, const char *folder) {
    struct stat info, above;
    struct statx more;
    if (lstat(path, &info) != 0) return errno == ENAMETOOLONG ? errno : 0;
    if (S_ISREG(info.st_mode) && faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0) return errno;
    const uid_t user = geteuid();
    if (user != 0 && info.st_uid != user && stat(folder, &above) == 0 && above.st_mode & S_ISVTX &&
        above.st_uid != user)
        return EPERM;
    const bool mounted = statx(AT_FDCWD, path, AT_SYMLINK_NOFOLLOW, 0, &more) == 0 &&
                         more.stx_attributes & STATX_ATTR_MOUNT_ROOT;
    return mounted ? EBUSY : 0;
}

static fathom_status check_folder(fathom_context *context, const char *path, const char *folder) {
    int error = faccessat(AT_FDCWD, folder, W_OK | X_OK, AT_EACCESS) == 0 ? 0 : errno;
    if (!error) return FATHOM_OK;
    const bool none = error == ENOENT || error == ENOTDIR;
    return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be written: its folder%s%s",
                     none ? " does not exist" : ": ", none ? "" : strerror(error));
}

fathom_status fathom_file_check(fathom_context *context, const char *path) {
    struct stat info;
    if (!context || !path) return fail_null(context, "path");
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be written: is not a regular file");
    char *folder = file_beside(path, ".");
    if (!folder) return fail_memory(context, strlen(path) + 2);
    fathom_status status = check_folder(context, path, folder);
    int error = status == FATHOM_OK ? refusal(path, folder) : 0;
    free(folder);
    if (error) status = cannot_write(context, path, error);
    if (status == FATHOM_OK) fathom_file_remove_left_over(path);
    return status == FATHOM_OK ? probe(context, path) : status;
}

fathom_status fathom_file_write(fathom_context *context, const char *path, const void *bytes, size_t size) {
    if (!context || !path) return fail_null(context, "path");
    if (!bytes && size) return fail_null(context, "bytes");
    file_writer *writer;
    fathom_status status = file_writer_open(context, path, &writer);
    if (status != FATHOM_OK) return status;
    file_writer_put(writer, bytes, size);
    return file_writer_commit(writer);
}
