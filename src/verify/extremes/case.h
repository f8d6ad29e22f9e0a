/* A scene with the data to trace and check rays in it; and functions that make the cases of the grid. */
#pragma once

#include "verify/builder.h"
#include "verify/extremes/extremes.h"
#include "verify/search/rays.h"

struct judged_scene {
    builder b;
    world *world;
    search *search;
    rays_source *source;
    char words[EXTREMES_WORDS];     /* description; the `make` function of an extreme case must set it */
    unsigned families;              /* bit i: use rays_family i; ignored if `maker` is set */
    rays_maker maker;               /* makes the case's own rays; `user` is the case */
    unsigned thin;                  /* for expensive rays: divide the number of rays by this; 0 means 1 */
    unsigned shape;                 /* of the group: CASE_SPHERES … */
    double number[4];               /* for maker and patch */
    void (*patch)(judged_scene *c); /* changes the world before it is used */
    ARRAY(void *) owned;            /* memory, freed with the case */
};

/* The families that test the weak points of any shape, except camera rays and directions of other lengths. */
#define CASE_FAMILIES                                                                                        \
    (1u << RAYS_UNIFORM | 1u << RAYS_EDGE | 1u << RAYS_VERTEX | 1u << RAYS_GRAZING | 1u << RAYS_TANGENT |    \
     1u << RAYS_SURFACE | 1u << RAYS_FAR | 1u << RAYS_AXIS | 1u << RAYS_INTERVAL | 1u << RAYS_ENDS)

/* Zeroes *out; then `make` adds shapes and selects the rays. Release with judged_close(), also after a
 * failure. */
fathom_status case_open(fathom_context *context, void (*make)(judged_scene *c, double parameter),
                        unsigned shape, double parameter, judged_scene *out);
/* Zeroed memory, freed with the case. After a failure: NULL, and the case's status is set. */
void *case_memory(judged_scene *c, size_t bytes);
void case_say(judged_scene *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- shapes, in the group of the builder: each call does nothing after a failure ---- */

/* Triangle k has the corners 3 k, 3 k + 1, 3 k + 2. */
void case_triangles(judged_scene *c, vec3_f64 origin, const vec3_f64 *corners, uint32_t triangles);
/* Scattered in a ball, with sizes from a hundredth of the radius. */
void case_spheres(judged_scene *c, vec3_f64 at, double radius);
void case_quads(judged_scene *c, vec3_f64 at, double radius);
/* A closed bumpy mesh with coordinates relative to `at`. */
void case_ball(judged_scene *c, vec3_f64 at, double radius);
void case_ball_of(judged_scene *c, vec3_f64 at, double radius, unsigned rings, unsigned around);
/* The shapes of the group: spheres or quads as above, or a closed mesh. */
enum { CASE_SPHERES, CASE_QUADS, CASE_TRIANGLES, CASE_PLANES };
void case_shapes(judged_scene *c, double radius);
/* Pseudo-random numbers in [low, high), the same on every machine. */
double case_scattered(unsigned i, unsigned k, double low, double high);
/* The numbers k, k + 1 and k + 2, in [-reach, reach). */
vec3_f64 case_scattered_point(unsigned i, unsigned k, double reach);

/* ---- scenes.c, rays.c, broken.c: the groups ---- */

void scale_make(judged_scene *c, double scale);
void offset_near(judged_scene *c, double offset);
void offset_raw(judged_scene *c, double offset);
void sliver_make(judged_scene *c, double aspect);
void grazing_make(judged_scene *c, double angle);
void tangent_make(judged_scene *c, double off);
void ratio_outside(judged_scene *c, double ratio);
void ratio_inside(judged_scene *c, double ratio);
void ratio_surface(judged_scene *c, double ratio);
void planet_make(judged_scene *c, double size);
void planet_outer(judged_scene *c, double size);
void copies_make(judged_scene *c, double count);
void overlap_level(judged_scene *c, double count);
void overlap_tilted(judged_scene *c, double count);
void nested_back(judged_scene *c, double ratio);
void nested_grow(judged_scene *c, double ratio);
void nested_stretch(judged_scene *c, double ratio);
void nested_mirror(judged_scene *c, double ratio);
void beyond_spheres(judged_scene *c, double at);
void beyond_quads(judged_scene *c, double at);
void beyond_triangles(judged_scene *c, double at);
void broken_make(judged_scene *c, double kind);
