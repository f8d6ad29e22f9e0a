/* What all of `fathom bench` does besides measuring. */
#ifndef CLI_BENCH_RUN_H
#define CLI_BENCH_RUN_H

#include "cli/command.h"
#include "measure/stage.h"
#include "measure/statistics.h"

/* `asked` is what the command line filled. */
typedef fathom_status (*bench_measure)(fathom_context *context, const void *asked);

/* A command after its command line was read: measures with a context of so many threads (0: one a processor),
 * and files outside the scene's folder as --allow-outside says, and says what went wrong. */
fathom_status bench_run(const command *c, unsigned threads, bool outside, bench_measure measure,
                        const void *asked);

/* How far it is, as render shows it, and once it can be told, how long it takes. Begins with reading. */
void bench_progress_begin(bool quiet);
/* Fraction of all that is measured. */
void bench_progress_tell(void *unused, double fraction);
/* For measurements that are this part of all. */
bench_watch bench_progress_part(double from, double to);

/* The scene of the file with its settings, but for one sample a pixel and neither a target error nor a time;
 * size: in place of the settings', unless it is 0. Release with stage_close(), whatever comes back. */
fathom_status bench_open(fathom_context *context, const char *path, args_size size, bench_stage *out);

/* A sphere as `fathom generate sphere` makes it. Release with fathom_scene_destroy(), whatever comes back. */
fathom_status bench_sphere(fathom_context *context, uint64_t triangles, fathom_scene **out);

#endif
