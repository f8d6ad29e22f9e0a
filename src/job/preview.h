/* A coarse image that stands in for pixels without samples. */
#pragma once

#include "job/checkpoint/checkpoint.h"

/* Fills the film with a coarse image, except the squares that a checkpoint has finished. It takes one sample
 * for each block of pixels: so few that they cost a fraction of a percent of the time of all samples. They
 * are not counted among rays and samples. saving: NULL without a checkpoint. stop: checked during the work.
 * If memory runs out, the film stays as it is. */
void preview_run(const render_plan *plan, unsigned threads, const atomic_bool *stop, const checkpoint *saving,
                 fathom_film *film);
