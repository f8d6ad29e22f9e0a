/* --checkpoint FILE: saves on SIGUSR1, reports whether the save succeeded, and removes the file once the
 * images are written. With --frames, records of finished frames stay until all are finished. */
#pragma once

#include "cli/render/render_options.h"

typedef struct saving {
    fathom_checkpoint request;
    bool asked;    /* SIGUSR1 requested the save in progress */
    bool failed;   /* the last save failed */
    bool sequence; /* of frames */
} saving;

/* Finds the errors that can be found before the scene is read. */
fathom_status saving_check(fathom_context *context, const render_options *options);

void saving_begin(const render_options *options, saving *out);
/* For the session; NULL without --checkpoint. */
const fathom_checkpoint *saving_request(const saving *s);
/* While rendering: without --checkpoint, says that SIGUSR1 saves nothing. */
void saving_tick(const saving *s);
/* With --frames and --resume: *finished is true if an earlier run has finished this frame. Sets the exposure
 * of its images, unless the command line gives one. */
fathom_status saving_find(fathom_context *context, const fathom_scene *scene, render_options *options,
                          bool *finished);
/* Records that the frame is finished. */
fathom_status saving_keep(fathom_context *context, const fathom_film *film, const render_options *options);
/* Removes the records of all frames. */
void saving_forget(const render_options *options);
/* Call after the images were written, with that status. Returns it, or FATHOM_OUT_OF_RESOURCES if an
 * interrupted render could not be saved. */
fathom_status saving_end(const saving *s, bool interrupted, fathom_status status);
