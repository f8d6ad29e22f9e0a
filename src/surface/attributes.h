/* Texture coordinates, tangents and vertex colours of one lane of gathered hits. Call after
 * surface_gather_end(). */
#pragma once

#include "surface/gather.h"
#include "surface/tangents.h"

/* Texture coordinates of one uv set. If they are constant over the surface, du and dv are 0. */
typedef struct surface_uv {
    float u, v;
    vec3_f32 du, dv; /* derivatives of the world position by u and v */
} surface_uv;

/* set: 0 or 1. Meshes without this set get the barycentric coordinates of their triangles. */
void surface_uv_at(const surface_gather *g, const world *w, unsigned lane, unsigned set, surface_uv *out);
/* Only u and v, of a mesh triangle or a half quad at these weights of its corners, or of a sphere where its
 * unit normal in its own space is `weight`. */
void surface_uv_of(const world *w, uint32_t geometry, uint32_t primitive, bool second, const float weight[3],
                   unsigned set, float uv[2]);
/* The mesh's own tangent in world space, not unit, and the bitangent's sign: bitangent = sign · normal ×
 * tangent. False: the mesh has none. */
bool surface_tangent_at(const surface_gather *g, const world *w, unsigned lane, vec3_f32 *tangent,
                        float *sign);
/* Same for tangents computed for the lane's mesh; these have no sign. */
bool surface_made_tangent_at(const surface_gather *g, const world *w, unsigned lane,
                             const surface_tangents *made, vec3_f32 *tangent);
/* The vertex colour of a primitive at these weights of its corners. False and rgba = 1 if it has none. */
bool surface_color_of(const world *w, uint32_t geometry, uint32_t primitive, const float weight[3],
                      float rgba[4]);
/* The interpolated vertex colour. False and rgba = 1 if the shape has none. */
bool surface_color_at(const surface_gather *g, const world *w, unsigned lane, float rgba[4]);
