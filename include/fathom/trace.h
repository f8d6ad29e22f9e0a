/* Traces your own rays against a scene. */
#ifndef FATHOM_TRACE_H
#define FATHOM_TRACE_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fathom_tracer fathom_tracer;

typedef struct fathom_ray {
    double origin[3];
    double direction[3]; /* need not be unit: t is in its units */
    double t_min, t_max; /* the open interval; t_min may be negative, t_max infinite */
} fathom_ray;

typedef struct fathom_hit {
    double t; /* infinite: no hit, and nothing else is set */
    double position[3];
    float geometric_normal[3], shading_normal[3]; /* unit, world, outward as the shape defines it */
    float u, v; /* mesh: its uvs, else barycentric (u of the second corner, v of the third); quad: along its
                   sides; plane: distances along its tangents; sphere and point: azimuth / 2 pi and polar
                   angle / pi around its own z */
    fathom_id object;    /* the id that fathom_scene_add_…() returned */
    fathom_id primitive; /* of a mesh: the triangle or the point; else 0 */
    fathom_id instance;  /* FATHOM_NONE in the root group */
    fathom_id material;
} fathom_hit;

/* Checks a tracer specification such as "bvh:f64". FATHOM_BAD_USAGE: the message names the wrong word and
 * lists the valid ones. A library FILE.so is not opened. Without a context there is no message; words NULL
 * means Embree. */
FATHOM_API fathom_status fathom_tracer_check(fathom_context *context, const char *words);
/* Builds the acceleration structure. words: as in fathom_settings, NULL for Embree; FATHOM_BAD_USAGE when no
 * tracer is called that; FATHOM_BAD_INPUT when something moves while the camera's shutter is open. The scene
 * must outlive the tracer and must not change. */
FATHOM_API fathom_status fathom_tracer_create(fathom_context *context, const fathom_scene *scene,
                                              const char *words, fathom_tracer **out);
FATHOM_API void fathom_tracer_destroy(fathom_tracer *tracer);
/* Closest hits. rays and hits may be NULL when count is 0. FATHOM_BAD_USAGE when a ray is not finite or
 * its direction is zero: the message names it, and hits of the rays before it are set. Any number of
 * threads may call at the same time; if several fail, the message is that of one of them; read it when all
 * have returned. With Embree, a ray within a few roundings of a mesh's vertex can slip through: 2 % of
 * rays aimed exactly at vertices do. Renders repair this. For single rays, use the tracer "reference". If
 * objects are farther apart than 1e7 times their size, float can miss those far from the scene's origin.
 * Rays also hit surfaces that a material makes transparent. */
FATHOM_API fathom_status fathom_tracer_closest(const fathom_tracer *tracer, const fathom_ray *rays,
                                               size_t count, fathom_hit *hits);
/* Any hit. Shapes that cast no shadow count, too. */
FATHOM_API fathom_status fathom_tracer_any(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                           bool *hits);

#ifdef __cplusplus
}
#endif
#endif
