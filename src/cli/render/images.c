#include "cli/render/images.h"

#include "base/file_name.h"
#include "cli/command.h"
#include "cli/fail.h"
#include "cli/outputs.h"

#include <fathom/file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- of an interrupted render ---- */

#define MARK ".partial"

/* "out.partial.exr" for "out.exr", cut where names may not be as long. False where the path is too long. */
static bool partial_name(const char *path, char out[PATH_MAX]) {
    const char *name = file_name(path), *extension = path + file_stem_length(path);
    const size_t fixed = strlen(MARK) + strlen(extension), folder = (size_t)(name - path);
    size_t stem = (size_t)(extension - name);
    if (fixed < NAME_MAX && stem > NAME_MAX - fixed) stem = file_name_cut(name, NAME_MAX - fixed);
    int length = snprintf(out, PATH_MAX, "%.*s" MARK "%s", (int)(folder + stem), path, extension);
    return length >= 0 && length < PATH_MAX;
}

static fathom_status too_long(fathom_context *context, const char *path) {
    return cli_fail_file(context, FATHOM_BAD_USAGE, path,
                         "expected a path shorter by %zu bytes, which " MARK " takes", strlen(MARK));
}

fathom_status images_rename(fathom_context *context, args_list *outputs, image_names **room) {
    *room = malloc(sizeof **room);
    if (!*room) return cli_fail_memory(context);
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
        return cli_fail_file(context, FATHOM_BAD_USAGE, files[i],
                             "an interrupted render puts %s there; expected another name for one of the two",
                             path);
    }
    return FATHOM_OK;
}

fathom_status images_check_partial(fathom_context *context, const args_list *outputs,
                                   const char *const *files, size_t count) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i)
        status = check_one(context, outputs->items[i], files, count);
    return status;
}

void images_remove_left_over(const args_list *outputs) {
    for (size_t i = 0; i < outputs->count; ++i) {
        char partial[PATH_MAX];
        if (partial_name(outputs->items[i], partial)) fathom_file_remove_left_over(partial);
    }
}

void images_rescue(fathom_context *context, const fathom_film *film, const char *path, const char *which) {
    char saved[PATH_MAX], text[PATH_MAX + 128];
    if (fathom_film_rescue(context, film, path, saved, sizeof saved) == FATHOM_OK) {
        snprintf(text, sizeof text, "%s are in %s, as scene-linear EXR", which, saved);
        say_error(text);
    } else {
        say_error(fathom_context_message(context));
    }
}

/* ---- writing ---- */

bool images_need_helper(const render_options *options) {
    for (size_t i = 0; i < options->outputs.count; ++i) {
        if (fathom_write_needs_helper(options->outputs.items[i], &options->write)) return true;
    }
    return false;
}

static bool holds_all(const char *path) {
    char extension[16];
    file_extension(path, extension);
    return strcmp(extension, "exr") == 0;
}

/* Tries every output: one full disk is no reason to lose the others. */
fathom_status images_write(fathom_context *context, const fathom_film *film, const render_options *options) {
    fathom_status result = FATHOM_OK;
    const char *failed = NULL;
    bool kept = false;
    for (size_t i = 0; i < options->outputs.count; ++i) {
        const char *path = options->outputs.items[i];
        fathom_status status = fathom_film_write(context, film, path, &options->write);
        if (status == FATHOM_OK) status = standard_output_deliver(context, i, path);
        say_status(&command_render, context, status);
        kept |= status == FATHOM_OK && holds_all(path);
        if (status != FATHOM_OK && !failed)
            result = status, failed = standard_output_shown(&options->outputs, i);
    }
    if (failed && !kept) images_rescue(context, film, failed, "the pixels");
    return result;
}
