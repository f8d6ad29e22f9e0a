/* Names of temporary files. */
#ifndef BASE_FILE_TEMPORARY_H
#define BASE_FILE_TEMPORARY_H

#include <stdbool.h>

/* Beside `path` and with its extension, by which libraries choose the format: "out.exr" ->
 * "out.fathom-tmp4711.exr", and for further attempts "out.fathom-tmp4711-1.exr"; 4711 is this process. Of
 * names that are too long for that the end is left out. NULL: no memory. Release with free(). */
char *temporary_name(const char *path, unsigned attempt);

/* Whether a file of this name, without its folder, is or was a temporary one of `target`, without its own. */
bool temporary_is_of(const char *name, const char *target);

#endif
