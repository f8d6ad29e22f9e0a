/* --checkpoint FILE: saves when SIGUSR1 asks for it, says how that went, and removes the file once the images
 * are safe. */
#ifndef CLI_SAVING_H
#define CLI_SAVING_H

#include "cli/render/render_options.h"

typedef struct saving {
    fathom_checkpoint request;
    bool asked;  /* by SIGUSR1, of the save under way */
    bool failed; /* the last save */
} saving;

/* What can be known before the scene is read. */
fathom_status saving_check(fathom_context *context, const render_options *options);

void saving_begin(const render_options *options, saving *out);
/* What rendering is given: NULL without --checkpoint. */
const fathom_checkpoint *saving_request(const saving *s);
/* While rendering: tells who sends SIGUSR1 in vain. */
void saving_tick(const saving *s);
/* After images were written: `status` is how that went. Hands it on, or FATHOM_OUT_OF_RESOURCES when an
 * interrupted render could not be saved. */
fathom_status saving_end(const saving *s, bool interrupted, fathom_status status);

#endif
