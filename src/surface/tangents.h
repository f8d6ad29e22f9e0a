/* Tangents for smooth meshes that have normals and texture coordinates, but no tangents of their own. They
 * follow MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), for which normal maps are
 * baked. A corner's tangent is a weighted mean over the triangles that share its position, normal and texture
 * coordinates and have the same orientation (mirrored or not) of their uvs. Each triangle adds its tangent,
 * made orthogonal to the normal and unit, weighted by its angle at the corner. Unlike MikkTSpace, triangles
 * that share a vertex but no edge are averaged too. */
#pragma once

#include "scene/scene.h"

typedef struct surface_tangents surface_tangents;

/* *out is NULL if the mesh has no normals or no such uv set, or if its vertices would have to be matched and
 * it has more than 2^24 corners. Release with surface_tangents_free(), which takes NULL. */
fathom_status surface_tangents_make(fathom_context *context, const fathom_mesh *mesh, unsigned set,
                                    surface_tangents **out);
void surface_tangents_free(surface_tangents *t);
/* Interpolates between the corners of a triangle; in the mesh's space, not unit. False: there is none. */
bool surface_tangents_at(const surface_tangents *t, const fathom_mesh *mesh, uint32_t triangle,
                         const float weight[3], vec3_f32 *tangent);
