/* Blocks of emissive shapes, a shape and a point a lane. */
#ifndef LIGHT_SHAPE_BLOCK_H
#define LIGHT_SHAPE_BLOCK_H

#include "light/shape.h"
#include "math/lanes.h"

typedef struct shape_faces {
    _Alignas(64) lanes3_f64 corner[4]; /* of a triangle the third repeats the fourth */
    double clear[LANES], slope[LANES]; /* see shape_face */
} shape_faces;

typedef struct shape_balls {
    _Alignas(64) lanes3_f64 center;
    double radius[LANES], clear[LANES], slope[LANES];
} shape_balls;

typedef struct shape_answers {
    _Alignas(64) lanes3_f64 direction; /* unit */
    double distance[LANES], density[LANES];
} shape_answers;

typedef struct shape_kernels {
    /* quads: some lane is a quad. direction and distance: the answers' once more. */
    void (*faces)(const shape_faces *f, const lanes3_f64 p, const lanes3 u, bool quads, shape_answers *out,
                  lanes3 direction, float *distance);
    /* Points outside of spheres alone. */
    void (*balls)(const shape_balls *b, const lanes3_f64 p, const lanes3 u, shape_answers *out,
                  lanes3 direction, float *distance);
} shape_kernels;

const shape_kernels *shape_kernels_best(void);

#endif
