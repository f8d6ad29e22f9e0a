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

/* Rays in view pass through the backs of one-sided surfaces. Where two sheets lie back to back in one place,
 * rays must therefore hit the one that faces them. So the back counts as if it lay farther away by this
 * factor. The t of each has an error of about 8 u / cos θ, as in embree_settle.c. The factor, 256 u, covers
 * both down to cos θ = 1/16, and half of Embree's window for ties holds it and the errors of t. */
#define SEARCH_BACK (1 + 0x1p-16f)

/* The ray sees the back of a one-sided triangle or quad: primitive k of geometry at[1], instance at[0]. */
static inline bool search_sees_back(const world *w, const uint32_t at[3], uint32_t k, vec3_f32 a, vec3_f32 b,
                                    vec3_f32 last, vec3_f64 dir) {
    const vec3_f64 from = widen(a);
    if (!(dot_f64(cross_f64(sub_f64(widen(b), from), sub_f64(widen(last), from)), dir) > 0)) return false;
    return material_is_one_sided(&w->scene->materials.items[world_material(w, at[1], k, at[0])].value);
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
