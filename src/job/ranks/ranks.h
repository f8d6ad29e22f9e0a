/* A render by several processes: see fathom/ranks.h. */
#ifndef JOB_RANKS_H
#define JOB_RANKS_H

#include "job/job.h"

#include <fathom/ranks.h>

typedef struct ranks ranks;

/* FATHOM_BAD_USAGE: such a render is one process's work. On FATHOM_OK end with ranks_close(). */
fathom_status ranks_open(fathom_context *context, const fathom_ranks *options,
                         const fathom_settings *settings, fathom_film *film, ranks **out);
/* Once the tracer is known, before anything is rendered; saving: of rank 0, begun, or NULL. The share is the
 * work of this rank until ranks_close(). */
fathom_status ranks_begin(ranks *r, const char *tracer, checkpoint *saving, wave_share **share);
/* After the render ended with `status`, which it returns, or FATHOM_BAD_INPUT: another rank renders something
 * else. NULL is fine. */
fathom_status ranks_close(ranks *r, fathom_status status);

#endif
