#include "cli/render/images.h"

#include "base/file_name.h"
#include "cli/command.h"
#include "cli/fail.h"
#include "cli/log.h"
#include "cli/outputs.h"

#include <fathom/file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- names ---- */

#define PARTIAL ".partial"
#define REWEIGHTED ".reweighted"

/* "out.partial.exr" for "out.exr"; the stem is cut if the name would be too long. */
static fathom_status marked_name(fathom_context *context, const char *path, const char *mark,
                                 char out[PATH_MAX]) {
    const char *name = file_name(path), *extension = path + file_stem_length(path);
    const size_t fixed = strlen(mark) + strlen(extension), folder = (size_t)(name - path);
    size_t stem = (size_t)(extension - name);
    if (fixed < NAME_MAX && stem > NAME_MAX - fixed) stem = file_name_cut(name, NAME_MAX - fixed);
    int length = snprintf(out, PATH_MAX, "%.*s%s%s", (int)(folder + stem), path, mark, extension);
    if (length >= 0 && length < PATH_MAX) return FATHOM_OK;
    return cli_fail_file(context, FATHOM_BAD_USAGE, path,
                         "expected a path shorter by %zu bytes, which %s takes", strlen(mark), mark);
}

fathom_status images_rename(fathom_context *context, args_list *outputs, image_names **room) {
    fathom_status status = FATHOM_OK;
    *room = malloc(sizeof **room);
    if (!*room) return cli_fail_memory(context);
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i) {
        status = marked_name(context, outputs->items[i], PARTIAL, (*room)->names[i]);
        if (status == FATHOM_OK) outputs->items[i] = (*room)->names[i];
    }
    return status;
}

/* Fails if one of the files has the marked name of `path`. why: the cause, for the message. */
static fathom_status check_one(fathom_context *context, const char *path, const char *mark, const char *why,
                               const char *const *files, size_t count) {
    char name[PATH_MAX];
    fathom_status status = marked_name(context, path, mark, name);
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) {
        if (!outputs_are_same(name, files[i])) continue;
        status = cli_fail_file(context, FATHOM_BAD_USAGE, files[i],
                               "%s writes %s there; expected another name for one of the two", why, path);
    }
    return status;
}

fathom_status images_check_partial(fathom_context *context, const args_list *outputs,
                                   const char *const *files, size_t count) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i)
        status = check_one(context, outputs->items[i], PARTIAL, "an interrupted render", files, count);
    return status;
}

fathom_status images_check_reweighted(fathom_context *context, const args_list *outputs,
                                      const char *const *files, size_t count) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i) {
        if (standard_output_shown(outputs, i) != outputs->items[i])
            return cli_fail(context, FATHOM_BAD_USAGE,
                            "--fireflies reweight writes a second image next to the first; expected a file's "
                            "name instead of standard output");
        status = check_one(context, outputs->items[i], REWEIGHTED, "--fireflies reweight", files, count);
    }
    return status;
}

void images_remove_left_over(const args_list *outputs) {
    for (size_t i = 0; i < outputs->count; ++i) {
        char partial[PATH_MAX];
        if (marked_name(NULL, outputs->items[i], PARTIAL, partial) == FATHOM_OK)
            fathom_file_remove_left_over(partial);
    }
}

void images_remove_partial(const args_list *outputs) {
    for (size_t i = 0; i < outputs->count; ++i) {
        char partial[PATH_MAX], second[PATH_MAX];
        if (marked_name(NULL, outputs->items[i], PARTIAL, partial) != FATHOM_OK) continue;
        unlink(partial);
        if (marked_name(NULL, partial, REWEIGHTED, second) == FATHOM_OK) unlink(second);
    }
}

void images_rescue(fathom_context *context, const fathom_film *film, const char *path, const char *which) {
    char saved[PATH_MAX];
    if (fathom_film_rescue(context, film, path, saved, sizeof saved) == FATHOM_OK) {
        log_say(LOG_ERROR, "%s are in %s, as scene-linear EXR", which, saved);
    } else {
        log_line(LOG_ERROR, fathom_context_message(context));
    }
}

/* ---- writing ---- */

const char *images_shown(const render_options *options, size_t i, char room[PATH_MAX]) {
    const args_list *outputs = &options->outputs;
    if (i < outputs->count) return standard_output_shown(outputs, i);
    const bool second = options->settings.fireflies == FATHOM_FIREFLIES_REWEIGHT && i < 2 * outputs->count &&
                        marked_name(NULL, outputs->items[i - outputs->count], REWEIGHTED, room) == FATHOM_OK;
    return second ? room : NULL;
}

void images_print(const render_options *options) {
    char room[PATH_MAX];
    const char *name;
    for (size_t i = 0; (name = images_shown(options, i, room)); ++i) {
        if (i) fputs(", ", stdout);
        print_name(stdout, name);
    }
}

bool images_need_helper(const render_options *options) {
    for (size_t i = 0; i < options->outputs.count; ++i) {
        if (fathom_write_needs_helper(options->outputs.items[i], &options->write)) return true;
    }
    return false;
}

/* Makes the second image, if the film has the data. FATHOM_BAD_USAGE: there is no place for it next to an
 * output of `fathom merge`, which only the parts tell of. */
static fathom_status make_second(fathom_context *context, const fathom_film *film, const args_list *outputs,
                                 fathom_film **out) {
    const fathom_status status = fathom_film_reweight(context, film, out);
    if (!*out) return status;
    return images_check_reweighted(context, outputs, (const char *const *)outputs->items, outputs->count);
}

/* Writes the second image of each output. */
static fathom_status write_second(fathom_context *context, const fathom_film *second,
                                  const render_options *options) {
    char name[PATH_MAX];
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i) {
        status = marked_name(context, options->outputs.items[i], REWEIGHTED, name);
        if (status == FATHOM_OK) status = fathom_film_write(context, second, name, &options->write);
    }
    return status;
}

fathom_status images_files(fathom_context *context, const render_options *options, image_files *out) {
    const bool second = options->settings.fireflies == FATHOM_FIREFLIES_REWEIGHT;
    fathom_status status = FATHOM_OK;
    out->count = 0;
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i) {
        const char *path = options->outputs.items[i];
        out->items[out->count++] = path;
        if (!second) continue;
        status = marked_name(context, path, REWEIGHTED, out->room.names[i]);
        out->items[out->count++] = out->room.names[i];
    }
    if (options->stats) out->items[out->count++] = options->stats;
    return status;
}

/* Tries every output: one full disk is no reason to lose the others. */
static fathom_status write_first(fathom_context *context, const fathom_film *film,
                                 const render_options *options) {
    fathom_status result = FATHOM_OK;
    const char *failed = NULL;
    bool kept = false;
    for (size_t i = 0; i < options->outputs.count; ++i) {
        const char *path = options->outputs.items[i];
        fathom_status status = fathom_film_write(context, film, path, &options->write);
        if (status == FATHOM_OK) status = standard_output_deliver(context, i, path);
        say_status(&command_render, context, status);
        kept |= status == FATHOM_OK && outputs_is_exr(path);
        if (status != FATHOM_OK && !failed)
            result = status, failed = standard_output_shown(&options->outputs, i);
    }
    if (failed && !kept) images_rescue(context, film, failed, "the pixels");
    return result;
}

fathom_status images_write(fathom_context *context, const fathom_film *film, render_options *options) {
    fathom_film *second = NULL;
    const fathom_status made =
        say_status(&command_render, context, make_second(context, film, &options->outputs, &second));
    fathom_status status = made == FATHOM_BAD_USAGE ? made : write_first(context, film, options);
    if (status == FATHOM_OK) status = made;
    if (second) options->settings.fireflies = FATHOM_FIREFLIES_REWEIGHT;
    if (status == FATHOM_OK && second)
        status = say_status(&command_render, context, write_second(context, second, options));
    fathom_film_destroy(second);
    return status;
}
