/* A coarse image that stands in for pixels without samples. */
#ifndef JOB_PREVIEW_H
#define JOB_PREVIEW_H

#include "job/checkpoint/checkpoint.h"

/* Puts into the film, but for the squares that a checkpoint has finished, a coarse image: a sample for each
 * block of pixels, so few that they take a part of a percent of the time of all samples. They are not counted
 * among rays and samples. saving: NULL without a checkpoint. stop: looked at on the way. Without memory for
 * it the film stays as it is. */
void preview_run(const render_plan *plan, unsigned threads, const atomic_bool *stop, const checkpoint *saving,
                 fathom_film *film);

#endif
