/* Infinite planes: they have no bounds, so they are tested beside the tracer's own structure. */
#ifndef TRACE_PLANES_H
#define TRACE_PLANES_H

#include "trace/trace.h"

/* Planes nearer than t_far replace the hit; on equal t the earlier hit stays, so geometry wins over planes
 * and a plane over those after it. */
void planes_closest(const world *w, trace_block *blocks, size_t count);
/* Sets t_far = -infinity where a plane that casts shadows is met. */
void planes_any(const world *w, trace_rays *blocks, size_t count);

#endif
