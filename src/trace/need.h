/* How much memory tracing a world takes, known before anything is built. */
#ifndef TRACE_NEED_H
#define TRACE_NEED_H

#include "scene/world/world.h"

typedef struct trace_need {
    double kept;   /* bytes of Embree's finished structure, beyond the meshes themselves */
    double passed; /* held besides while it is built */
} trace_need;

/* Within a fifth for meshes of a million triangles and more. */
trace_need trace_need_of(const world *w, bool compact);

#endif
