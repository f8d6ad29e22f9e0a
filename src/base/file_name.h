/* Names of files, as text. */
#ifndef BASE_FILE_NAME_H
#define BASE_FILE_NAME_H

#include <stddef.h>

/* Extension without the dot, in lower case, "" when there is none. `out` has room for 16 bytes. */
void file_extension(const char *path, char out[16]);
/* The part of `path` after its folder. */
const char *file_name(const char *path);
/* The length of `path` before the dot of its extension. */
size_t file_stem_length(const char *path);
/* The length of `name` when cut to at most `most` bytes; UTF-8 characters stay whole. */
size_t file_name_cut(const char *name, size_t most);

#endif
