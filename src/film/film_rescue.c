/* Saves pixels whose own file cannot be written. */
#include "base/file.h"
#include "film/film.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRIES 1000u

typedef struct place {
    const char *folder; /* ends with a slash unless empty */
    int folder_length;
    const char *stem; /* stem of the file's name */
    int stem_length;
} place;

/* length of ".rescue-1000.exr.fathom-lock" */
#define ENDING 28

static bool name_at(const place *at, unsigned i, char out[PATH_MAX]) {
    char number[16] = "";
    if (i > 1) snprintf(number, sizeof number, "-%u", i);
    int length = snprintf(out, PATH_MAX, "%.*s%.*s.rescue%s.exr", at->folder_length, at->folder,
                          at->stem_length, at->stem, number);
    return length >= 0 && length < PATH_MAX;
}

typedef enum rescue { RESCUE_SAVED, RESCUE_OTHERS, RESCUE_FAILED } rescue;

/* Takes a lock: other renders may rescue their pixels at the same time, because the disk is full for all of
 * them. */
static rescue write_new(fathom_context *context, const fathom_film *film, const char *path) {
    file_lock *lock;
    if (access(path, F_OK) == 0) return RESCUE_OTHERS;
    fathom_status status = file_lock_take(context, path, &lock);
    if (status != FATHOM_OK) return status == FATHOM_BAD_USAGE ? RESCUE_OTHERS : RESCUE_FAILED;
    const bool theirs = access(path, F_OK) == 0;
    if (!theirs) status = fathom_film_write_plain(context, film, path);
    file_lock_release(lock);
    return theirs ? RESCUE_OTHERS : status == FATHOM_OK ? RESCUE_SAVED : RESCUE_FAILED;
}

/* Writes to the first unused name in the place. */
static bool rescue_to(fathom_context *context, const fathom_film *film, const place *at, char out[PATH_MAX]) {
    rescue saved = RESCUE_OTHERS;
    for (unsigned i = 1; i <= TRIES && saved == RESCUE_OTHERS; ++i)
        saved = name_at(at, i, out) ? write_new(context, film, out) : RESCUE_FAILED;
    return saved == RESCUE_SAVED;
}

static bool rescue_anywhere(fathom_context *context, const fathom_film *film, const char *path,
                            char out[PATH_MAX]) {
    const char *name = file_name(path), *variable = getenv("TMPDIR");
    int stem = (int)(file_stem_length(path) - (size_t)(name - path));
    if (stem > NAME_MAX - ENDING) stem = (int)file_name_cut(name, NAME_MAX - ENDING);
    char named[PATH_MAX] = "";
    if (variable && variable[0]) snprintf(named, sizeof named, "%s/", variable);
    const place places[] = {{path, (int)(name - path), name, stem},
                            {"", 0, name, stem},
                            {named, (int)strlen(named), name, stem},
                            {"/tmp/", 5, name, stem}};
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        if (places[i].folder == named && !named[0]) continue;
        if (rescue_to(context, film, &places[i], out)) return true;
    }
    return false;
}

/* Allocates no memory here: lack of it may be why the file could not be written. */
fathom_status fathom_film_rescue(fathom_context *context, const fathom_film *film, const char *path,
                                 char *saved, size_t size) {
    char found[PATH_MAX];
    if (!context || !film) return fail_null(context, "film");
    if (!path) return fail_null(context, "path");
    if (!saved || !size) return fail_null(context, "saved");
    saved[0] = '\0';
    if (rescue_anywhere(context, film, path, found)) {
        snprintf(saved, size, "%s", found);
        return FATHOM_OK;
    }
    return fail(context, FATHOM_OUT_OF_RESOURCES,
                "the pixels are lost: they could be written neither next to that file nor in the working "
                "folder, $TMPDIR or /tmp");
}
