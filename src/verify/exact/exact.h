/* The second way: whole numbers. Coordinates are scaled by a power of two that makes all of them whole,
 * directions by another; t is then scaled by their ratio. Nothing is rounded. */
#ifndef PARITY_EXACT_H
#define PARITY_EXACT_H

#include "verify/exact/exact_root.h"
#include "verify/exact/oracle.h"

/* The t of root `which` (spheres: 0 smaller, 1 larger; else 0). The line must meet the shape; of a quad, pass
 * the part as a triangle. */
void exact_root_of(const oracle_ray *ray, const oracle_primitive *primitive, unsigned which, exact_root *out);

#endif
