/* A part of a render, written to its file while it is rendered: see fathom/part.h and part_file.h. */
#pragma once

#include "job/job.h"

typedef struct part part;

/* Reads the file if it exists. FATHOM_BAD_USAGE: the render cannot be split this way, or another render
 * writes the file; FATHOM_BAD_INPUT: the file is of another render, or no part. On FATHOM_OK end with
 * part_close(). */
fathom_status part_open(fathom_context *context, const fathom_part *options, const fathom_settings *settings,
                        fathom_film *film, part **out);
/* Call once the tracer and the film's statistics of the scene are known, before anything is rendered.
 * FATHOM_BAD_INPUT: the file is of another tracer; FATHOM_OUT_OF_RESOURCES: cannot be written. *share is the
 * part's work, valid until part_close(). */
fathom_status part_begin(part *p, const char *tracer, wave_share **share);
/* Call after the render ended with `status`: writes the finished tiles and releases the part. Returns
 * `status`, or FATHOM_OUT_OF_RESOURCES if the tiles could not be written. NULL is fine. */
fathom_status part_close(part *p, fathom_status status);
