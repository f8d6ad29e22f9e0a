#include "cli/render/rescue.h"

#include "base/file.h"
#include "cli/command.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRIES 1000u

typedef struct place {
    const char *folder; /* with a slash where one is needed */
    int folder_length;
    const char *stem; /* of the file's name */
    int stem_length;
} place;

/* ".rescue-1000.exr.fathom-lock" */
#define ENDING 28

static bool name_at(const place *at, unsigned i, char out[PATH_MAX]) {
    char number[16] = "";
    if (i > 1) snprintf(number, sizeof number, "-%u", i);
    int length = snprintf(out, PATH_MAX, "%.*s%.*s.rescue%s.exr", at->folder_length, at->folder,
                          at->stem_length, at->stem, number);
    return length >= 0 && length < PATH_MAX;
}

typedef enum result { RESULT_SAVED, RESULT_OTHERS, RESULT_FAILED } result;

/* Others may be saving theirs at the same time, for the disk is as full for them. */
static result write_new(fathom_context *context, const fathom_film *film, const char *path) {
    file_lock *lock;
    if (access(path, F_OK) == 0) return RESULT_OTHERS;
    fathom_status status = file_lock_take(context, path, &lock);
    if (status != FATHOM_OK) return status == FATHOM_BAD_USAGE ? RESULT_OTHERS : RESULT_FAILED;
    const bool theirs = access(path, F_OK) == 0;
    if (!theirs) status = fathom_film_write_plain(context, film, path);
    file_lock_release(lock);
    return theirs ? RESULT_OTHERS : status == FATHOM_OK ? RESULT_SAVED : RESULT_FAILED;
}

/* Under the first name in the place that nobody has. */
static bool rescue_to(fathom_context *context, const fathom_film *film, const place *at, const char *which) {
    char path[PATH_MAX], text[PATH_MAX + 128];
    result saved = RESULT_OTHERS;
    for (unsigned i = 1; i <= TRIES && saved == RESULT_OTHERS; ++i) {
        saved = name_at(at, i, path) ? write_new(context, film, path) : RESULT_FAILED;
    }
    if (saved != RESULT_SAVED) return false;
    snprintf(text, sizeof text, "%s are in %s, as scene-linear EXR", which, path);
    say_error(text);
    return true;
}

void rescue_film(fathom_context *context, const fathom_film *film, const char *path, const char *which) {
    const char *name = file_name(path);
    int stem = (int)(file_stem_length(path) - (size_t)(name - path));
    if (stem > NAME_MAX - ENDING) stem = (int)file_name_cut(name, NAME_MAX - ENDING);
    char named[PATH_MAX] = "";
    const char *variable = getenv("TMPDIR");
    if (variable && variable[0]) snprintf(named, sizeof named, "%s/", variable);
    const place places[] = {{path, (int)(name - path), name, stem},
                            {"", 0, name, stem},
                            {named, (int)strlen(named), name, stem},
                            {"/tmp/", 5, name, stem}};
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        if (places[i].folder == named && !named[0]) continue;
        if (rescue_to(context, film, &places[i], which)) return;
    }
    say_error("the pixels are lost: neither beside that file nor in the working folder, $TMPDIR or /tmp "
              "could they be written");
}
