/* Makes closed meshes watertight over a tracer that can miss their vertices.
 *
 * Every connected piece of a closed mesh is a body: a point lies inside or outside. Where bodies do not
 * cross, the same number of other bodies lies around every point of a surface; bodies.h finds it. So a ray's
 * first hit tells how many bodies lie around the ray just before it. If there are not as many around the
 * ray's origin, the answer is wrong and the ray is traced again, more thoroughly. A shadow ray whose ends lie
 * inside different numbers of bodies that cast shadows is blocked.
 *
 * This does not detect
 * - a ray that misses two surfaces in a row, one going in and one going out, at two vertices within rounding;
 * - a ray that misses a body and then meets something that lies both inside and outside of it, where bodies
 * cross or touch, or are too many to keep apart (bodies.c). */
#ifndef TRACE_WATERTIGHT_H
#define TRACE_WATERTIGHT_H

#include "trace/trace.h"

typedef struct watertight watertight;

/* *out is NULL where there is nothing to do: no closed mesh, or a tracer that misses none.
 * The tracer must outlive it. Release with watertight_destroy(). */
fathom_status watertight_create(fathom_context *context, const trace_tracer *tracer, watertight **out);
void watertight_destroy(watertight *w);

/* How many closed bodies the point lies inside, as a code: 0 is none, and so long as all of them cast
 * shadows, the code is their number. */
uint8_t watertight_depth(const watertight *w, vec3_f32 p);

/* The depths of points just before and behind the hit of the lane, whose ray came from `depth`. */
typedef struct watertight_sides {
    uint8_t before, behind;
} watertight_sides;
watertight_sides watertight_sides_of(const watertight *w, const trace_block *block, unsigned lane,
                                     uint8_t depth);

/* After trace_closest(): repairs impossible answers. depth[i]: of the origin of lane i. Returns how many
 * lanes changed. */
unsigned watertight_closest(const watertight *w, trace_block *block, const uint8_t depth[LANES],
                            unsigned lanes);
/* The end of a ray lies in a closed mesh: its side depends on where the ray comes from. */
#define WATERTIGHT_UNSURE UINT8_MAX

/* After trace_any(), for rays between points of these depths. */
unsigned watertight_any(const watertight *w, trace_rays *rays, const uint8_t depth[LANES],
                        const uint8_t end_depth[LANES], unsigned lanes);

/* The test that watertight.c makes of every block; kernels/watertight.c. */
typedef struct watertight_kernels {
    /* True if any lane's ray meets the back of what it meets, closed or not. turned: some instances are
     * placed by maps that turn, mirror or skew. */
    bool (*any_back)(const world *w, bool turned, const trace_block *block, unsigned lanes);
} watertight_kernels;
const watertight_kernels *watertight_kernels_best(void);

#endif
