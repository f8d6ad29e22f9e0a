/* Shared by the files that implement textured.h. */
#pragma once

#include "material/textured.h"
#include "surface/attributes.h"

#include <math.h>
#include <string.h>

enum { NO_LOOKUP = 0xff };

/* One image with one mapping onto the surface, for one or several parameters. */
typedef struct lookup {
    fathom_id texture;
    uint32_t uv_set;
    bool exact;  /* never with a footprint */
    bool sharp;  /* without a footprint where the camera sees it, straight or in mirrors */
    float m[6];  /* fathom_map.transform */
    float scale; /* by which m scales lengths: the square root of its scale of areas */
} lookup;

/* A parameter that an image multiplies. */
typedef struct mapped_parameter {
    uint16_t offset; /* in fathom_material */
    uint8_t lookup, count, channel;
    bool inverted, bounded; /* inverted: see fathom_map.inverted; bounded: at most 1 */
} mapped_parameter;

typedef struct material_plan {
    const fathom_material *material;
    /* The material with all images white: colours and opacity that vary per vertex are clamped to their
     * ranges. */
    fathom_material even;
    unsigned count, parameter_count;
    lookup lookups[FATHOM_MAPS];
    mapped_parameter parameters[FATHOM_MAPS];
    uint8_t of[FATHOM_MAPS]; /* the index of the lookup for a kind of map, or NO_LOOKUP */
    uint8_t covers;          /* the lookup that only sets the opacity, or NO_LOOKUP */
    unsigned sets;           /* bits: uv sets that are needed */
    bool directed;           /* it needs a tangent */
    bool pane;               /* material_is_pane(), at some point */
    bool coat_turns;         /* some point has a clear coat with a normal of its own */
} material_plan;

struct texturing {
    const world *w;
    texture_cache *cache;
    bool colors; /* some mesh has vertex colours */
    bool alphas; /* some mesh has vertex colours with alpha */
    /* By mesh of the world and uv set; NULL: the mesh has its own, or needs none. */
    surface_tangents *(*tangents)[2];
    uint8_t **passes; /* by geometry, as of trace_passing.triangles; NULL: not known */
    material_plan plans[];
};

static inline bool is_classic(const fathom_material *m) { return m->model == FATHOM_MODEL_CLASSIC; }

/* The points of a block whose materials vary or need a tangent. */
typedef struct points {
    const texturing *t;
    const surface_gather *g;
    uint32_t lanes;     /* bits */
    bool varies[LANES]; /* false: the lane only needs its tangent */
    bool colored[LANES];
    const material_plan *plan[LANES];
    surface_uv uv[2][LANES];
    float width[2][LANES]; /* of the footprint, in units of u and v */
    uint32_t seen;         /* bits: lanes that the camera sees, straight or in mirrors */
    float color[LANES][4];
    float values[LANES][FATHOM_MAPS][4];
} points;

/* ---- textured_apply.c: parameters of a point ---- */

/* Sets the plan's parameters. Call once its lookups are known. */
void texturing_plan_parameters(material_plan *p);
/* Multiplies a parameter by the factors of an image; see fathom_map.inverted. */
void texturing_multiply(fathom_material *m, int kind, const float *factor, bool inverted);
/* Multiplies the material of a point by a vertex colour; NULL: none. Applies the cutoff to the opacity. */
void texturing_color(const material_plan *p, fathom_material *m, const float *color);
/* values: results of the lookups. The material's parameters become those of the point; its maps are not
 * copied. */
void texturing_apply(const material_plan *p, const float (*values)[4], const float *color,
                     fathom_material *m);
/* For the classic integrator: converts opacity to k_t, so that light passes straight through the transparent
 * fraction. */
void texturing_dissolve(fathom_material *m);

/* ---- textured_opacity.c ---- */

/* The opacity where the image of opacity, if any, and the vertex colour's alpha have these values. */
float texturing_cover(const material_plan *p, float image, float alpha);
/* See trace_passing.at; user: the texturing. */
trace_passes texturing_passes_at(const void *user, uint32_t geometry, uint32_t triangle, uint32_t instance,
                                 float u, float v);
/* True if the whole triangle in lane i is known to be opaque. */
static inline bool texturing_is_opaque(const texturing *t, const surface_gather *g, unsigned i) {
    return t->passes && g->geometry[i] < t->w->geometries.count && t->passes[g->geometry[i]] &&
           t->passes[g->geometry[i]][g->primitive[i]] == TRACE_PASSES_NONE;
}

/* ---- textured_normal.c: frames and normals ---- */

/* Makes tangents for meshes whose own material needs them. A mesh that gets such a material from an instance
 * uses the frames of its triangles instead. */
fathom_status texturing_make_tangents(fathom_context *context, texturing *t);
void texturing_turn_normals(const points *p, surface_block *s);
/* Sets the tangent of a point whose material needs one, rotated by the material's parameters there. */
void texturing_direct(const points *p, unsigned i, const fathom_material *m, surface_block *s);

/* ---- lookups ---- */

/* The footprint of the lookup in lane i, in units of u and v. */
static inline float width_of_lookup(const points *p, const lookup *l, unsigned i) {
    return l->sharp && p->seen >> i & 1 ? 0 : p->width[l->uv_set][i];
}
void texturing_place_lookup(const lookup *l, float u, float v, float width, texture_queries *q);
