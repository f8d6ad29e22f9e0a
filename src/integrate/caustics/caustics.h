/* Caustics: light that smooth mirrors and glass throw onto other surfaces. Paths from the camera find a small
 * lamp behind glass so rarely that the image is speckled. Photons find it easily: they start towards smooth
 * objects, and follow mirrors and refraction. Where they then meet another surface, a ray connects them with
 * the camera (Arvo 1986; Dutré et al. 1993), and they go on. Before the render, photons make a map of the
 * light that each pixel gets so; each sample of a pixel then adds the map's value.
 *
 * Paths from the camera find the same light. The power heuristic weighs both (Veach 1997), so the expected
 * value is that of path tracing alone. This holds for chains: paths whose first vertex is not smooth, and
 * whose last one before the light is. Photons count in rays per étendue, dA cos dω, which smooth surfaces
 * conserve. A chain's density is that of the camera's path divided by that with which photons go the same
 * way, up to the étendue at the light: a smooth vertex changes it only if it has a shading normal. */
#pragma once

#include "base/array.h"
#include "integrate/path/path.h"

#include <math.h>

/* A sphere around smooth objects. Photons of this sphere enter it at a uniform point. A ray belongs to the
 * sphere that it enters first. */
typedef struct caustic_caster {
    vec3_f64 center;
    double radius;
    double chance; /* of its photons among all */
    double light;  /* that the first photons brought to the image */
} caustic_caster;

enum { CAUSTIC_CASTERS = 16 };

typedef struct caustics {
    caustic_caster casters[CAUSTIC_CASTERS];
    uint32_t count;
    bool *ends;                     /* by material: photons may end there, because it is not just smooth */
    bool images;                    /* some light from outside is that of images */
    double photons;                 /* for each sample of a pixel, of all pixels together */
    uint32_t x0, y0, width, height; /* the part of the image in the map */
    uint32_t groups;                /* of samples: 1 or SAMPLE_GROUPS */
    uint32_t layers;                /* all light, then that of each light group */
    float *map;                     /* rgb by pixel, layer, and group of samples */
} caustics;

/* ---- caustics.c ---- */

/* Sets *out to the plan's caustics, or to NULL if photons would gain nothing: no smooth object lies in the
 * light of a lamp with a size, or the camera cannot be connected. Everything else in the plan must be set.
 * Release with caustics_destroy(). The map depends only on the scene, the whole image, its number of samples
 * and the seed. It is incomplete if the watch stops it. */
fathom_status caustics_create(fathom_context *context, const render_plan *plan, plan_watch *watch,
                              caustics **out);
void caustics_destroy(caustics *c);
/* Bytes of the map; NULL: 0. */
size_t caustics_bytes(const caustics *c);
/* Before there is a plan: the bytes of the map, if a material could be that of a caster; it may turn out that
 * none is needed. */
size_t caustics_bytes_expected(const fathom_scene *scene, const fathom_settings *settings);
/* Adds the map's light to the samples of a batch. */
void caustics_add(const caustics *c, wave *w, const wave_batch *batch);

/* ---- casters.c ---- */

/* Finds the casters of a scene. False: out of memory. */
bool caustic_casters_find(const render_plan *plan, caustics *out);
/* Some material may be smooth. Every caster has such a material. */
bool caustic_smooth_materials(const fathom_scene *scene);

/* ---- share.c ---- */

/* Where a ray from a light, against the unit vector `direction`, enters the sphere to which it belongs. */
typedef struct caustic_entry {
    vec3_f32 p, n;  /* n: outwards */
    double density; /* factor of the density per solid angle of a light sample at p, which makes it one per
                       étendue */
    uint32_t caster;
} caustic_entry;
/* from, direction: the ray towards the light, which is `distance` away; INFINITY: outside the scene. False:
 * no photon follows this ray. */
bool caustic_enter(const caustics *c, vec3_f64 from, vec3_f64 direction, double distance, caustic_entry *out);

/* The density, per étendue at a point, with which the camera's samples find it: per pixel of area. way: from
 * the start of the camera's ray to the point; ng: the unit geometric normal there. */
double caustic_view(const shade_camera *camera, vec3_f64 way, vec3_f64 ng);

/* Both sides of the surface agree about the direction: a smooth surface maps it as seen from either end. */
static inline bool caustic_plain(vec3_f32 ng, vec3_f32 n, vec3_f32 direction) {
    return (dot_f32(ng, direction) > 0) == (dot_f32(n, direction) > 0);
}
/* Chains may begin at a surface of this material. */
static inline bool caustic_begins(const render_plan *plan, const shader *s) {
    return !(s->lobes & SHADER_DISPERSIVE) && !(plan->nested && s->encloses && s->priority);
}
/* Photons may follow the path through this lane, too: a smooth surface, and the way `to` that it sends the
 * path. */
bool caustic_follows(const vertex_block *v, const shader_sample *to, unsigned i);
/* A smooth surface whose shading normal differs from the geometric one does not conserve the étendue (Veach
 * 1997, 5.3): that of the light on the camera's side over that on the light's side. */
float caustic_stretch(const vertex_block *v, vec3_f32 to_light, vec3_f32 to_camera, unsigned i);
/* As caustic_follows() for a surface that is not smooth, after the first vertex. */
bool caustic_bounces(const render_plan *plan, const vertex_block *v, const shader_sample *to, unsigned i);
/* How a vertex after the first, if it is not smooth, changes the density of a chain over that of its photons.
 * Photons are taken to scatter by the cosine: weights may be any function of the path. density: of the
 * camera's path, in the direction to the light; cosine: of that, to the geometric normal. */
static inline float caustic_step(float density, float cosine) {
    const float step = (float)M_PI * density / fabsf(cosine);
    return step < 0x1p60f ? step : 0x1p60f;
}
/* The density of the chain that begins at the first vertex of a path, per étendue; 0: photons do not find
 * it. */
float caustic_chain(const path_wave *p, const vertex_block *v, const shader_sample *to, unsigned i,
                    uint32_t slot);
/* The share of a chain's light that the path counts; photons bring the rest. chain: the density of the
 * path's; found: that of photons per étendue. Samples of a pixel are points of a net, and vary less than
 * photons, so each counts as four (bench/path_tracing.md). */
static inline double caustic_share(const caustics *c, double chain, double found) {
    const double ratio = c->photons * found / (4 * chain);
    return 1 / (1 + ratio * ratio);
}

/* ---- photons.c: the paths of photons ---- */

/* The light that a photon brings to a pixel of the map. */
typedef struct caustic_splat {
    uint32_t pixel;
    uint8_t group, caster; /* group: of lights */
    float rgb[3];
    vec3_f32 direction; /* to the light */
} caustic_splat;

typedef struct photon_wave photon_wave;

/* NULL: out of memory. plan: see caustics.c. */
photon_wave *photon_wave_create(const render_plan *plan, const caustics *c, const atomic_bool *stop);
void photon_wave_destroy(photon_wave *w);

typedef ARRAY(caustic_splat) caustic_splats;
/* Photons [first, first + count) of a group; count is at most WAVE_SLOTS. Their light is that of one photon:
 * divide by their number. False: stopped, or out of memory. */
bool photon_wave_run(photon_wave *w, uint32_t group, uint32_t first, uint32_t count, caustic_splats *out);
