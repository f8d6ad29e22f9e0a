/* Blocks of emissive shapes, one shape and one point per lane. */
#pragma once

#include "light/shape.h"
#include "math/lanes.h"

typedef struct shape_faces {
    _Alignas(64) lanes3_f64 corner[4]; /* a triangle's third corner repeats its fourth */
    double clear[LANES], slope[LANES]; /* see shape_face */
} shape_faces;

static inline void shape_faces_put(shape_faces *to, unsigned i, const shape_face *f) {
    for (int k = 0; k < 4; ++k) {
        const vec3_f64 corner = f->corner[k];
        to->corner[k][0][i] = corner.x, to->corner[k][1][i] = corner.y, to->corner[k][2][i] = corner.z;
    }
    to->clear[i] = f->clear, to->slope[i] = f->slope;
}

/* A face with float corners. */
typedef struct shape_face_f32 {
    vec3_f32 corner[4];
    vec3_f64 n[2]; /* unit normals of its triangles */
    float size[2]; /* twice their areas; the second is 0 for a single triangle */
    float clear, slope;
} shape_face_f32;

typedef struct shape_balls {
    _Alignas(64) lanes3_f64 center;
    double radius[LANES], clear[LANES], slope[LANES];
} shape_balls;

typedef struct shape_answers {
    _Alignas(64) lanes3_f64 direction; /* unit */
    double distance[LANES], density[LANES];
} shape_answers;

typedef struct shape_kernels {
    /* quads: some lane is a quad. direction and distance: copies of the samples' in float. */
    void (*faces)(const shape_faces *f, const lanes3_f64 p, const lanes3 u, bool quads, shape_answers *out,
                  lanes3 direction, float *distance);
    /* The same in float, for one face that all lanes sample. Returns bits: lanes that need double
     * precision. */
    uint32_t (*face)(const shape_face_f32 *f, const lanes3 p, const lanes3 u, float density[LANES],
                     lanes3 direction, float *distance);
    /* Only for points outside the spheres. */
    void (*balls)(const shape_balls *b, const lanes3_f64 p, const lanes3 u, shape_answers *out,
                  lanes3 direction, float *distance);
    /* Proportional to the cosine to the normals n, uniform if n is 0; densities are of the directions rounded
     * to float. */
    void (*sky)(const lanes3 n, const lanes3 u, lanes3 direction, float density[LANES]);
} shape_kernels;

const shape_kernels *shape_kernels_best(void);
