#include "base/file_witness.h"

#include "base/hash.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct file_witness {
    pthread_mutex_t lock; /* of all that follows but the path */
    struct stat stamp;    /* of the bytes that were mapped */
    double opened;        /* clock_seconds() */
    hash hash;
    off_t hashed; /* bytes from the beginning; all of them: `hash` is that of the file */
    file_state state;
    size_t left;
    bool touched;
    char path[];
};

file_witness *witness_create(const char *path, const struct stat *info, double now) {
    size_t length = strlen(path) + 1;
    file_witness *w = malloc(sizeof *w + length);
    if (!w) return NULL;
    *w = (file_witness){.stamp = *info, .opened = now};
    pthread_mutex_init(&w->lock, NULL);
    hash_begin(&w->hash);
    memcpy(w->path, path, length);
    return w;
}

void witness_destroy(file_witness *w) {
    if (!w) return;
    pthread_mutex_destroy(&w->lock);
    free(w);
}

const char *witness_path(const file_witness *w) { return w->path; }

/* ---- stamps ---- */

static bool same_time(struct timespec a, struct timespec b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

static bool same_file(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* Not written to between the two, unless somebody set the time back. */
static bool same_writing(const struct stat *a, const struct stat *b) {
    return a->st_size == b->st_size && same_time(a->st_mtim, b->st_mtim);
}

/* Nothing done to it at all: this time cannot be set. */
static bool same_stamp(const struct stat *a, const struct stat *b) {
    return same_file(a, b) && same_writing(a, b) && same_time(a->st_ctim, b->st_ctim);
}

/* ---- bytes ---- */

#define PIECE_BYTES ((size_t)1 << 14) /* small stacks have room for it */

/* The file is read rather than its mapping: what rendering has no use for stays out of the process's memory.
 * False where it cannot be read, or ends before. */
static bool hash_range(int descriptor, off_t from, off_t to, hash *h) {
    unsigned char piece[PIECE_BYTES];
    while (from < to) {
        size_t want = to - from < (off_t)PIECE_BYTES ? (size_t)(to - from) : PIECE_BYTES;
        ssize_t got = pread(descriptor, piece, want, from);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        hash_put(h, piece, (size_t)got);
        from += got;
    }
    return true;
}

/* Hashes on, of a file that has this stamp before and after. False, and nothing is done, where it has not:
 * whoever looks next sees why. */
static bool hash_settled(const file_witness *w, const struct stat *stamp, off_t from, off_t to, hash *h) {
    struct stat before, after;
    int descriptor = open(w->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) return false;
    hash more = *h;
    bool fine = fstat(descriptor, &before) == 0 && same_stamp(&before, stamp) &&
                hash_range(descriptor, from, to, &more) && fstat(descriptor, &after) == 0 &&
                same_stamp(&after, stamp);
    close(descriptor);
    if (fine) *h = more;
    return fine;
}

static off_t affordable(const file_witness *w, double now) {
    double later = now - w->opened - WITNESS_AFTER;
    double bytes = (double)WITNESS_AT_ONCE + (later > 0 ? later * WITNESS_RATE : 0);
    return bytes < (double)w->stamp.st_size ? (off_t)bytes : w->stamp.st_size;
}

static void learn(file_witness *w, double now) {
    off_t to = affordable(w, now);
    if (to > w->hashed && hash_settled(w, &w->stamp, w->hashed, to, &w->hash)) w->hashed = to;
}

/* Who touches many files may come between: a few times are waited for. */
#define SETTLING_TRIES 4

static bool holds_same_bytes(const file_witness *w, struct stat *now) {
    if (w->hashed < w->stamp.st_size) return false;
    for (int i = 0; i < SETTLING_TRIES; ++i) {
        hash h;
        hash_begin(&h);
        if (hash_settled(w, now, 0, now->st_size, &h)) return hash_end(&h) == hash_end(&w->hash);
        if (stat(w->path, now) != 0 || !same_file(now, &w->stamp) || now->st_size != w->stamp.st_size)
            return false;
    }
    return false;
}

/* ---- looking ---- */

/* A stamp that is new in its last part alone comes of renaming, linking, or changing rights; and of writing
 * with the time set back, which only those bytes show that were known. */
static file_state compare(file_witness *w, struct stat *now) {
    if (now->st_size < w->stamp.st_size) {
        w->left = (size_t)now->st_size;
        return FILE_TRUNCATED;
    }
    bool written = !same_writing(&w->stamp, now), known = w->hashed == w->stamp.st_size;
    if (now->st_size > w->stamp.st_size || ((written || known) && !holds_same_bytes(w, now)))
        return FILE_CHANGED;
    w->touched |= written;
    w->stamp = *now;
    return FILE_SAME;
}

static void look(file_witness *w, double now) {
    struct stat info;
    if (w->state != FILE_SAME || stat(w->path, &info) != 0 || !same_file(&info, &w->stamp)) return;
    if (!same_stamp(&info, &w->stamp)) w->state = compare(w, &info);
    if (w->state == FILE_SAME) learn(w, now);
}

file_state witness_look(file_witness *w, double now, size_t *left) {
    pthread_mutex_lock(&w->lock);
    look(w, now);
    file_state state = w->state;
    *left = w->left;
    pthread_mutex_unlock(&w->lock);
    return state;
}

bool witness_take_touched(file_witness *w) {
    pthread_mutex_lock(&w->lock);
    bool touched = w->touched;
    w->touched = false;
    pthread_mutex_unlock(&w->lock);
    return touched;
}
