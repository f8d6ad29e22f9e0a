/* Converts a tracer's hits to surface points for shading and for the origins of new rays. Sixteen hits are
 * gathered, then computed together. */
#pragma once

#include "scene/world/world.h"
#include "surface/kernels.h"
#include "trace/trace.h"

typedef struct surface_gather {
    local_block local;
    facet_block facets;
    uint32_t geometry[LANES], primitive[LANES], instance[LANES]; /* as in trace_hits */
    unsigned count;
    uint32_t instances;                  /* bit i: lane i is in an instance */
    uint32_t shaped;                     /* bit i: lane i hit a mesh whose vertices move */
    float time[LANES];                   /* of the shutter; set in worlds that move */
    const world_instance *placed[LANES]; /* lanes in instances: the instance at `time`; set in worlds that
                                            move */
    world_instance moved[LANES];
    bool faceted; /* some lane hit a triangle or a quad */
} surface_gather;

/* Empties g. */
void surface_gather_begin(surface_gather *g);
/* Adds a lane's hit; fewer than 16 must be in g. */
void surface_gather_add(surface_gather *g, const world *w, const trace_block *block, size_t lane);
/* The material of lane i. */
fathom_id surface_gather_material(const surface_gather *g, const world *w, unsigned i);
/* Adds all sixteen lanes, which must all be hits, to an empty g. True when they are known to hit one
 * object. */
bool surface_gather_block(surface_gather *g, const world *w, const surface_kernels *kernels,
                          const trace_block *block);
/* Prefetch data that gathering a block of hits reads, if it is probably not in the caches: first the indices
 * and, once these have arrived, the corners. */
void surface_ask_indices(const world *w, const trace_hits *hits);
void surface_ask_corners(const world *w, const trace_hits *hits);
/* Fills the first g->count lanes of s, except material and count, and transforms those of g->local to world
 * coordinates. Other lanes get finite values. lift: also compute `lift` for shadow rays. automatic: rays
 * start off the surface by the point's error; else on it. */
void surface_gather_end(surface_gather *g, const world *w, const surface_kernels *kernels, bool lift,
                        bool automatic, surface_block *s);

/* ---- also for light_surfaces.c ---- */

/* Σ |n_i| |A_ij| with A the matrix to object space: bound of how much each coordinate of a vector counts
 * along n. */
double surface_stretch_along(const world_instance *instance, vec3_f64 n);
/* Upper bound of Embree's error along the world's unit normal n, for the position of an object's point in a
 * moving instance. */
double surface_moved_along(const world_instance *instance, vec3_f64 n, vec3_f64 object_p);
/* Additional error of Embree's moving corners, in unit roundoffs of their size: two products and a sum, where
 * ours has one rounding. */
#define SURFACE_BENT 4
