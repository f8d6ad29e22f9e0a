/* Smooth normals for meshes that have none. */
#ifndef READ_NORMALS_H
#define READ_NORMALS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

typedef struct normals_input {
    const float *positions;
    size_t stride;           /* bytes */
    const uint32_t *indices; /* 3 a triangle */
    const uint32_t *slots;   /* beside indices: the normal that a corner feeds; NULL: the same as indices */
    size_t triangle_count;
    uint32_t slot_count;
} normals_input;

/* What a slot takes while its normal is made, beside the normal. */
#define NORMALS_SMOOTH_BYTES (3 * sizeof(int64_t))

/* Unit normals x y z for each slot, tightly packed: the sum over its corners of the triangle's unit normal
 * weighted by the angle at the corner (Thürmer and Wüthrich 1998), which does not depend on how a surface is
 * cut into triangles. The same on any thread count. Slots whose corners cancel out get the normal of the last
 * triangle with area that touches them; (0,0,1) if there is none. */
fathom_status normals_smooth(fathom_context *context, const normals_input *input, float *normals);

#endif
