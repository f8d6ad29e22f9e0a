/* Which files a file may name. */
#include "base/file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Both without links, dots and double slashes. */
static bool holds(const char *folder, const char *path) {
    size_t length = strlen(folder);
    if (length == 1) return true; /* "/" */
    return strncmp(folder, path, length) == 0 && path[length] == '/';
}

/* Whether the dots of a path climb above where it begins: for files that are not there, whose links cannot be
 * followed. */
static bool climbs_out(const char *path) {
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

/* *out: whether the path, beside or below `top` by its words, leads out of top's folder. */
static fathom_status leads_out(fathom_context *context, const char *top, const char *path, bool *out) {
    char *beside = file_beside(top, "."), *folder = beside ? realpath(beside, NULL) : NULL;
    int error = errno;
    char *real = folder ? realpath(path, NULL) : NULL;
    if (folder) error = errno;
    bool memory = beside && (real || error != ENOMEM);
    size_t length = folder_length(top);
    bool below = strncmp(top, path, length) == 0;
    *out = real ? !holds(folder, real) : !below || climbs_out(path + length);
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
