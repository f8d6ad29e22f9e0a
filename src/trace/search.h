/* Traces one ray through the world in each precision (search_f32, search_f64 and search_f128), for the
 * hand-written tracers; see search_text.h. */
#pragma once

#include "reference/reference.h"
#include "reference/reference_f128.h"
#include "trace/tracer.h"

static inline vec3_f32 same_f32(vec3_f32 v) { return v; }
/* The corners of a triangle. */
static inline void search_corners(const fathom_mesh *mesh, uint32_t triangle, vec3_f32 out[3]) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    for (unsigned c = 0; c < 3; ++c) out[c] = load_f32(mesh_vertex(mesh, index[c]));
}

/* Gets the corners of primitive k of a geometry that is not a run of spheres. Returns their number, 3 or
 * 4. */
static inline unsigned search_flat(const world *w, const world_geometry *geometry, uint32_t k,
                                   vec3_f32 out[4]) {
    if (geometry->kind == WORLD_MESH) {
        search_corners(&w->meshes.items[geometry->first], k, out);
        return 3;
    }
    for (unsigned c = 0; c < 4; ++c) out[c] = w->quads.items[geometry->first + k].corner[c];
    return 4;
}

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define FROM same_f32
#define SUM double
#include "trace/search_text.h"

#define REAL double
#define VEC3 vec3_f64
#define FN(name) name##_f64
#define FROM widen
#define SUM double
#include "trace/search_text.h"

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define FROM quadruple_f32
#define SUM real_f128
#include "trace/search_text.h"
