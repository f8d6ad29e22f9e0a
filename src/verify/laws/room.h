/* A law of light transport as a scene, with the expected radiance. */
#pragma once

#include "verify/builder.h"

typedef struct law_room {
    builder b;
    double value[3]; /* expected mean over the image */
    uint32_t depth;  /* bounces; default 64 */
    double number;   /* that of the law */
    char sky[256];   /* image file of its environment light, removed with the room; "": none */
} law_room;

typedef struct law {
    const char *name, *form; /* form: formula of its value */
    void (*make)(law_room *room);
    double number; /* for laws that share `make` */
} law;

/* The lists end with an empty name. */
extern const law laws_of_enclosures[], laws_of_lights[], laws_of_matter[], laws_of_layers[], laws_of_motion[];

fathom_status law_open(fathom_context *context, const law *made, law_room *out);
/* Release whatever law_open() returned. */
void law_close(law_room *room);

/* ---- materials ---- */

/* A metallic-roughness material without reflection, transmission and roughness: metallic 0, specular 0, base
 * 1. */
fathom_material law_metallic(void);

/* ---- shapes ---- */

/* A mesh: a fan of triangles around the first corner. */
void law_fan(law_room *room, const vec3_f64 *corners, uint32_t count, fathom_material m);
/* The six sides of the box with corners ±1; as quads, or as meshes. */
void law_box(law_room *room, bool meshes, fathom_material m);
/* Adds an environment light with this radiance, as an image of 1024 x 512 pixels. */
void law_sky(law_room *room, vec3_f64 (*radiance)(vec3_f64 direction));
/* A camera that looks at one point. The image height is 1/4096 of the distance. */
void law_look(law_room *room, vec3_f64 eye, vec3_f64 target);
/* A camera that looks down along z at a square with this side around the origin. */
void law_look_down(law_room *room, double eye_z, double side);
void law_value(law_room *room, vec3_f64 value);

/* Σ x^k for k from..to. */
double law_powers(double x, int from, int to);
/* Irradiance at the origin of the floor z = 0 from a flat polygon with radiance 1, divided by pi. */
#define LAW_CORNERS 8u
double law_polygon(const vec3_f64 *corners, uint32_t count);
/* Measures the reflectance of a material at the origin under a uniform sky, seen from `from`. */
void law_lobe(law_room *room, fathom_material m, vec3_f64 from, vec3_f64 value);
/* Adds a ball of radius 0.5 at a distance of 2 from the origin, 0.6 radians off the z axis. Returns (R/d)²
 * cos θ, the irradiance at the origin if it emits 1, divided by pi. */
double law_ball(law_room *room, fathom_material m);
/* A ball of a lossless material in a uniform sky: it must be invisible. */
void law_unseen_ball(law_room *room, fathom_material m);
/* A metallic-roughness material: a clear volume with a reflecting surface. */
fathom_material law_clear(double thickness);
/* The material with an absorbing volume: `law_left` of the light is left after a distance of 1. */
fathom_material law_tinted(fathom_material m);
/* Directional albedo of GGX with roughness ax, ay along x and y and F = 1, for the view direction v. */
double law_ggx_albedo(double ax, double ay, vec3_f64 v);
/* Applies a formula to the albedo of each channel. */
vec3_f64 law_each(vec3_f64 rho, double (*of)(double rho, const double *numbers), const double *numbers);
