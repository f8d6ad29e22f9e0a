/* Emissive triangles and quads, asked by sixteen points at once. */
#ifndef LIGHT_FACE_H
#define LIGHT_FACE_H

#include "light/shape.h"
#include "math/lanes.h"

/* A face and a point a lane; see shape_face. */
typedef struct face_query {
    _Alignas(64) lanes3_f64 corner[4];
    double quad[LANES]; /* 1, or 0 */
    double clear[LANES], slope[LANES];
    lanes3_f64 p;
    double u[LANES], v[LANES];
} face_query;

/* Where the density is 0 there is no light, and nothing else holds. */
typedef struct face_answer {
    _Alignas(64) lanes3_f64 direction; /* unit */
    double distance[LANES], density[LANES];
} face_answer;

typedef struct face_kernels {
    void (*sample)(const face_query *q, face_answer *out);
} face_kernels;

const face_kernels *face_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const face_kernels *face_kernels_at(unsigned index);

#endif
