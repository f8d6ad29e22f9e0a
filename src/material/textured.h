/* Materials that vary over a surface, or have a way along it: at a point, a material's parameters are what
 * images and the colours of vertices say there.
 *
 * Each image is looked up once a point, however many parameters it serves, with the footprint of a cone
 * around the ray (Akenine-Möller et al., "Texture Level of Detail Strategies for Real-Time Ray Tracing",
 * 2019). Emission and opacity are looked up without a footprint: lights, shadow rays and paths that meet a
 * point then agree on it.
 *
 * Normal maps turn the shading normal in the frame of the mesh's tangents. Smooth meshes without any get
 * those of surface/tangents.h. Elsewhere the frame is that of the image on the surface: the way of u, made
 * orthogonal to the shading normal, and the one across it against v. A turned normal that faces away from the
 * viewer is turned back until it does not. Light stays on its side of the surface without the map: see `base`
 * in surface/surface.h. */
#ifndef MATERIAL_TEXTURED_H
#define MATERIAL_TEXTURED_H

#include "material/material.h"
#include "material/shader.h"
#include "surface/gather.h"

typedef struct texturing texturing;

/* memory: bytes of texture tiles. *out is NULL when nothing varies. Release with texturing_destroy(). The
 * world must outlive it. FATHOM_BAD_INPUT names a file that is no image. */
fathom_status texturing_create(fathom_context *context, const world *w, uint64_t memory, texturing **out);
void texturing_destroy(texturing *t);
/* FATHOM_OK, or why an image could not be looked up. */
fathom_status texturing_check(const texturing *t, fathom_context *context);

/* For a block of points whose hits are in g: turns s->ns, and replaces at[i] by &made[i] in lanes whose
 * materials vary. width: of the rays' cones at the points. around: what indices are divided by; NULL: 1. Sets
 * s->along where materials ask for it. */
void texturing_shade(const texturing *t, const surface_gather *g, const float width[LANES],
                     const float around[LANES], surface_block *s, shader made[LANES],
                     const shader *at[LANES]);
/* The same for the classic integrator. */
void texturing_classic(const texturing *t, const surface_gather *g, const float width[LANES],
                       surface_block *s, bsdf made[LANES], const bsdf *at[LANES]);

/* The opacity at the hit in lane i of g, which met this material; 1: all of the surface is there. */
float texturing_opacity(const texturing *t, const surface_gather *g, unsigned i, fathom_id material);
/* Some point of the material may let a ray straight through. */
bool texturing_may_cover(const texturing *t, fathom_id material);

/* True when the emission of a primitive of this material varies. */
bool texturing_varies_emission(const texturing *t, fathom_id material);
/* The emission of a triangle, or of a half quad, at these weights of its corners; all as in shader.emission.
 */
typedef struct texturing_place {
    fathom_id material;
    uint32_t geometry, primitive;
    bool second; /* of a quad's halves, as in surface/attributes.h */
    float weight[3];
    float width; /* of the footprint, as a share of the root of the triangle's area */
} texturing_place;
void texturing_emission(const texturing *t, const texturing_place *place, float rgb[3]);

#endif
