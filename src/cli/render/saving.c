#include "cli/render/saving.h"

#include "cli/command.h"
#include "cli/interrupt.h"
#include "cli/log.h"
#include "cli/render/images.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

static bool wanted(void *user) {
    saving *s = user;
    if (interrupt_take_save()) s->asked = true;
    return s->asked;
}

/* Reports only the first of several failures in a row: the disk may stay full for hours. */
static void saved(void *user, fathom_status status, const char *message, double fraction) {
    saving *s = user;
    if (status != FATHOM_OK && !s->failed)
        log_say(LOG_ERROR, "%s; rendering continues, and the next save tries again", message);
    if (status == FATHOM_OK && s->asked)
        log_say(LOG_INFO, "%s: saved at %u %%", s->request.path, (unsigned)(100 * fraction));
    s->asked = false;
    s->failed = status != FATHOM_OK;
}

static void fill(const render_options *options, fathom_checkpoint *out) {
    fathom_checkpoint_default(out);
    out->path = options->checkpoint;
    /* Frames that are not begun have no checkpoint, which is nothing to warn of. */
    out->resume =
        options->resume && !(frames_asked(&options->frames) && access(options->checkpoint, F_OK) != 0);
    if (options->checkpoint_every >= 0) out->every = options->checkpoint_every;
}

fathom_status saving_check(fathom_context *context, const render_options *options) {
    fathom_checkpoint request;
    if (!options->checkpoint) return FATHOM_OK;
    fill(options, &request);
    return fathom_checkpoint_check(context, &request);
}

void saving_begin(const render_options *options, saving *out) {
    *out = (saving){.sequence = frames_asked(&options->frames)};
    fill(options, &out->request);
    out->request.wanted = wanted;
    out->request.saved = saved;
    out->request.user = out;
}

const fathom_checkpoint *saving_request(const saving *s) { return s->request.path ? &s->request : NULL; }

void saving_tick(const saving *s) {
    if (!s->request.path && interrupt_take_save())
        log_line(LOG_ERROR, "SIGUSR1: nothing is saved without --checkpoint FILE; rendering continues");
}

/* ---- frames ---- */

fathom_status saving_find(fathom_context *context, const fathom_scene *scene, render_options *options,
                          bool *finished) {
    image_files files;
    const char *path = options->checkpoint;
    *finished = false;
    if (!frames_asked(&options->frames) || !path || !options->resume || access(path, F_OK) != 0)
        return FATHOM_OK;
    fathom_write_options write = options->write;
    if (options->exposure < EXPOSURE_GIVEN) write.exposure = NAN;
    fathom_status status = images_files(context, options, &files);
    if (status == FATHOM_OK)
        status = fathom_finished_find(context, scene, &options->settings, path, &write, files.items,
                                      files.count, finished);
    if (*finished) options->write.exposure = write.exposure;
    if (status == FATHOM_OK && access(path, F_OK) != 0)
        log_say(LOG_WARNING,
                "%s: the images of this finished frame, or the options to write them, have changed; "
                "rendering it again",
                path);
    return status;
}

fathom_status saving_keep(fathom_context *context, const fathom_film *film, const render_options *options) {
    image_files files;
    fathom_status status = images_files(context, options, &files);
    if (status != FATHOM_OK) return status;
    return fathom_finished_keep(context, film, options->checkpoint, &options->write, files.items,
                                files.count);
}

void saving_forget(const render_options *options) {
    char path[PATH_MAX];
    for (uint32_t frame = options->frames.first; options->checkpoint && frame <= options->frames.last;
         ++frame) {
        if (frames_name(options->checkpoint, frame, path)) unlink(path);
    }
}

fathom_status saving_end(const saving *s, bool interrupted, fathom_status status) {
    const char *path = s->request.path;
    if (!path) return status;
    if (status != FATHOM_OK) {
        if (access(path, F_OK) == 0)
            log_say(LOG_ERROR, "%s: is kept; --resume continues from what was saved last", path);
        return status;
    }
    if (interrupted && s->failed) {
        log_say(LOG_ERROR,
                "interrupted; the unfinished image is written, but the work could not be saved to %s", path);
        return FATHOM_OUT_OF_RESOURCES;
    }
    if (!interrupted && !s->sequence && unlink(path) != 0 && errno != ENOENT)
        log_say(LOG_WARNING, "%s: is no longer needed, but cannot be removed: %s", path, strerror(errno));
    return status;
}
