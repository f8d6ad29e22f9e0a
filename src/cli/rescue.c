#include "cli/rescue.h"

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

/* ".rescue-1000.exr" */
#define ENDING 16

/* A name that nobody has, in the place. */
static bool free_name(const place *at, char out[PATH_MAX]) {
    for (unsigned i = 1; i <= TRIES; ++i) {
        char number[16] = "";
        if (i > 1) snprintf(number, sizeof number, "-%u", i);
        int length = snprintf(out, PATH_MAX, "%.*s%.*s.rescue%s.exr", at->folder_length, at->folder,
                              at->stem_length, at->stem, number);
        if (length < 0 || length >= PATH_MAX) return false;
        if (access(out, F_OK) != 0) return true;
    }
    return false;
}

static bool rescue_to(fathom_context *context, const fathom_film *film, const place *at, const char *which) {
    char path[PATH_MAX], text[PATH_MAX + 128];
    if (!free_name(at, path) || fathom_film_write_plain(context, film, path) != FATHOM_OK) return false;
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
