/* Makes closed meshes watertight for a tracer that can miss their vertices.
 *
 * Every connected piece of a closed mesh is a body: each point lies inside or outside it. The depth of a
 * point is the number of bodies around it. If bodies do not cross, all points of a body's surface lie inside
 * the same number of other bodies; bodies.h finds this number. So the first hit of a ray gives the depth just
 * before the hit. If the depth at the ray's origin differs, the hit is wrong, and the ray is traced again
 * more thoroughly. A shadow ray is blocked if its ends lie inside different numbers of bodies that cast
 * shadows.
 *
 * Not detected:
 * - a ray that misses two surfaces in a row, one going in and one going out, at two vertices within rounding;
 * - a ray that misses a body and then hits a surface that lies partly inside and partly outside it, because
 *   bodies cross or touch, or are too many to distinguish (bodies.c). */
#pragma once

#include "trace/trace.h"

typedef struct watertight watertight;

/* *out is NULL if there is nothing to do: no closed mesh, or a tracer that misses nothing. The tracer must
 * outlive it. Release with watertight_destroy(). */
fathom_status watertight_create(fathom_context *context, const trace_tracer *tracer, watertight **out);
void watertight_destroy(watertight *w);

/* Depth of the point, the number of closed bodies around it, as a code: 0 is none. If all of these bodies
 * cast shadows, the code is their number. */
uint8_t watertight_depth(const watertight *w, vec3_f32 p);

/* The depths just before and just behind the lane's hit. `depth`: at the ray's origin. */
typedef struct watertight_sides {
    uint8_t before, behind;
} watertight_sides;
watertight_sides watertight_sides_of(const watertight *w, const trace_block *block, unsigned lane,
                                     uint8_t depth);

/* Call after trace_closest(): repairs impossible hits. depth[i]: at the origin of lane i. Returns the number
 * of changed lanes. */
unsigned watertight_closest(const watertight *w, trace_block *block, const uint8_t depth[LANES],
                            unsigned lanes);
/* An end_depth: the end of the ray lies on a closed mesh, so its depth depends on the ray's direction. */
#define WATERTIGHT_UNSURE UINT8_MAX

/* Call after trace_any(), for rays between points of these depths. */
unsigned watertight_any(const watertight *w, trace_rays *rays, const uint8_t depth[LANES],
                        const uint8_t end_depth[LANES], unsigned lanes);

/* The test that watertight.c makes of every block; kernels/watertight.c. */
typedef struct watertight_kernels {
    /* True if any lane hits the back of a surface, closed or not. turned: some instance transforms rotate,
     * mirror or skew. */
    bool (*any_back)(const world *w, bool turned, const trace_block *block, unsigned lanes);
} watertight_kernels;
const watertight_kernels *watertight_kernels_best(void);
