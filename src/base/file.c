#include "base/file.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

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
    if (dot && strlen(dot + 1) < 16) {
        for (const char *c = dot + 1; *c; ++c) out[length++] = (char)tolower((unsigned char)*c);
    }
    out[length] = '\0';
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
