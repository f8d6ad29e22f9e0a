/* File names, and the check of the paths in input files. */
#include "base/file.h"
#include "base/text.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
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

/* Replaces the last part of `path`, of `length` bytes, by an entry of its folder that differs only in case.
 * False if there is none. */
static bool take_entry(char *path, size_t length) {
    char *part = path + strlen(path) - length, best[NAME_MAX + 1] = "";
    const char first = *part;
    *part = '\0';
    DIR *folder = opendir(*path ? path : ".");
    *part = first;
    for (const struct dirent *entry; folder && (entry = readdir(folder)) != NULL;) {
        const bool same = strlen(entry->d_name) == length && strcasecmp(entry->d_name, part) == 0;
        if (same && (!*best || strcmp(entry->d_name, best) < 0)) strcpy(best, entry->d_name);
    }
    if (folder) closedir(folder);
    if (*best) memcpy(part, best, length);
    return *best;
}

char *file_of_any_case(const char *path, size_t from) {
    char *out = strdup(path);
    bool found = out != NULL;
    for (char *part = out + from; found && *part;) {
        const size_t length = strcspn(part, "/");
        const char after = part[length];
        part[length] = '\0';
        found = !length || access(out, F_OK) == 0 || take_entry(out, length);
        part[length] = after;
        part += length + (after ? 1 : 0);
    }
    if (found) return out;
    free(out);
    return NULL;
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
