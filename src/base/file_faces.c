#include "base/file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SETS = 3 };
static const char *const sets[SETS][FILE_FACES] = {{"px", "nx", "py", "ny", "pz", "nz"},
                                                   {"posx", "negx", "posy", "negy", "posz", "negz"},
                                                   {"right", "left", "top", "bottom", "front", "back"}};
static const char *const set_texts[SETS] = {"px nx py ny pz nz", "posx negx posy negy posz negz",
                                            "right left top bottom front back"};

static char *replaced(const char *pattern, const char *word) {
    const size_t length = strlen(FILE_FACE);
    /* No word is longer than what it replaces. */
    char *out = malloc(strlen(pattern) + 1), *to = out;
    if (!out) return NULL;
    for (const char *at; (at = strstr(pattern, FILE_FACE)) != NULL; pattern = at + length) {
        memcpy(to, pattern, (size_t)(at - pattern));
        to = stpcpy(to + (at - pattern), word);
    }
    strcpy(to, pattern);
    return out;
}

char *file_face_name(const char *pattern, unsigned face) { return replaced(pattern, sets[0][face]); }

void file_faces_close(file_faces *files) {
    for (unsigned i = 0; i < FILE_FACES; ++i) free(files->paths[i]);
    *files = (file_faces){.count = 0};
}

static bool name_all(const char *pattern, const char *const words[FILE_FACES], file_faces *out) {
    for (out->count = 0; out->count < FILE_FACES; ++out->count) {
        out->paths[out->count] = replaced(pattern, words[out->count]);
        if (!out->paths[out->count]) return false;
    }
    return true;
}

static fathom_status check_all(fathom_context *context, const char *pattern, unsigned set,
                               const file_faces *files) {
    for (unsigned i = 1; i < FILE_FACES; ++i) {
        if (access(files->paths[i], F_OK) != 0)
            return fail_file(context, FATHOM_BAD_INPUT, files->paths[i],
                             "%s; %.200s needs six files, with %s in place of " FILE_FACE, strerror(errno),
                             pattern, set_texts[set]);
    }
    return FATHOM_OK;
}

/* The first set whose first file exists. */
static fathom_status find_set(fathom_context *context, const char *pattern, file_faces *out) {
    for (unsigned set = 0; set < SETS; ++set) {
        if (!name_all(pattern, sets[set], out)) return fail_memory(context, strlen(pattern));
        if (access(out->paths[0], F_OK) == 0) return check_all(context, pattern, set, out);
        file_faces_close(out);
    }
    return fail_file(context, FATHOM_BAD_INPUT, pattern,
                     "there is no file with %s, %s or %s in place of " FILE_FACE
                     "; expected six files, with %s, or %s, or %s",
                     sets[0][0], sets[1][0], sets[2][0], set_texts[0], set_texts[1], set_texts[2]);
}

fathom_status file_faces_open(fathom_context *context, const char *path, file_faces *out) {
    *out = (file_faces){.count = 0};
    if (strstr(path, FILE_FACE)) {
        const fathom_status status = find_set(context, path, out);
        if (status != FATHOM_OK) file_faces_close(out);
        return status;
    }
    out->paths[0] = strdup(path);
    if (!out->paths[0]) return fail_memory(context, strlen(path));
    out->count = 1;
    return FATHOM_OK;
}
