/* Renders the small scenes of the shading cases and collects rows. */
#pragma once

#include "verify/builder.h"
#include "verify/light/shading.h"

/* Unit roundoff of float. */
#define SHADING_U 0x1p-24

/* Measured and expected value at the worst pixel. */
typedef struct studio_worst {
    uint32_t count; /* pixels checked */
    double share;   /* error divided by bound; infinite for an error where none is allowed */
    double measured, expected, error, bound;
} studio_worst;

typedef struct studio {
    builder b;
    const shading_options *options;
    shading_rows *rows;
    fathom_settings settings;
    fathom_film *film;
    const float *channel[3];
    uint64_t broken;       /* channels of the image that are not finite */
    studio_worst worst[2]; /* a case has one or two rows */
} studio;

/* Starts a case: an empty scene, an image with one row of `width` pixels, paths of up to 64 bounces without a
 * throughput limit. Releases the previous case. */
void studio_begin(studio *s, uint32_t width);
/* Releases everything and returns the status. */
fathom_status studio_end(studio *s);

/* k_t is 1 in every channel. */
fathom_material studio_glass(float ior);

/* Sets a camera at `eye` that looks along `view`, with the image's +x along `across` (both unit, orthogonal).
 * At distance 1 the view is `width` wide. */
void studio_camera(studio *s, vec3_f64 eye, vec3_f64 view, vec3_f64 across, double width);
/* The unit direction through pixel i of that camera, in double. */
vec3_f64 studio_direction(const studio *s, vec3_f64 view, vec3_f64 across, double width, uint32_t i);

/* Renders; returns the number of pixels, 0 after a failure. */
uint32_t studio_render(studio *s);
double studio_at(const studio *s, unsigned channel, uint32_t i);

/* Checks a pixel for row 0 or 1 of the case. */
void studio_judge(studio *s, unsigned row, double measured, double expected, double bound);
/* Appends the row. It is ok if a pixel was checked, the error is within its bound and the image is finite. */
void studio_row(studio *s, unsigned row, const char *group, double parameter, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* value * (1 + twist), the parameter for a formula. */
double studio_twisted(const studio *s, double value);

/* ---- shading_beam.c: one path in double, and error bounds for the renderer's path in float ----
 *
 * `aside` bounds the perpendicular distance between the two lines. An oblique surface does not increase it,
 * because the outgoing line is as close again. `turned` bounds the difference of the unit directions. Both
 * are first-order in u = 2^-24. */
typedef struct beam {
    vec3_f64 at, along; /* along: unit */
    double aside, turned;
} beam;

/* Starts with a camera ray: each component of its direction is rounded once. */
beam beam_start(vec3_f64 eye, vec3_f64 direction);
/* Advances by t to a surface whose coordinates are below `size`. */
void beam_go(beam *b, double t, double size);
/* Reflects at the unit normal, whose own error is `normal_error`. */
void beam_mirror(beam *b, vec3_f64 normal, double normal_error);
/* Refracts by Snell's law with eta = n1/n2 at the unit normal, which points against the beam. False on total
 * internal reflection: the beam then stays unchanged. */
bool beam_refract(beam *b, vec3_f64 normal, double normal_error, double eta);
/* Square of the refracted cosine divided by its float error. If its magnitude is below 1, refraction and
 * total reflection are both correct. */
double beam_doubt(const beam *b, vec3_f64 normal, double normal_error, double eta);
/* Radiance at the beam's end on a Lambert surface of albedo 1: a point light of intensity 1 at height h over
 * the plane and distance r from the point gives h / r^3. It measures where the beam hits. */
double beam_radiance(const beam *b, vec3_f64 light, vec3_f64 normal, double size, double *bound);

/* ---- the groups ---- */
void shading_mirrors(studio *s);
void shading_guide(studio *s);
void shading_ior(studio *s);
void shading_highlights(studio *s);
void shading_lights(studio *s);
void shading_slants(studio *s);

#define SHADING_GROUPS 6
/* Runs one of the six. */
fathom_status shading_group(fathom_context *context, const shading_options *options, unsigned group,
                            shading_rows *out);
