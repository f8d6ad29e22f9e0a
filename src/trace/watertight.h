/* Closed meshes that hold water, over a tracer that can miss their vertices.
 *
 * Closed meshes divide space: each point lies inside a number of them, and a ray's first hit or escape says
 * something of that number. From outside of all, the first hit of a closed mesh enters it. From inside, there
 * is a hit, and before the ray has left the box around all closed meshes. An answer that says otherwise is
 * wrong and is asked for again, more thoroughly. Answers that are possible cost a few instructions a ray.
 *
 * What this does not see: a ray that misses a mesh on entering and on leaving alike, and one from inside that
 * misses the way out and meets something else within the box. */
#ifndef TRACE_WATERTIGHT_H
#define TRACE_WATERTIGHT_H

#include "trace/trace.h"

typedef struct watertight watertight;

/* *out is NULL where there is nothing to do: no closed mesh (unless `always`), or a tracer that misses none.
 * The tracer must outlive it. Release with watertight_destroy(). */
fathom_status watertight_create(fathom_context *context, const trace_tracer *tracer, bool always,
                                watertight **out);
void watertight_destroy(watertight *w);

/* How many closed meshes the point lies inside. */
uint8_t watertight_depth(const watertight *w, vec3_f32 p);

/* The number for a point just behind the hit of the lane, whose ray came from a point inside `depth`; at
 * least 1 in front of it where the ray leaves a mesh. */
typedef struct watertight_sides {
    uint8_t before, behind;
} watertight_sides;
watertight_sides watertight_sides_of(const watertight *w, const trace_block *block, unsigned lane,
                                     uint8_t depth);

/* After trace_closest(): puts right what cannot be. depth[i]: of the origin of lane i. Returns how many lanes
 * changed. */
unsigned watertight_closest(const watertight *w, trace_block *block, const uint8_t depth[TRACE_WIDTH],
                            unsigned lanes);
/* After trace_any(), for rays that end at a point inside `there` closed meshes. */
unsigned watertight_any(const watertight *w, trace_rays *rays, const uint8_t depth[TRACE_WIDTH],
                        uint8_t there, unsigned lanes);

#endif
