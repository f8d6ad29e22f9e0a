/* File names, and the check of the paths in input files. */
#include "base/file.h"
#include "base/text.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

size_t file_stem_length(const char *path) {
    const char *dot = strrchr(file_name(path), '.');
    return dot ? (size_t)(dot - path) : strlen(path);
}

void file_extension(const char *path, char out[16]) {
    const char *dot = strrchr(file_name(path), '.');
    size_t length = 0;
    if (dot && strlen(dot + 1) < 16)
        for (const char *c = dot + 1; *c; ++c)
            out[length++] = *c >= 'A' && *c <= 'Z' ? (char)(*c - 'A' + 'a') : *c;
    out[length] = '\0';
}

bool file_ends_in(const char *path, const char *words) {
    char extension[16];
    file_extension(path, extension);
    return words_find(words, extension, strlen(extension)) >= 0;
}

size_t file_name_cut(const char *name, size_t most) {
    if (strlen(name) <= most) return strlen(name);
    while (most > 0 && ((unsigned char)name[most] & 0xc0) == 0x80) --most;
    return most;
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

/* ---- names from other computers ---- */

enum { FOLDED_MAX = 2 * NAME_MAX };

/* The letters and marks of the lower-case characters from U+E0 on. Letter 0: not a letter with a mark. */
static const char letters[32] = "aaaaaa\0ceeeeiiii\0nooooo\0\0uuuuy\0y";
static const unsigned char marks[32] = {0x0, 0x1, 0x2, 0x3, 0x8, 0xa, 0,   0x27, 0x0, 0x1, 0x2,
                                        0x8, 0x0, 0x1, 0x2, 0x8, 0,   0x3, 0x0,  0x1, 0x2, 0x3,
                                        0x8, 0,   0,   0x0, 0x1, 0x2, 0x8, 0x1,  0,   0x8};

/* Writes the name's characters as it would be for all computers, and returns their count: in lower case, from
 * UTF-8, or else Latin-1 as Windows has it, and with marks behind their letters as macOS has them. Case and
 * marks are those of Latin-1 alone. */
static size_t fold(const char *name, size_t length, unsigned out[FOLDED_MAX]) {
    size_t count = 0;
    for (const char *end = name + length; name < end && count + 1 < FOLDED_MAX;) {
        unsigned code;
        const size_t bytes = text_character(name, &code);
        if (!bytes) code = (unsigned char)*name;
        name += bytes ? bytes : 1;
        if ((code >= 'A' && code <= 'Z') || (code >= 0xc0 && code <= 0xde && code != 0xd7)) code += 32;
        const bool marked = code >= 0xe0 && code <= 0xff && letters[code - 0xe0];
        out[count++] = marked ? (unsigned char)letters[code - 0xe0] : code;
        if (marked) out[count++] = 0x300u + marks[code - 0xe0];
    }
    return count;
}

/* The entry of the folder that has this name on another computer, the first by strcmp(); "": none. */
static void find_entry(const char *folder, const char *name, size_t length, char best[NAME_MAX + 1]) {
    unsigned wanted[FOLDED_MAX], found[FOLDED_MAX];
    const size_t count = fold(name, length, wanted);
    DIR *entries = opendir(*folder ? folder : ".");
    *best = '\0';
    for (const struct dirent *entry; entries && (entry = readdir(entries)) != NULL;) {
        const bool same = fold(entry->d_name, strlen(entry->d_name), found) == count &&
                          memcmp(found, wanted, count * sizeof *found) == 0;
        if (same && (!*best || strcmp(entry->d_name, best) < 0)) strcpy(best, entry->d_name);
    }
    if (entries) closedir(entries);
}

/* `path` and the part, in a string of its own; NULL: out of memory. */
static char *longer(const char *path, const char *part, size_t length) {
    const size_t before = strlen(path);
    char *out = malloc(before + length + 1);
    if (!out) return NULL;
    memcpy(out, path, before);
    memcpy(out + before, part, length);
    out[before + length] = '\0';
    return out;
}

/* `path`, which is released, and the part as an existing file has it; NULL: there is none. */
static char *step(char *path, const char *part, size_t length) {
    char best[NAME_MAX + 1], *out = longer(path, part, length);
    if (out && *part != '/' && access(out, F_OK) != 0) {
        find_entry(path, part, length, best);
        free(out);
        out = *best ? longer(path, best, strlen(best)) : NULL;
    }
    free(path);
    return out;
}

char *file_of_any_case(const char *path, size_t from) {
    char *out = strndup(path, from);
    for (const char *part = path + from; out && *part;) {
        const size_t slashes = strspn(part, "/"), length = slashes ? slashes : strcspn(part, "/");
        out = step(out, part, length);
        part += length;
    }
    return out;
}

/* ---- the paths in input files ---- */

/* Both paths are canonical: without symbolic links, dots and double slashes. */
static bool holds(const char *folder, const char *path) {
    size_t length = strlen(folder);
    if (length == 1) return true; /* "/" */
    return strncmp(folder, path, length) == 0 && path[length] == '/';
}

bool file_climbs_out(const char *path) {
    long depth = 0;
    for (const char *part = path; *part && depth >= 0; part += strspn(part, "/")) {
        size_t length = strcspn(part, "/");
        if (length == 2 && strncmp(part, "..", 2) == 0)
            --depth;
        else if (length != 1 || *part != '.')
            ++depth;
        part += length;
    }
    return depth < 0;
}

static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* *out: whether the path leads out of the folder of `top`. The links of a missing file cannot be followed. */
static fathom_status leads_out(fathom_context *context, const char *top, const char *path, bool *out) {
    char *beside = file_beside(top, "."), *folder = beside ? realpath(beside, NULL) : NULL;
    int error = errno;
    char *real = folder ? realpath(path, NULL) : NULL;
    if (folder) error = errno;
    bool memory = beside && (real || error != ENOMEM);
    size_t length = folder_length(top);
    bool below = strncmp(top, path, length) == 0;
    *out = real ? !holds(folder, real) : !below || file_climbs_out(path + length);
    free(beside);
    free(folder);
    free(real);
    return memory ? FATHOM_OK : fail_memory(context, strlen(path));
}

static fathom_status refuse(fathom_context *context, const char *top, const char *name, const char *what) {
    return fail(context, FATHOM_BAD_INPUT,
                "\"%.200s\" %s; expected a file in %s%.200s, or the option --allow-outside", name, what,
                *top ? "the folder of " : "the working folder", top);
}

fathom_status file_confine(fathom_context *context, const char *top, const char *path, const char *name) {
    if (context_allows_outside(context)) return FATHOM_OK;
    if (name[0] == '/') return refuse(context, top, name, "is an absolute path");
    bool out = false;
    fathom_status status = leads_out(context, top, path, &out);
    if (status != FATHOM_OK || !out) return status;
    return refuse(context, top, name, "leads outside");
}
