/* Makes closed meshes watertight over a tracer that can miss their vertices.
 *
 * Every connected piece of a closed mesh is a body, inside of which a point lies or not, whichever way its
 * triangles face. Bodies that do not cross have each the same number of others around it everywhere, and so
 * has whatever lies in no body's surface; bodies.h finds these numbers. So what a ray meets first tells how
 * many bodies are around it just before that: as many as around its origin, or the answer is wrong and is
 * asked for again, more thoroughly. A shadow ray whose ends lie inside different numbers of bodies that cast
 * shadows is blocked. Answers that are possible cost a few instructions a ray.
 *
 * Cases that this does not detect: - a ray that misses two surfaces in a row, one going in and one going out:
 * one that passes two vertices within rounding; - where bodies cross or touch others, or are too many to be
 * told apart (bodies.c), a ray that misses one and then meets something that lies inside as well as outside
 * of it. */
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
    /* Whether any lane's ray meets the back of what it meets, closed or not. turned: some instances are
     * placed by maps that turn, mirror or skew. */
    bool (*any_back)(const world *w, bool turned, const trace_block *block, unsigned lanes);
} watertight_kernels;

#endif
