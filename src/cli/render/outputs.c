#include "cli/render/outputs.h"

#include "base/file.h"
#include "base/status.h"
#include "cli/args.h"
#include "cli/standard_output.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Images, and what else a command writes beside them. */
#define OUTPUTS_MAX (ARGS_LIST_MAX + 4)

/* The folder's real path and the name in it: works for files that do not exist yet. */
static bool resolve(const char *path, char folder[PATH_MAX], const char **name) {
    const char *slash = strrchr(path, '/');
    *name = slash ? slash + 1 : path;
    if (!slash) return realpath(".", folder) != NULL;
    size_t length = (size_t)(slash - path) + 1;
    char above[PATH_MAX];
    if (length >= sizeof above) return false;
    memcpy(above, path, length);
    above[length] = '\0';
    return realpath(above, folder) != NULL;
}

bool outputs_are_same(const char *a, const char *b) {
    struct stat info_a, info_b;
    if (stat(a, &info_a) == 0 && stat(b, &info_b) == 0)
        return info_a.st_dev == info_b.st_dev && info_a.st_ino == info_b.st_ino;
    char folder_a[PATH_MAX], folder_b[PATH_MAX];
    const char *name_a, *name_b;
    return resolve(a, folder_a, &name_a) && resolve(b, folder_b, &name_b) && strcmp(name_a, name_b) == 0 &&
           strcmp(folder_a, folder_b) == 0;
}

/* Those that are there. A command has one set of outputs. */
static void keep_from_reading(fathom_context *context, const char *const *outputs, size_t count) {
    static file_identity files[OUTPUTS_MAX];
    size_t found = 0;
    struct stat info;
    for (size_t i = 0; i < count && found < OUTPUTS_MAX; ++i) {
        if (stat(outputs[i], &info) == 0) files[found++] = (file_identity){info.st_dev, info.st_ino};
    }
    context_set_outputs(context, files, found);
}

void outputs_may_be_read(fathom_context *context) { context_set_outputs(context, NULL, 0); }

fathom_status outputs_check_distinct(fathom_context *context, const char *const *outputs, size_t count,
                                     const char *input) {
    for (size_t i = 0; i < count; ++i) {
        if (input && outputs_are_same(outputs[i], input))
            return fail_file(context, FATHOM_BAD_USAGE, outputs[i],
                             "is the input; expected another name for the output");
        for (size_t k = 0; k < i; ++k) {
            if (outputs_are_same(outputs[i], outputs[k]))
                return fail_file(context, FATHOM_BAD_USAGE, outputs[i],
                                 "the same file is named twice; expected different outputs");
        }
    }
    keep_from_reading(context, outputs, count);
    return FATHOM_OK;
}

fathom_status outputs_write(fathom_context *context, const char *path, const char *bytes, size_t size) {
    if (standard_output_is_named(path)) return standard_output_put(context, bytes, size);
    file_writer *writer;
    fathom_status status = file_writer_open(context, path, &writer);
    if (status != FATHOM_OK) return status;
    file_writer_put(writer, bytes, size);
    return file_writer_commit(writer);
}
