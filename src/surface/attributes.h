/* What images and colours on a surface are looked up by, of one lane of gathered hits. Call after
 * surface_gather_end(). */
#ifndef SURFACE_ATTRIBUTES_H
#define SURFACE_ATTRIBUTES_H

#include "surface/gather.h"
#include "surface/tangents.h"

/* Texture coordinates of one uv set. Where these do not vary over the surface, du and dv are 0. */
typedef struct surface_uv {
    float u, v;
    vec3_f32 du, dv; /* how the point moves in the world as u or v grows */
} surface_uv;

/* Of uv set 0 or 1. Meshes without it have the barycentric coordinates of their triangles. */
void surface_uv_at(const surface_gather *g, const world *w, unsigned lane, unsigned set, surface_uv *out);
/* Of a triangle of a mesh, or a half quad, at these weights of its corners: u and v alone. */
void surface_uv_of(const world *w, uint32_t geometry, uint32_t primitive, bool second, const float weight[3],
                   unsigned set, float uv[2]);
/* The mesh's own tangent in the world, not unit, and the sign of normal × tangent there. False: it has none.
 */
bool surface_tangent_at(const surface_gather *g, const world *w, unsigned lane, vec3_f32 *tangent,
                        float *sign);
/* The same of tangents that were made for the lane's mesh; the sign is not theirs. */
bool surface_made_tangent_at(const surface_gather *g, const world *w, unsigned lane,
                             const surface_tangents *made, vec3_f32 *tangent);
/* The colour of a primitive at these weights of its corners. False, and 1, where it has none. */
bool surface_color_of(const world *w, uint32_t geometry, uint32_t primitive, const float weight[3],
                      float rgba[4]);
/* The colour between the vertices. False, and 1, where the shape has none. */
bool surface_color_at(const surface_gather *g, const world *w, unsigned lane, float rgba[4]);

#endif
