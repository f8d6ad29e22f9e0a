/* The numbers of a render. */
#pragma once

#include "cli/notes.h"
#include "cli/render/render_options.h"

typedef struct render_report {
    fathom_stats stats;
    const char *scene;      /* name of the scene */
    uint32_t width, height; /* of the written image, after the crop */
    double read_seconds, write_seconds, total_seconds;
    bool interrupted;
    double finished; /* fraction of the render that is finished, [0,1] */
    left_out_list left_out;
    warning_list warnings;
} render_report;

/* --stats: writes one JSON object, as a whole file or none. */
fathom_status stats_write(fathom_context *context, const render_report *report,
                          const render_options *options);

/* One line to stdout; several with --verbose, none with --quiet. */
void stats_print(const render_report *report, const render_options *options);
