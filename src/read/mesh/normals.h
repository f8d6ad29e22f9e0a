/* Smooth normals for meshes that have none. */
#pragma once

#include "base/status.h"

#include <fathom/scene.h>

/* Temporary memory for each slot, in addition to the normal itself. */
#define NORMALS_SMOOTH_BYTES (3 * sizeof(int64_t))

/* Unit normals x y z for each slot, tightly packed: the normalised sum of the unit normals of its corners'
 * triangles, each weighted by the corner's angle (Thürmer and Wüthrich 1998). slots: for each corner, the
 * slot that it contributes to; NULL: its vertex. The result does not depend on how a surface is triangulated,
 * nor on the thread count. A slot whose corners cancel out gets the normal of the last triangle with area
 * that touches it, or (0,0,1). */
fathom_status normals_smooth(fathom_context *context, const fathom_mesh *mesh, const uint32_t *slots,
                             uint32_t slot_count, float *normals);
