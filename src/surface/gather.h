/* From what a tracer found to the surface points that shading sees, and from which rays leave. Sixteen hits
 * are gathered, then computed together. */
#ifndef SURFACE_GATHER_H
#define SURFACE_GATHER_H

#include "scene/world/world.h"
#include "surface/kernels.h"
#include "trace/trace.h"

typedef struct surface_gather {
    local_block local;
    facet_block facets;
    uint32_t geometry[LANES], primitive[LANES], instance[LANES]; /* as in trace_hits */
    unsigned count;
    uint32_t instances;                  /* bit i: lane i is in an instance */
    uint32_t shaped;                     /* bit i: lane i met a mesh whose vertices move */
    float time[LANES];                   /* of the shutter; set in worlds that move */
    const world_instance *placed[LANES]; /* of lanes in instances, as they are then; set as time is */
    world_instance moved[LANES];
    bool faceted; /* some lane met a triangle or a quad */
} surface_gather;

/* Makes it empty. */
void surface_gather_begin(surface_gather *g);
/* Adds what a lane met; there must be room. */
void surface_gather_add(surface_gather *g, const world *w, const trace_block *block, size_t lane);
/* The material of lane i. */
fathom_id surface_gather_material(const surface_gather *g, const world *w, unsigned i);
/* Adds all sixteen lanes, which all met something, to an empty one. True when they are known to meet one
 * object.
 */
bool surface_gather_block(surface_gather *g, const world *w, const surface_kernels *kernels,
                          const trace_block *block);
/* Ask the caches for what gathering a block of hits reads, where it is likely not to be there: indices first
 * and, once these have come, corners. */
void surface_ask_indices(const world *w, const trace_hits *hits);
void surface_ask_corners(const world *w, const trace_hits *hits);
/* Fills the first g->count lanes of s, without material and count, and turns those of g->local to the world's
 * coordinates; all other lanes get something finite. lift: whether the points for shadow rays are wanted.
 * automatic: rays begin off the surface by the point's error; else on it. */
void surface_gather_end(surface_gather *g, const world *w, const surface_kernels *kernels, bool lift,
                        bool automatic, surface_block *s);

/* ---- for light_surfaces.c as well ---- */

/* Σ |n_i| |A_ij|, A the map to object space: by how much each part of a vector may count along n. */
double surface_stretch_along(const world_instance *instance, vec3_f64 n);
/* The most that Embree errs along the unit normal n of the world about the place of an object's point in an
 * instance that moves. */
double surface_moved_along(const world_instance *instance, vec3_f64 n, vec3_f64 object_p);
/* Corners that move are so much further off, in roundings of their size: two products and a sum, where ours
 * is one rounding. */
#define SURFACE_BENT 4

#endif
