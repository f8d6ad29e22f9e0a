/* Declarations shared by the files of the reference path tracer. Colours are vectors: x, y, z for red, green,
 * blue. */
#pragma once

#include "integrate/reference/reference.h"
#include "math/affine.h"
#include "trace/bvh/bvh.h"

#include <stdatomic.h>

/* ---- colours ---- */

static inline vec3_f64 color_of(const float rgb[3]) {
    return vec_f64((double)rgb[0], (double)rgb[1], (double)rgb[2]);
}
static inline vec3_f64 gray(double x) { return vec_f64(x, x, x); }
static inline vec3_f64 times(vec3_f64 a, vec3_f64 b) { return vec_f64(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline double largest(vec3_f64 a) { return fmax(a.x, fmax(a.y, a.z)); }
/* From a to b. */
static inline vec3_f64 blend(vec3_f64 a, vec3_f64 b, double part) {
    return add_f64(scale_f64(1 - part, a), scale_f64(part, b));
}

/* ---- random numbers: the n-th number of a key is a hash of both ---- */

typedef struct reference_random {
    uint64_t key, count;
    double time; /* of the sample, in the unit of the camera's shutter */
} reference_random;

/* The finalizer of splitmix64 (Steele, Lea, Flood 2014). */
static inline uint64_t reference_mix(uint64_t z) {
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
/* In [0, 1). */
static inline double reference_uniform(reference_random *r) {
    return (double)(reference_mix(r->key + ++r->count * 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53;
}

/* ---- reference_scene.c: shapes and rays ---- */

/* A ball that contains one emissive object while the shutter is open. */
typedef struct reference_lamp {
    vec3_f64 center;
    double radius;
} reference_lamp;

/* The placement of a shape; nested instances are flattened. */
typedef struct reference_place {
    affine_f64 to_world, to_object; /* at the time the shutter opens */
    fathom_id material;
    unsigned flags;
    uint32_t link; /* index of the innermost instance around it, if it moves; else FATHOM_NONE */
} reference_place;

/* An instance that contains a placement, and the next outer one; FATHOM_NONE: the world. */
typedef struct reference_link {
    fathom_id instance;
    uint32_t outer;
} reference_link;

enum { REFERENCE_LAMPS = 16 };

/* In the shape's own space. */
typedef struct reference_primitive {
    scene_kind kind;
    uint32_t place;
    uint32_t mesh, triangle;
    vec3_f64 corner[4]; /* sphere: its centre, and its radius in all components; plane: a point and the
                           normal; triangle: the last corner is repeated */
} reference_primitive;

/* Albedos of a metallic-roughness material's layers. Curves over the cosine mu have nodes at mu = (k /
 * REFERENCE_STEPS)^2; curves of facets exist for several azimuths, from the axis of the larger alpha to that
 * of the other. */
enum { REFERENCE_STEPS = 128, REFERENCE_TURNS = 16 };
/* Constants of rough glass for an index relative to its surroundings. `missing` is the light that the
 * first scattering neither reflects nor transmits, viewed from outside and from inside; again and cross
 * are its factors (reference_glass.c). */
typedef struct reference_glass {
    double ior, missing[2][REFERENCE_TURNS + 1][REFERENCE_STEPS + 1], again[2], cross[2];
} reference_glass;

typedef struct reference_albedos {
    double coat[REFERENCE_STEPS + 1],
        sheen[REFERENCE_STEPS + 1]; /* coat: times the coat's strength; sheen: of white fibres */
    double facets[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1];  /* for a reflectance of 1 */
    vec3_f64 layer[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1]; /* of the dielectric over the base */
    /* For `multiscatter` (Kulla & Conty 2017), see reference_energy.c. */
    vec3_f64 again, again_inside; /* again_inside: viewed from inside a solid */
    vec3_f64 again_base, below;
    double lost;
    unsigned glasses;
    reference_glass glass[];
} reference_albedos;

typedef struct reference_sky reference_sky;

struct reference_scene {
    const fathom_scene *scene;
    reference_settings settings;
    ARRAY(reference_place) places;
    ARRAY(reference_link) links;
    ARRAY(reference_primitive) primitives;
    ARRAY(uint32_t) planes;      /* of the primitives */
    reference_albedos **albedos; /* by material; NULL: it needs no albedos */
    ARRAY(reference_lamp) lamps; /* at most REFERENCE_LAMPS; empty if there are more */
    reference_sky *skies;        /* images of skies, and the studio */
    unsigned sky_count;
    bool refracts;       /* some material bounds volumes */
    atomic_bool overlap; /* a sample met volumes that overlap without priorities */
    bvh_item *items;     /* the primitives that are not planes */
    bvh_tree tree;       /* its leaves hold items */
    vec3_f64 middle;     /* origin of the boxes of items and tree, which are float */
};

/* A ray's hit on a surface. The normals are unit and point to the viewer's side. */
typedef struct reference_surface {
    vec3_f64 point, to_viewer;
    vec3_f64 geometric, normal; /* normal: for shading */
    vec3_f64 along;             /* tangent for anisotropy: unit, orthogonal to the shading normal */
    vec3_f64 lift;              /* from a facet to the smooth surface that its normals describe */
    bool lifted;                /* `lift` is set, and light may come from below the facet's horizon */
    bool behind;                /* the viewer is on the back side, away from the shape's own normal */
    const fathom_material *material;
    const reference_albedos *albedos; /* NULL: none */
    double ratio, turn; /* index of the far side divided by that of the viewer's side, for reflectances and
                           for directions */
    double t;
} reference_surface;

fathom_status reference_gather(reference_scene *r);
/* The closest hit along a unit direction. Partly transparent surfaces let rays pass at random. shadow: shapes
 * that cast no shadow are skipped. */
bool reference_closest(const reference_scene *r, vec3_f64 origin, vec3_f64 direction, double t_far,
                       bool shadow, reference_random *random, reference_surface *out);
/* True if a ray that leaves in this direction goes through the surface. */
bool reference_crosses(const reference_surface *s, vec3_f64 direction);
/* The origin of a ray that leaves the surface in this direction. */
vec3_f64 reference_leave(const reference_surface *s, vec3_f64 direction);

/* ---- reference_material.c: scattering ---- */

/* A single direction that carries a fraction of the light: mirrored or refracted. */
typedef struct reference_beam {
    vec3_f64 direction, weight;
} reference_beam;

/* How a surface scatters light to its viewer. */
typedef struct reference_scatter {
    unsigned beams;
    reference_beam beam[3];
    /* Rough estimates of the light that is scattered over each hemisphere, by facets, and by the coat. 0:
     * none. */
    double front, back, facets, coat;
} reference_scatter;

/* True for a clear thin wall, and for classic glass of index 1: its last beam, if it transmits light, goes
 * straight through. */
bool reference_is_pane(const fathom_material *m);

/* The first parameter of the material that the reference does not support; NULL: none. */
const char *reference_lacks(const fathom_material *m);
/* Reflectances of dielectric and metal. */
typedef struct reference_reflectances {
    vec3_f64 dielectric, metal;
    vec3_f64 base; /* fractions that the dielectric transmits to the base under it */
} reference_reflectances;
/* Schlick's reflectance, with the film; cosine: between v and h. slant: the same cosine in the thinner
 * medium, negative at total reflection. */
reference_reflectances reference_reflect(const fathom_material *m, double ior, double slant, double cosine);
/* The alpha of GGX facets; 0: a mirror. */
double reference_alpha(const fathom_material *m);
double reference_coat_alpha(const fathom_material *m);
/* KHR_materials_sheen's D V. */
double reference_fibres(const fathom_material *m, double nl, double nv, double nh);
/* The reflectance of a thin film (KHR_materials_iridescence) on a surface of reflectance f0 at this
 * cosine. */
vec3_f64 reference_film(const fathom_material *m, vec3_f64 f0, double cosine);
vec3_f64 reference_emission(const fathom_material *m);
reference_scatter reference_scatter_of(const reference_surface *s);
/* A rough estimate of the fraction of the facets' light at this cosine that passes through them. */
double reference_facets_pass(const reference_surface *s, double cosine);
/* The alpha of facets along the tangent; reference_alpha() is the one across it. */
double reference_alpha_along(const fathom_material *m);
/* The cosine on the far side by Snell's law; negative: total internal reflection. */
double reference_far_cosine(double cosine, double ratio);
vec3_f64 reference_mirrored(vec3_f64 v, vec3_f64 n);
vec3_f64 reference_refracted(vec3_f64 v, vec3_f64 n, double ratio);
/* f |n·l| of everything except beams, for the unit direction l from which light arrives. */
vec3_f64 reference_evaluate(const reference_surface *s, vec3_f64 l);

/* ---- reference_ways.c: random directions ---- */

/* A direction at this cosine to the axis, with random azimuth. */
vec3_f64 reference_around(vec3_f64 axis, double cosine, reference_random *random);
/* Samples a direction that is not a beam's; returns its density; 0: there is none. */
double reference_choose(const reference_scene *r, const reference_surface *s, const reference_scatter *all,
                        reference_random *random, vec3_f64 *out);

/* ---- reference_lights.c: suns and lamps ---- */

/* A light sample. */
typedef struct reference_arrival {
    vec3_f64 direction; /* unit, towards the light */
    double distance;
    double power; /* radiance divided by density, for an intensity of 1 */
} reference_arrival;

reference_arrival reference_arrive(const fathom_light *light, vec3_f64 point, reference_random *random);
/* Radiance of the discs of suns. */
vec3_f64 reference_suns(const reference_scene *r, vec3_f64 direction);
/* Radiance of a lamp with a radius, and the distance at which a ray from outside enters its sphere. INFINITY:
 * it does not. */
vec3_f64 reference_lamp_seen(const fathom_light *light, vec3_f64 origin, vec3_f64 direction,
                             double *distance);

/* ---- reference_sky.c: light from outside ---- */

fathom_status reference_skies_open(reference_scene *r);
void reference_skies_close(reference_scene *r);
/* Radiance of the background and all images from a unit direction. */
vec3_f64 reference_sky_light(const reference_scene *r, vec3_f64 direction);
/* Samples a unit direction by the light of one image; and the density of any direction. Only if there are
 * images. */
vec3_f64 reference_to_sky(const reference_scene *r, reference_random *random);
double reference_sky_density(const reference_scene *r, vec3_f64 direction);

/* ---- reference_energy.c: albedos ---- */

/* around: indices of the media that may surround rough glass of this material. *out: NULL if the material
 * needs no albedos; freed by free(). False if out of memory. */
bool reference_albedos_make(const fathom_material *m, const double *around, unsigned count,
                            reference_albedos **out);
/* The value of a curve of reference_albedos. */
double reference_curve(const double *curve, double cosine);
/* The value of curves of facets, for the direction d in the surface's frame; and d in that frame. */
double reference_facets(const double curves[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1], vec3_f64 d);
vec3_f64 reference_in_frame(const reference_surface *s, vec3_f64 d);
/* The direction of a node of these curves. */
vec3_f64 reference_turned_node(int turn, int step);
/* The length of d where the facets of these alphas are a hemisphere. */
double reference_stretched(double along, double across, vec3_f64 d);
/* (1 - E(v)) (1 - E(l)) / (pi <1 - E>); 0 without `multiscatter`. */
double reference_again(const reference_surface *s, vec3_f64 l);
/* True if the viewer is inside a solid, whose base has no layer. */
bool reference_is_inside(const reference_surface *s);
/* The fraction of light from l that reaches the base and then v. plain: that fraction without
 * `multiscatter`. */
vec3_f64 reference_base(const reference_surface *s, vec3_f64 l, vec3_f64 plain);
/* The fraction of light that passes straight through rough facets: what they do not reflect, at any order of
 * scattering. plain: that fraction without `multiscatter`. */
vec3_f64 reference_passes(const reference_surface *s, vec3_f64 plain);

/* ---- reference_glass.c ---- */

void reference_glass_make(const fathom_material *m, double ior, reference_glass *out);
/* Light that white rough glass sends to l after more than one scattering: f. */
double reference_glass_again(const reference_surface *s, vec3_f64 l);

/* True if the surface bounds a volume, so that light refracts. */
bool reference_refracts(const fathom_material *m);
/* True if its facets refract some light, too, each in its own direction. */
bool reference_is_rough_glass(const fathom_material *m);
/* The transmittance of the volume over this distance. */
vec3_f64 reference_absorbed(const fathom_material *m, double distance);
