/* One image: reads the scene, renders and writes. */
#pragma once

#include "cli/render/saving.h"
#include "cli/render/stats.h"

#include <fathom/ranks.h>

typedef struct task {
    fathom_context *context;
    double start; /* start of the command, or of the frame */
    render_options options;
    fathom_scene *scene;
    fathom_film *film;
    render_report report;
    saving saving;
    fathom_ranks ranks;     /* a single one without --mpi */
    char *fetched;          /* folder of files received from rank 0; NULL: none */
    fathom_framing framing; /* of all frames, if the reader creates the camera */
    /* For the first frame: sets `framing` for all times of the span. NULL: this was done, or there are no
     * frames. */
    void (*frame_all)(struct task *s, const double span[2]);
    bool exposed;       /* after a run: the exposure was chosen from lit pixels of the image */
    warning_list *said; /* warnings of earlier frames, which are not repeated; NULL: there are no frames */
} task;

/* Reads the scene into `scene`. */
fathom_status task_read(task *s);
/* The same for the first frame: sets `framing`, too. */
fathom_status task_read_framed(task *s);
/* Runs the task and destroys all but the options, the framing and `exposed`. */
fathom_status task_run(task *s);
/* Renders all frames that the options request, one image each. */
fathom_status sequence_run(task *all);
