/* Internals of emitters, shared by emitters*.c. */
#pragma once

#include "base/array.h"
#include "light/emitters.h"
#include "light/environment.h"
#include "light/light.h"
#include "light/shape_block.h"
#include "light/tree_view.h"
#include "material/textured.h"
#include "math/lane.h"

/* Primitives of one geometry in one instance or in the root, or their cells: emitters first, first + 1, … The
 * index of an emitter in its run is its number minus `first`. */
typedef struct emitter_run {
    uint32_t geometry, instance; /* FATHOM_NONE: the root */
    uint32_t first, count;       /* 0: none of them emits */
    uint8_t level;               /* of the faces' cells; 0: faces are whole. See emitters_cells.c */
    bool paired;                 /* each emitter is two triangles. See emitters_pairs.c */
} emitter_run;

/* Regions of surfaces, and the factors that tell what they see of the finite lights: emitters_seen.c. */
typedef struct emitter_seen {
    region_split *splits;
    uint32_t root; /* as region_split.below; leaves: 0: no factors; k: the k-th table */
    float *tables; /* factors of the light tree; NULL: regions have none */
} emitter_seen;

/* Regions of surfaces, and views of the finite lights: emitters_views.c. */
typedef struct emitter_views {
    tree_view *items; /* NULL: there are none */
    size_t count, capacity;
    ARRAY(region_split) splits;
    uint32_t root; /* as region_split.below; leaves are views */
} emitter_views;

/* Probabilities of the classes; they add up to 1, or are all 0. */
typedef struct emitter_shares {
    double of[EMITTER_PARTS];
} emitter_shares;

/* A directional light. */
typedef struct emitter_sun {
    vec3_f32 to_light; /* unit */
    float irradiance[3];
    double cap;    /* 1 - cos of half the angle that it covers */
    double chance; /* probability among suns; below: the sum of the probabilities of all suns before it */
    double below;
    uint8_t group;
} emitter_sun;

/* A point or spot light. */
typedef struct emitter_lamp {
    shade_light light;
    float radius;
    bool sphere; /* it has a radius, and the radiance of its sphere is within the range of float */
    uint8_t group;
} emitter_lamp;

/* An environment. */
typedef struct emitter_sky {
    environment *image;
    double chance; /* probability among light from outside */
    uint8_t group;
} emitter_sky;

/* A face in both precisions. */
typedef struct emitter_face {
    shape_faces all; /* the same in all lanes */
    shape_face plain;
    shape_face_f32 fast;
    bool exact; /* `fast` holds the corners without rounding */
} emitter_face;

/* Precomputed sampling data of an emitter that does not move. */
typedef struct emitter_ready {
    shape_face face;       /* undefined for a sphere */
    const float *radiance; /* NULL: a sphere */
} emitter_ready;

/* The light of a scene with a single light; see emitters_one.c. */
typedef struct emitter_one {
    emitter_face *face; /* NULL: the light is not a face */
    const float *radiance;
    bool sky; /* the only light is the background */
} emitter_one;

struct emitters {
    const world *w;
    const texturing *texturing; /* NULL: no emission varies over a surface */
    float (*emission)[3];       /* by material: radiance of both sides times opacity, without images */
    emitter_run *runs;          /* first of the root's geometries, then of each instance that emits */
    uint32_t run_count;
    bool moving;      /* some emitter moves */
    uint32_t *run_of; /* by instance: the run of its group's first geometry; FATHOM_NONE: it emits nothing */
    uint32_t surface_count; /* emitters below this are primitives, the others are lamps */
    uint32_t *slot_of;      /* by emitter: its leaf; FATHOM_NONE: it emits nothing */
    uint32_t finite_count;  /* leaves */
    uint32_t only;          /* the emitter if there is exactly one leaf; else FATHOM_NONE */
    emitter_ready *ready;   /* by emitter, without lamps; NULL: they move, or are too many */
    emitter_one one;
    tree lights;
    emitter_seen seen;
    emitter_views views;
    const shape_kernels *shapes;
    const light_kernels *points;
    emitter_lamp *lamps;
    uint32_t lamp_count;
    tree spheres;            /* of the lamps that are spheres, by their index; nodes NULL: there are none */
    bool found;              /* MIS: BSDF samples find these spheres and the discs of suns, too */
    light_surface *surfaces; /* surfaces that hold lamps */
    emitter_sun *suns;       /* those with a size first */
    uint32_t sun_count, disc_count;
    float background[3];
    double background_chance; /* probability among light from outside */
    emitter_sky *skies;
    uint32_t sky_count;
    const light_groups *groups; /* NULL: groups are not needed */
    uint8_t background_group, outside_group;
    emitter_shares shares; /* where regions have none */
    region_split *splits;  /* of regions; NULL: there are none */
    emitter_shares *regions;
    uint32_t root; /* as region_split.below; leaves are regions */
};

/* Each class of emitters has the same probability, until paths tell more. */
void emitters_share(emitters *e);

/* ---- emitters_regions.c ---- */

/* Classes are chosen by these probabilities at a point p with the normal n, as in emitter_query. */
const emitter_shares *emitters_region(const emitters *e, vec3_f32 p, vec3_f32 n);
static inline const emitter_shares *emitters_shares(const emitters *e, vec3_f32 p, vec3_f32 n) {
    return e->splits ? emitters_region(e, p, n) : &e->shares;
}
/* False: out of memory. */
bool emitters_learn_regions(emitters *e, const emitter_lesson *from);

/* ---- emitters_seen.c ---- */

/* Sets the factors of regions. Call at most once. False: out of memory. */
bool emitters_learn_seen(emitters *e, const emitter_lesson *from);
/* The factors of a leaf of emitter_seen. */
static inline tree_factors emitters_table(const emitters *e, uint32_t leaf) {
    return leaf ? e->seen.tables + (size_t)(leaf - 1) * e->lights.rows * TREE_WIDE : NULL;
}
/* The probability of the choice of a light, from all finite lights, before learning over that now. */
double emitters_seen_change(const emitters *e, const emitter_glance *g);

/* ---- emitters_views.c ---- */

/* The view of the finite lights at a point p with the normal n, as in emitter_query; NULL: there is none. */
const tree_view *emitters_find_view(const emitters *e, vec3_f32 p, vec3_f32 n);
static inline const tree_view *emitters_view(const emitters *e, vec3_f32 p, vec3_f32 n) {
    return e->views.items ? emitters_find_view(e, p, n) : NULL;
}
/* Call at most once, after emitters_learn_seen(). False: out of memory. */
bool emitters_learn_views(emitters *e, const emitter_lesson *from);
void emitters_forget_views(emitters *e);

static inline float luminance(const float rgb[3]) {
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

/* The luminance of a primitive, without images. */
float emitters_power(const emitters *e, uint32_t geometry, uint32_t primitive, uint32_t instance);
/* Fills in an item for each light with power; returns their number. Sets slot_of of lights without power. */
uint32_t emitters_list_items(emitters *e, tree_item *items);
/* Call after all emitters have been found. False: out of memory. */
bool emitters_prepare_one(emitters *e);
bool emitters_prepare_ready(emitters *e);
/* As emitters_sample(), for scenes in which emitters_choose() is false. */
void emitters_sample_one(const emitters *e, const emitter_query *from, const lanes3 u, emitter_sample *out);
void emitters_note_groups(emitters *e, const light_groups *groups);
uint8_t emitters_group_of(const emitters *e, uint32_t emitter);

/* The run of a primitive that a ray hit, or NULL if it is not an emitter. */
const emitter_run *emitters_run(const emitters *e, uint32_t geometry, uint32_t instance);
/* The run of an emitter that is a primitive or a cell. */
const emitter_run *emitters_run_of(const emitters *e, uint32_t emitter);
static inline bool emitters_is_ball(const emitters *e, const emitter_run *run) {
    return e->w->geometries.items[run->geometry].kind == WORLD_SPHERES;
}

/* The corners of a face in the space of its group, at a time in [0, 1] of the shutter; a triangle's third
 * corner is repeated. The face of a paired primitive is the quad of both. */
void emitters_corners(const world *w, const emitter_run *run, uint32_t primitive, float time,
                      vec3_f64 out[4]);
/* The face of a primitive of a run in world space, at a time. */
void emitters_face(const emitters *e, const emitter_run *run, uint32_t primitive, float time,
                   shape_face *out);

/* ---- emitters_cells.c ---- */

/* Divides the faces of runs whose emission varies enough. Until then a run's count is that of its
 * primitives. */
void emitters_divide_runs(emitters *e);
/* True if the emitters of the run are whole quads, or pairs of triangles. */
bool emitters_is_quad(const emitters *e, const emitter_run *run);
/* The first primitive of an emitter, and the cell at a place on a primitive; all by their indices in the run.
 */
uint32_t emitters_primitive(const emitters *e, const emitter_run *run, uint32_t index);
uint32_t emitters_index_at(const emitters *e, const emitter_run *run, uint32_t primitive,
                           const texturing_place *place);
/* True if the emitter is a cell of the second half of a quad. */
bool emitters_is_second(const emitters *e, const emitter_run *run, uint32_t index);
/* Replaces the corners of a whole face, in any space, by those of the emitter. */
void emitters_cut(const emitters *e, const emitter_run *run, uint32_t index, vec3_f64 c[4]);
/* The same for the triangle or half quad that holds the emitter. */
void emitters_divide(vec3_f64 c[3], const emitter_run *run, uint32_t index);

/* ---- emitters_pairs.c ---- */

/* Takes the triangles of runs in pairs where all pairs are quads. Until then a run's count is that of its
 * primitives. */
void emitters_pair_runs(emitters *e);
/* The corners of the quad that two adjacent triangles form, in the order of shape_face. False: they have no
 * common side. */
bool emitters_join(const vec3_f32 a[3], const vec3_f32 b[3], vec3_f64 out[4]);

/* A sphere, in the space of its group. */
typedef struct emitter_ball {
    vec3_f64 center;
    double radius, clear; /* a ray must end, or a point lie, farther than `clear` from the surface */
    const world_instance *instance; /* NULL: the root */
    double slope;                   /* and farther by this for each unit of length in world space */
    world_instance moved;           /* `instance` points to this if it moves */
} emitter_ball;
void emitters_ball(const emitters *e, const emitter_run *run, uint32_t primitive, float time,
                   emitter_ball *out);

/* ---- lanes ---- */

static inline vec3_f64 unit_or_zero(vec3_f32 n) { return normalize_f64(widen(n)); }

static inline void no_light(emitter_sample *out, unsigned i) {
    put_lane_f32(out->direction, i, (vec3_f32){0, 0, 1});
    put_lane_f32(out->radiance, i, (vec3_f32){0, 0, 0});
    out->distance[i] = out->density[i] = 0;
    out->sized[i] = 0;
}

/* Densities beyond the range of float belong to lights too small to be hit. */
static inline float density_f32(double density) { return density < 0x1p127 ? (float)density : 0x1p127f; }

/* Completes a lane's sample, whose direction and distance are set. */
static inline void emitters_finish(emitter_sample *out, unsigned i, double density, const float radiance[3]) {
    out->density[i] = density_f32(density);
    if (!(out->density[i] > 0)) {
        no_light(out, i);
        return;
    }
    put_lane_f32(out->radiance, i, load_f32(radiance));
    out->sized[i] = ~0u;
}

/* The lanes' queries, and the lights that they chose. */
typedef struct emitter_choices {
    const emitter_query *from;
    const float (*u)[LANES];
    const emitter_shares *shares[LANES];
    uint32_t emitter[LANES];
    double chance[LANES];
    unsigned faces, balls, lamps; /* bits: lanes that chose a light of this kind */
} emitter_choices;

void emitters_sample_lamps(const emitters *e, const emitter_choices *c, emitter_sample *out);
/* Sets the radiance of samples of primitives whose emission varies. */
void emitters_vary(const emitters *e, const emitter_choices *c, emitter_sample *out);
/* Call after all lamps have been found. False: out of memory. */
bool emitters_prepare_lamps(emitters *e);
/* The light tree's item of a lamp, without its index. */
void emitters_lamp_item(const emitter_lamp *lamp, tree_item *item);

/* Sample light from outside for the lanes whose bits are set, and a sun for one lane. */
void emitters_sample_outside(const emitters *e, unsigned lanes, const emitter_query *from, const lanes3 u,
                             const double choice[LANES], const emitter_shares *const shares[LANES],
                             emitter_sample *out);
void emitters_sample_sun(const emitters *e, double u, double v, double choice, double chance,
                         emitter_sample *out, unsigned i);

/* ---- emitters_varied.c ---- */

/* The primitive and the material of an emitter of a run; its weights and width are 0. */
texturing_place emitters_place(const emitters *e, const emitter_run *run, uint32_t index);
/* The mean luminance of an emitter whose emission varies. */
float emitters_varied_power(const emitters *e, const emitter_run *run, uint32_t index);
/* The half of a face that a ray from p hits, and the weights of its corners there. */
void emitters_face_place(const shape_face *f, vec3_f64 p, vec3_f64 direction, texturing_place *out);

/* A light sample of a primitive, for one point. */
typedef struct emitter_answer {
    vec3_f64 direction;
    double distance, density; /* density 0: no light from there */
    bool dark;                /* the direction is sampled, but it hits nothing that emits */
} emitter_answer;

/* True if the sphere is not transformed by an instance and the point is outside it. */
bool emitters_ball_is_plain(const emitter_ball *b, vec3_f64 p);
void emitters_ask_ball(const emitter_ball *b, vec3_f64 p, vec3_f64 n, double u, double v,
                       emitter_answer *out);
/* The densities of these samples. */
double emitters_face_density(const shape_face *f, vec3_f64 p);
/* The unit normal, in the ball's space, where a light sample of this direction hits it. */
vec3_f64 emitters_ball_normal(const emitter_ball *b, vec3_f64 p, vec3_f64 direction);
double emitters_ball_density(const emitter_ball *b, vec3_f64 p, vec3_f64 n, vec3_f64 direction, bool inside);
