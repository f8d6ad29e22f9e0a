/* Where a mesh's float positions are counted from. */
#ifndef READ_ORIGIN_H
#define READ_ORIGIN_H

#include "scene/scene.h"

/* Zero unless the vertices lie so far out for their extent that float would lose digits the file has.
 *
 * A float coordinate of size M is rounded by up to 2^-24 M. The widest image, 65536 pixels, of a mesh with
 * half-extent e has pixels of e 2^-15, so up to M = 16 e the error stays below 2^-20 e, a thirty-second of
 * its pixels. Beyond that the origin moves to the centre, and M becomes at most 1.5 e again.
 * It moves by a multiple of a power of two not above e: coordinates that were floats in the file then keep
 * every bit, since their differences from it are multiples of their own last bit and no larger than they. */
vec3_f64 origin_for(const scene_bounds *bounds);

#endif
