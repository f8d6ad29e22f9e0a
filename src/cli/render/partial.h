/* Where the images of an interrupted render go: beside their names, so that no finished image is lost. */
#ifndef CLI_PARTIAL_H
#define CLI_PARTIAL_H

#include "base/status.h"
#include "cli/args.h"

#include <limits.h>

/* "out.partial.exr" for "out.exr", cut where names may not be as long. False where the path is too
 * long. */
bool partial_name(const char *path, char out[PATH_MAX]);

typedef struct partial_names {
    char names[ARGS_LIST_MAX][PATH_MAX];
} partial_names;

/* Puts these names in place of the outputs. Release *room, which holds them, with free(). */
fathom_status partial_rename(fathom_context *context, args_list *outputs, partial_names **room);

/* FATHOM_BAD_USAGE when one of them is also one of the `count` files of the command, images first. */
fathom_status partial_check(fathom_context *context, const args_list *outputs, const char *const *files,
                            size_t count);

#endif
