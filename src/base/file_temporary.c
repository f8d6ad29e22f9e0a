#include "base/file_temporary.h"

#include "base/file.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MARK ".fathom-tmp"
#define NUMBERS 16 /* room for those of the process and the attempt */
#define EXTENSION_MOST 16

/* Where the extension begins, and how much of what comes before it is kept. */
static size_t split(const char *name, const char **extension) {
    const char *dot = name + file_stem_length(name);
    *extension = strlen(dot) <= EXTENSION_MOST ? dot : name + strlen(name);
    const size_t stem = (size_t)(*extension - name),
                 most = NAME_MAX - strlen(MARK) - NUMBERS - strlen(*extension);
    return stem <= most ? stem : file_name_cut(name, most);
}

char *temporary_name(const char *path, unsigned attempt) {
    const char *name = file_name(path), *extension;
    const size_t kept = (size_t)(name - path) + split(name, &extension),
                 room = strlen(path) + strlen(MARK) + 32;
    char *out = malloc(room), again[16] = "";
    if (attempt) snprintf(again, sizeof again, "-%u", attempt);
    if (out) snprintf(out, room, "%.*s" MARK "%ld%s%s", (int)kept, path, (long)getpid(), again, extension);
    return out;
}

bool temporary_is_of(const char *name, const char *target) {
    const char *extension;
    const size_t kept = split(target, &extension);
    if (strncmp(name, target, kept) != 0) return false;
    const char *rest = name + kept;
    if (strncmp(rest, MARK, strlen(MARK)) != 0) return false;
    rest += strlen(MARK);
    size_t digits = strspn(rest, "0123456789");
    if (!digits) return false;
    rest += digits;
    if (*rest == '-') rest += 1 + strspn(rest + 1, "0123456789");
    return strcmp(rest, extension) == 0;
}
