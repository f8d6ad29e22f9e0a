/* The lock is a separate file, because the locked file itself is replaced repeatedly. The lock ends with its
 * process. If the process is killed, the empty lock file remains until the next process takes and releases
 * the lock. */
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define MARK ".fathom-lock"

struct file_lock {
    int descriptor;
    char path[];
};

/* NULL: no memory. */
static file_lock *lock_make(const char *path) {
    const char *name = file_name(path);
    const size_t kept = (size_t)(name - path) + file_name_cut(name, NAME_MAX - strlen(MARK)),
                 room = kept + sizeof MARK;
    file_lock *lock = malloc(sizeof *lock + room);
    if (!lock) return NULL;
    lock->descriptor = -1;
    snprintf(lock->path, room, "%.*s" MARK, (int)kept, path);
    return lock;
}

static void lock_free(file_lock *lock) {
    if (lock->descriptor >= 0) close(lock->descriptor);
    free(lock);
}

/* On a file system without locks, this always succeeds. */
static fathom_status lock_open(fathom_context *context, const char *path, file_lock *lock) {
    struct stat info;
    do {
        if (lock->descriptor >= 0) close(lock->descriptor);
        lock->descriptor = open(lock->path, O_RDONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
        if (lock->descriptor < 0)
            return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be locked: %s", strerror(errno));
        if (flock(lock->descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
            return fail_file(context, FATHOM_BAD_USAGE, path,
                             "another render saves its work there; expected another file");
        /* Its last holder may have removed it between open() and flock(). */
    } while (fstat(lock->descriptor, &info) != 0 || info.st_nlink == 0);
    return FATHOM_OK;
}

fathom_status file_lock_take(fathom_context *context, const char *path, file_lock **out) {
    *out = NULL;
    file_lock *lock = lock_make(path);
    if (!lock) return fail_memory(context, strlen(path) + sizeof *lock);
    fathom_status status = lock_open(context, path, lock);
    if (status != FATHOM_OK) {
        lock_free(lock);
        return status;
    }
    fathom_file_abandon_also(lock->path);
    *out = lock;
    return FATHOM_OK;
}

void file_lock_release(file_lock *lock) {
    if (!lock) return;
    unlink(lock->path);
    fathom_file_abandon_no_more(lock->path);
    lock_free(lock);
}
