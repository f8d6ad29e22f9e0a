/* A render by several processes: see fathom/ranks.h. */
#pragma once

#include "job/job.h"

#include <fathom/ranks.h>

typedef struct ranks ranks;

/* FATHOM_BAD_USAGE: several processes cannot share such a render. On FATHOM_OK end with ranks_close(). */
fathom_status ranks_open(fathom_context *context, const fathom_ranks *options,
                         const fathom_settings *settings, fathom_film *film, ranks **out);
/* Call once the tracer is known, before anything is rendered. saving: on rank 0, begun, or NULL. *share is
 * the work of this rank, valid until ranks_close(). */
fathom_status ranks_begin(ranks *r, const char *tracer, checkpoint *saving, wave_share **share);
/* Call after the render ended with `status`. Returns `status`, or FATHOM_BAD_INPUT if another rank renders
 * something else. NULL is fine. */
fathom_status ranks_close(ranks *r, fathom_status status);
