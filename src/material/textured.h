/* Materials that vary over a surface, or need a tangent: at a point, the material's parameters are modified
 * by images and vertex colours.
 *
 * Each image is looked up once per point, however many parameters use it, with the footprint of a cone around
 * the ray (Akenine-Möller et al., "Texture Level of Detail Strategies for Real-Time Ray Tracing", 2019).
 * Emission and opacity are looked up without a footprint, so that light samples, shadow rays and paths that
 * hit a point get the same value.
 *
 * Normal maps rotate the shading normal in the frame of the mesh's tangents. Smooth meshes without tangents
 * get those of surface/tangents.h. Otherwise the frame is that of the image on the surface: the tangent along
 * u, made orthogonal to the shading normal, and the bitangent against v. A rotated normal that faces away
 * from the viewer is rotated back until it faces the viewer. The side that light arrives on is also checked
 * with the normal without the map: see `base` in surface/surface.h. */
#pragma once

#include "material/material.h"
#include "material/shader.h"
#include "surface/gather.h"
#include "texture/texture.h"

typedef struct texturing texturing;

/* memory: bytes for texture tiles. cache: of the scene, which texturing owns, also on failure; NULL: opened
 * here. *out is NULL if nothing varies. Release with texturing_destroy(). The world must outlive it.
 * FATHOM_BAD_INPUT names a file that is not an image. */
fathom_status texturing_create(fathom_context *context, const world *w, uint64_t memory, texture_cache *cache,
                               texturing **out);
void texturing_destroy(texturing *t);
/* FATHOM_OK, or the reason why an image lookup failed. */
fathom_status texturing_check(const texturing *t, fathom_context *context);
/* The most memory that texels have taken so far. t may be NULL. */
uint64_t texturing_peak(const texturing *t);

/* For a block of points whose hits are in g: rotates s->ns, and replaces at[i] by &made[i] in lanes whose
 * materials vary. width: of the rays' cones at the points. seen: bits of the lanes
 * that the camera sees, straight or in mirrors. around: indices by which the materials' ior is
 * divided; NULL: 1. Sets s->along if materials need a tangent. */
void texturing_shade(const texturing *t, const surface_gather *g, const float width[LANES], uint32_t seen,
                     const float around[LANES], surface_block *s, shader made[LANES],
                     const shader *at[LANES]);
/* The same for the classic integrator, whose rays have no width. */
void texturing_classic(const texturing *t, const surface_gather *g, surface_block *s, bsdf made[LANES],
                       const bsdf *at[LANES]);

/* The opacity at the hit in lane i of g, on this material; 1: opaque. */
float texturing_opacity(const texturing *t, const surface_gather *g, unsigned i, fathom_id material);
/* Where light passes straight, for trace_know_passing(). Finds the triangles of meshes that are opaque, or
 * absent, at all points, so that they need no lookups. Decodes the images of opacity. *out lives as long as
 * t. */
fathom_status texturing_find_passing(texturing *t, fathom_context *context, trace_passing *out);
/* True if some point of the material may be transparent. */
bool texturing_may_cover(const texturing *t, fathom_id material);

/* True if the emission varies over a primitive of this material. */
bool texturing_varies_emission(const texturing *t, fathom_id material);
/* The emission at a point of a triangle, a half quad or a sphere; units as in shader.emission. */
typedef struct texturing_place {
    fathom_id material;
    uint32_t geometry, primitive;
    bool second;     /* the second half of a quad, as in surface/attributes.h */
    float weight[3]; /* of the corners; of a sphere the unit normal in its own space */
    float width; /* of the footprint, as a fraction of the square root of the triangle's area; of a sphere in
                    u and
                    v */
} texturing_place;
void texturing_emission(const texturing *t, const texturing_place *place, float rgb[3]);
/* Multiplies rgb, the emission of a material, by the largest factors of its image and of vertex colours. */
fathom_status texturing_brighten(const texturing *t, fathom_context *context, fathom_id material,
                                 float rgb[3]);
/* The square root of the number of texels that the triangle or half quad covers in the images of its
 * emission; 0: there are none. */
float texturing_emission_texels(const texturing *t, const texturing_place *place);
