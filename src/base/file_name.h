/* File names, as text. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Extension without the dot, in lower case; "" when there is none or it has more than 15 bytes. `out` has
 * room for 16 bytes. */
void file_extension(const char *path, char out[16]);
/* True if the extension is one of the words of "glb|ply". */
bool file_ends_in(const char *path, const char *words);
/* The part of `path` after the last slash. */
const char *file_name(const char *path);
/* The length of `path` before the dot of its extension. */
size_t file_stem_length(const char *path);
/* The length to which `name` is cut to have at most `most` bytes; no UTF-8 character is split. */
size_t file_name_cut(const char *name, size_t most);
