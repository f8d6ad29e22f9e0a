/* A lock lies beside its file, since that is replaced again and again. It is gone with the process that held
 * it, however that ended; the empty file stays then, and whoever locks it next removes it. */
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

typedef enum attempt { ATTEMPT_LOCKED, ATTEMPT_TAKEN, ATTEMPT_FAILED, ATTEMPT_AGAIN } attempt;

/* Where the file system knows no locks, nobody is kept out. */
static attempt try_to_lock(file_lock *lock) {
    struct stat info;
    lock->descriptor = open(lock->path, O_RDONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    if (lock->descriptor < 0) return ATTEMPT_FAILED;
    if (flock(lock->descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return ATTEMPT_TAKEN;
    /* Between our opening and locking it who held it before may have removed it. */
    return fstat(lock->descriptor, &info) == 0 && info.st_nlink > 0 ? ATTEMPT_LOCKED : ATTEMPT_AGAIN;
}

static void lock_free(file_lock *lock) {
    if (lock->descriptor >= 0) close(lock->descriptor);
    free(lock);
}

fathom_status file_lock_take(fathom_context *context, const char *path, file_lock **out) {
    *out = NULL;
    file_lock *lock = lock_make(path);
    if (!lock) return fail_memory(context, strlen(path) + sizeof *lock);
    attempt result = try_to_lock(lock);
    while (result == ATTEMPT_AGAIN) {
        close(lock->descriptor);
        result = try_to_lock(lock);
    }
    if (result == ATTEMPT_LOCKED) {
        file_abort_also(lock->path);
        *out = lock;
        return FATHOM_OK;
    }
    const int error = errno;
    lock_free(lock);
    if (result == ATTEMPT_TAKEN)
        return fail_file(context, FATHOM_BAD_USAGE, path,
                         "another render saves its work there; expected another file");
    return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be locked: %s", strerror(error));
}

void file_lock_release(file_lock *lock) {
    if (!lock) return;
    unlink(lock->path);
    file_abort_no_more(lock->path);
    lock_free(lock);
}
