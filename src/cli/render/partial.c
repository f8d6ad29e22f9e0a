#include "cli/render/partial.h"

#include "base/file.h"
#include "cli/render/outputs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MARK ".partial"

bool partial_name(const char *path, char out[PATH_MAX]) {
    const char *name = file_name(path), *extension = path + file_stem_length(path);
    const size_t fixed = strlen(MARK) + strlen(extension), folder = (size_t)(name - path);
    size_t stem = (size_t)(extension - name);
    if (fixed < NAME_MAX && stem > NAME_MAX - fixed) stem = file_name_cut(name, NAME_MAX - fixed);
    int length = snprintf(out, PATH_MAX, "%.*s" MARK "%s", (int)(folder + stem), path, extension);
    return length >= 0 && length < PATH_MAX;
}

static fathom_status too_long(fathom_context *context, const char *path) {
    return fail_file(context, FATHOM_BAD_USAGE, path,
                     "expected a path shorter by %zu bytes, which " MARK " takes", strlen(MARK));
}

fathom_status partial_rename(fathom_context *context, args_list *outputs, partial_names **room) {
    *room = malloc(sizeof **room);
    if (!*room) return fail_memory(context, sizeof **room);
    for (size_t i = 0; i < outputs->count; ++i) {
        if (!partial_name(outputs->items[i], (*room)->names[i])) return too_long(context, outputs->items[i]);
        outputs->items[i] = (*room)->names[i];
    }
    return FATHOM_OK;
}

static fathom_status check_one(fathom_context *context, const char *path, const char *const *files,
                               size_t count) {
    char name[PATH_MAX];
    if (!partial_name(path, name)) return too_long(context, path);
    for (size_t i = 0; i < count; ++i) {
        if (!outputs_are_same(name, files[i])) continue;
        return fail_file(context, FATHOM_BAD_USAGE, files[i],
                         "an interrupted render puts %s there; expected another name for one of the two",
                         path);
    }
    return FATHOM_OK;
}

fathom_status partial_check(fathom_context *context, const args_list *outputs, const char *const *files,
                            size_t count) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i)
        status = check_one(context, outputs->items[i], files, count);
    return status;
}
