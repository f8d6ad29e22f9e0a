/* Transfers the files of a scene to ranks that cannot open them. Such a rank requests one piece after another
 * from rank 0. Rank 0 replies while it renders, from the files that it has read:
 *
 *     FILE_WANTED: number of the file, offset ──▶ rank 0
 *     FILE_PIECE: number of files; size and name of this file; a piece of its bytes
 *
 * The copies keep their names relative to the scene's folder, in a private folder. */
#include "job/ranks/ranks_files.h"

#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PIECE ((size_t)1 << 20)
#define LOOK_NANOSECONDS 1000000

typedef struct file_wanted {
    message head; /* count: index of the file */
    uint64_t at;
} file_wanted;

/* The bytes follow. */
typedef struct file_piece {
    message head;    /* count: number of files; 0: this file cannot be sent */
    uint64_t size;   /* size of the file */
    char name[1024]; /* relative to the scene's folder; if the file cannot be sent: its path */
} file_piece;

/* ---- rank 0 ---- */

/* The path relative to the folder of the first file, the scene; NULL: it is not below that folder. */
static const char *name_below(const char *scene, const char *path) {
    const size_t folder = (size_t)(file_name(scene) - scene);
    if (strncmp(path, scene, folder) != 0) return NULL;
    const char *name = path + folder;
    return *name == '/' || file_climbs_out(name) || strlen(name) >= sizeof((file_piece *)0)->name ? NULL
                                                                                                  : name;
}

static bool read_piece(const char *path, uint64_t at, file_piece *out, size_t *bytes) {
    struct stat info;
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    const ssize_t got = pread(file, out + 1, PIECE, (off_t)at);
    const bool fine = fstat(file, &info) == 0 && got >= 0;
    close(file);
    *bytes = fine ? (size_t)got : 0;
    out->size = fine ? (uint64_t)info.st_size : 0;
    return fine;
}

bool ranks_answer_file(const fathom_ranks *ranks, const fathom_context *context, uint32_t from,
                       const unsigned char *body, size_t size, uint32_t index) {
    uint64_t at;
    size_t bytes = 0;
    const size_t count = context_opened_count(context);
    if (size != sizeof at || index >= count) return false;
    memcpy(&at, body, sizeof at);
    file_piece *piece = calloc(1, sizeof *piece + PIECE);
    if (!piece) return false;
    const char *path = context_opened(context, index), *name = name_below(context_opened(context, 0), path);
    const bool fine = name && at <= INT64_MAX && read_piece(path, at, piece, &bytes);
    piece->head = (message){FILE_PIECE, fine ? (uint32_t)count : 0};
    snprintf(piece->name, sizeof piece->name, "%s", fine ? name : path);
    const bool sent = ranks->send(ranks->user, from, piece, sizeof *piece + bytes);
    free(piece);
    return sent;
}

/* ---- others ---- */

typedef struct fetching {
    fathom_context *context;
    const fathom_ranks *ranks;
    bool (*stopped)(void);
    char folder[PATH_MAX], path[PATH_MAX];
    file_piece piece; /* the last piece; its bytes belong to the message */
    const unsigned char *bytes;
    size_t count;
} fetching;

static fathom_status receive_piece(fetching *f) {
    const struct timespec pause = {0, LOOK_NANOSECONDS};
    const void *got;
    uint32_t from;
    size_t size;
    while (!f->ranks->receive(f->ranks->user, &from, &got, &size)) {
        if (f->stopped && f->stopped()) return fail(f->context, FATHOM_INTERRUPTED, "stopped while reading");
        nanosleep(&pause, NULL);
    }
    if (size < sizeof f->piece) return fail(f->context, FATHOM_BAD_INPUT, "rank 0 sent no file");
    memcpy(&f->piece, got, sizeof f->piece);
    f->piece.name[sizeof f->piece.name - 1] = '\0';
    f->bytes = (const unsigned char *)got + sizeof f->piece;
    f->count = size - sizeof f->piece;
    if (f->piece.head.kind == FILE_PIECE && f->piece.head.count) return FATHOM_OK;
    return fail_file(
        f->context, FATHOM_BAD_INPUT, f->piece.name,
        "cannot be opened by rank %u, and rank 0 cannot send it; expected a file below the folder of "
        "the scene, or one that all ranks can open",
        f->ranks->rank);
}

static fathom_status ask(fetching *f, uint32_t index, uint64_t at) {
    const file_wanted wanted = {{FILE_WANTED, index}, at};
    if (!f->ranks->send(f->ranks->user, 0, &wanted, sizeof wanted))
        return fail_memory(f->context, sizeof wanted);
    return receive_piece(f);
}

static fathom_status cannot_write(const fetching *f) {
    return fail_file(
        f->context, FATHOM_OUT_OF_RESOURCES, f->path,
        "rank %u gets the scene's files from rank 0, and cannot write them: %s; name another folder in "
        "$TMPDIR",
        f->ranks->rank, strerror(errno));
}

/* Also creates the folders above the file. Names come from rank 0; rejects names that lead out of the
 * folder. */
static int create_file(fetching *f) {
    const char *name = f->piece.name;
    if (*name == '/' || file_climbs_out(name) ||
        snprintf(f->path, sizeof f->path, "%s/%s", f->folder, name) >= (int)sizeof f->path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    for (char *slash = f->path + strlen(f->folder) + 1; (slash = strchr(slash, '/')) != NULL; ++slash) {
        *slash = '\0';
        (void)!mkdir(f->path, 0700);
        *slash = '/';
    }
    return open(f->path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
}

static fathom_status fetch_file(fetching *f, uint32_t index, uint32_t *all) {
    fathom_status status = ask(f, index, 0);
    if (status != FATHOM_OK) return status;
    *all = f->piece.head.count;
    const int file = create_file(f);
    if (file < 0) return cannot_write(f);
    for (uint64_t at = 0; status == FATHOM_OK;) {
        if (!file_write_at(file, at, f->bytes, f->count)) status = cannot_write(f);
        at += f->count;
        if (at >= f->piece.size || !f->count || status != FATHOM_OK) break;
        status = ask(f, index, at);
    }
    close(file);
    return status;
}

static fathom_status make_folder(fetching *f) {
    const char *named = getenv("TMPDIR");
    snprintf(f->folder, sizeof f->folder, "%s/fathom-XXXXXX", named && *named ? named : "/var/tmp");
    snprintf(f->path, sizeof f->path, "%s", f->folder);
    return mkdtemp(f->folder) ? FATHOM_OK : cannot_write(f);
}

/* The first file is the scene. */
static fathom_status fetch(fetching *f, const fathom_read_options *options, fathom_scene **out) {
    char scene[PATH_MAX] = "";
    fathom_status status = make_folder(f);
    for (uint32_t i = 0, all = 1; i < all && status == FATHOM_OK; ++i) {
        status = fetch_file(f, i, &all);
        if (!i) snprintf(scene, sizeof scene, "%s", f->path);
    }
    return status == FATHOM_OK ? fathom_scene_read_with(f->context, scene, options, out) : status;
}

fathom_status fathom_ranks_read(fathom_context *context, const fathom_ranks *ranks, const char *path,
                                const fathom_read_options *options, bool (*stopped)(void), fathom_scene **out,
                                char **folder) {
    if (!context || !ranks) return fail_null(context, "ranks");
    if (!folder) return fail_null(context, "folder");
    *folder = NULL;
    /* Records opened files until the scene's fingerprint is known; computing it opens images that reading
     * does not. */
    context_note_opened(context, !ranks->rank);
    fathom_status status = fathom_scene_read_with(context, path, options, out);
    if (status != FATHOM_BAD_INPUT || !ranks->rank) return status;
    fetching *f = calloc(1, sizeof *f);
    if (!f) return fail_memory(context, sizeof *f);
    f->context = context, f->ranks = ranks, f->stopped = stopped;
    status = fetch(f, options, out);
    *folder = *f->folder ? strdup(f->folder) : NULL;
    free(f);
    return status;
}

static int remove_one(const char *path, const struct stat *info, int kind, struct FTW *where) {
    (void)info, (void)kind, (void)where;
    (void)!remove(path);
    return 0;
}

void fathom_ranks_remove(char *folder) {
    if (folder) nftw(folder, remove_one, 16, FTW_DEPTH | FTW_PHYS | FTW_MOUNT);
    free(folder);
}
