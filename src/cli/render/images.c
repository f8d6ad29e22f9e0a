#include "cli/render/images.h"

#include "base/file.h"
#include "base/status.h"
#include "cli/command.h"
#include "cli/outputs.h"
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    return fail_file(context, FATHOM_BAD_USAGE, path,
                     "expected a path shorter by %zu bytes, which " MARK " takes", strlen(MARK));
}

fathom_status images_rename(fathom_context *context, args_list *outputs, image_names **room) {
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
        if (partial_name(outputs->items[i], partial)) file_remove_left_over(partial);
    }
}

/* ---- pixels whose own file cannot be written ---- */

#define TRIES 1000u

typedef struct place {
    const char *folder; /* with a slash where one is needed */
    int folder_length;
    const char *stem; /* of the file's name */
    int stem_length;
} place;

/* ".rescue-1000.exr.fathom-lock" */
#define ENDING 28

static bool name_at(const place *at, unsigned i, char out[PATH_MAX]) {
    char number[16] = "";
    if (i > 1) snprintf(number, sizeof number, "-%u", i);
    int length = snprintf(out, PATH_MAX, "%.*s%.*s.rescue%s.exr", at->folder_length, at->folder,
                          at->stem_length, at->stem, number);
    return length >= 0 && length < PATH_MAX;
}

typedef enum rescue { RESCUE_SAVED, RESCUE_OTHERS, RESCUE_FAILED } rescue;

/* Others may be saving theirs at the same time, for the disk is as full for them. */
static rescue write_new(fathom_context *context, const fathom_film *film, const char *path) {
    file_lock *lock;
    if (access(path, F_OK) == 0) return RESCUE_OTHERS;
    fathom_status status = file_lock_take(context, path, &lock);
    if (status != FATHOM_OK) return status == FATHOM_BAD_USAGE ? RESCUE_OTHERS : RESCUE_FAILED;
    const bool theirs = access(path, F_OK) == 0;
    if (!theirs) status = fathom_film_write_plain(context, film, path);
    file_lock_release(lock);
    return theirs ? RESCUE_OTHERS : status == FATHOM_OK ? RESCUE_SAVED : RESCUE_FAILED;
}

/* Under the first name in the place that nobody has. */
static bool rescue_to(fathom_context *context, const fathom_film *film, const place *at, const char *which) {
    char path[PATH_MAX], text[PATH_MAX + 128];
    rescue saved = RESCUE_OTHERS;
    for (unsigned i = 1; i <= TRIES && saved == RESCUE_OTHERS; ++i) {
        saved = name_at(at, i, path) ? write_new(context, film, path) : RESCUE_FAILED;
    }
    if (saved != RESCUE_SAVED) return false;
    snprintf(text, sizeof text, "%s are in %s, as scene-linear EXR", which, path);
    say_error(text);
    return true;
}

void images_rescue(fathom_context *context, const fathom_film *film, const char *path, const char *which) {
    const char *name = file_name(path);
    int stem = (int)(file_stem_length(path) - (size_t)(name - path));
    if (stem > NAME_MAX - ENDING) stem = (int)file_name_cut(name, NAME_MAX - ENDING);
    char named[PATH_MAX] = "";
    const char *variable = getenv("TMPDIR");
    if (variable && variable[0]) snprintf(named, sizeof named, "%s/", variable);
    const place places[] = {{path, (int)(name - path), name, stem},
                            {"", 0, name, stem},
                            {named, (int)strlen(named), name, stem},
                            {"/tmp/", 5, name, stem}};
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        if (places[i].folder == named && !named[0]) continue;
        if (rescue_to(context, film, &places[i], which)) return;
    }
    say_error("the pixels are lost: they could be written neither next to that file nor in the working "
              "folder, $TMPDIR or /tmp");
}

/* ---- writing ---- */

bool images_need_module(const render_options *options) {
    for (size_t i = 0; i < options->outputs.count; ++i) {
        if (image_needs_module(options->outputs.items[i], &options->write)) return true;
    }
    return false;
}

static bool holds_all(const char *path) {
    char extension[16];
    file_extension(path, extension);
    return strcmp(extension, "exr") == 0;
}

/* Every output is tried: a full disk under one leaves the others worth having. */
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
