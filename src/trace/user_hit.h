/* Hits as the library's user gets them: point, normals, uv and ids, in double. */
#ifndef TRACE_USER_HIT_H
#define TRACE_USER_HIT_H

#include "trace/trace.h"

#include <fathom/trace.h>

/* The hit of lane `lane` on the ray org + t dir (in the world's coordinates, in double). t is computed anew
 * from the primitive; where the exact ray just passes it by, the nearest point of the primitive stands in. */
void user_hit_resolve(const world *w, const trace_block *block, unsigned lane, vec3_f64 org, vec3_f64 dir,
                      fathom_hit *out);

#endif
