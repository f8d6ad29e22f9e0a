/* The numbers of a render. */
#ifndef CLI_STATS_H
#define CLI_STATS_H

#include "cli/notes.h"
#include "cli/render/render_options.h"

typedef struct render_report {
    fathom_stats stats;
    const char *scene;      /* its name */
    uint32_t width, height; /* as written, cropped */
    double read_seconds, write_seconds, total_seconds;
    bool interrupted;
    double finished; /* of the render, [0,1] */
    left_out_list left_out;
    warning_list warnings;
} render_report;

/* --stats: one JSON object, whole or not at all. */
fathom_status stats_write(fathom_context *context, const render_report *report,
                          const render_options *options);

/* One line to stdout; several with --verbose, none with --quiet. */
void stats_print(const render_report *report, const render_options *options);

#endif
