/* A law of light as a scene, with the radiance that it must show. */
#ifndef VERIFY_LAWS_ROOM_H
#define VERIFY_LAWS_ROOM_H

#include "verify/builder.h"

typedef struct law_room {
    builder b;
    double value[3]; /* the mean over the image */
    uint32_t depth;  /* bounces; default 64 */
    /* Radiance from outside; NULL: the scene's background. `user` of the call is NULL. See law_sky(). */
    vec3_f64 (*environment)(void *user, vec3_f64 direction);
    char sky[256]; /* a file of it, which is removed with the room; "": none */
} law_room;

typedef struct law {
    const char *name, *form; /* form: of its value */
    void (*make)(law_room *room);
} law;

/* The lists end with an empty name. */
extern const law laws_of_enclosures[], laws_of_lights[], laws_of_matter[], laws_of_layers[], laws_of_motion[];

fathom_status law_open(fathom_context *context, const law *made, law_room *out);
/* Release whatever law_open() returned. */
void law_close(law_room *room);

/* ---- materials ---- */

/* Metallic-roughness with neither base, reflection, transmission nor roughness: metallic 0, specular 0,
 * base 1. */
fathom_material law_metallic(void);

/* ---- shapes ---- */

/* A mesh: a fan of triangles around the first corner. */
void law_fan(law_room *room, const vec3_f64 *corners, uint32_t count, fathom_material m);
/* The six sides of the box of the corners ±1; as quads, or as meshes. */
void law_box(law_room *room, bool meshes, fathom_material m);
void law_point_light(law_room *room, vec3_f64 at, double intensity, double radius);
/* As a function, and as an environment light of an image of 1024 x 512 pixels. */
void law_sky(law_room *room, vec3_f64 (*radiance)(void *user, vec3_f64 direction));
/* Looks at one point: the image is 1/4096 as high as it is far away. */
void law_look(law_room *room, vec3_f64 eye, vec3_f64 target);
/* Looks along z, down to a square of this side around (0, 0, z). */
void law_look_down(law_room *room, double eye_z, double z, double side);
void law_value(law_room *room, vec3_f64 value);

/* Σ x^k for k from..to. */
double law_powers(double x, int from, int to);
/* The light that place 0 of the floor z = 0 gets from a flat polygon of the radiance 1, over pi. */
#define LAW_CORNERS 8u
double law_polygon(const vec3_f64 *corners, uint32_t count);
/* The reflectance of a material under an even sky, from a place above the origin. */
void law_lobe(law_room *room, fathom_material m, vec3_f64 from, vec3_f64 value);
/* A ball in an even sky, of a material that loses no light: it is not seen. */
void law_unseen_ball(law_room *room, fathom_material m);
/* A clear volume of metallicRoughness that reflects. */
fathom_material law_clear(double thickness);
/* The albedo of GGX with alphas along x and y and F = 1, seen from v. */
double law_ggx_albedo(double ax, double ay, vec3_f64 v);
/* A formula for the albedo of each channel. */
vec3_f64 law_each(vec3_f64 rho, double (*of)(double rho, const double *numbers), const double *numbers);

#endif
