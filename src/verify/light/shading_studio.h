/* A small scene in the making, its image, and the rows that come of it. The first failure is kept, and all
 * calls after it do nothing: a case reads as a list of what is in it. */
#ifndef EXTREMES_SHADING_STUDIO_H
#define EXTREMES_SHADING_STUDIO_H

#include "math/vec.h"
#include "verify/light/shading.h"

/* Unit roundoff of float. */
#define SHADING_U 0x1p-24

typedef struct studio {
    fathom_context *context;
    const shading_options *options;
    shading_rows *rows;
    fathom_status status;
    fathom_scene *scene;
    fathom_settings settings;
    fathom_film *film; /* the last one rendered */
    const float *channel[3];
    uint64_t broken; /* channels of it that are not finite */
} studio;

/* An image of `width` pixels in one row; paths of up to 64 bounces, none given up for its weight. */
void studio_open(fathom_context *context, const shading_options *options, shading_rows *rows, uint32_t width,
                 studio *out);
/* The status of all that was done. */
fathom_status studio_close(studio *s);

/* All black. */
fathom_material studio_black(void);
/* Sends out (r, g, b). */
fathom_material studio_emitter(float r, float g, float b);
/* Lambert's, reflecting (r, g, b). */
fathom_material studio_lambert(float r, float g, float b);
/* k_t 1 in every channel. */
fathom_material studio_glass(float ior);

/* Each surface brings its own material. */
void studio_quad(studio *s, vec3_f64 center, vec3_f64 u, vec3_f64 v, const fathom_material *m);
void studio_plane(studio *s, vec3_f64 point, vec3_f64 normal, const fathom_material *m);
void studio_sphere(studio *s, vec3_f64 center, double radius, const fathom_material *m);
void studio_light(studio *s, const fathom_light *light);
void studio_point_light(studio *s, vec3_f64 at, float r, float g, float b);

/* Looks from `eye` along `view`, +x of the image along `across` (both unit, at right angles); the image plane
 * at distance 1 is `width` wide. */
void studio_camera(studio *s, vec3_f64 eye, vec3_f64 view, vec3_f64 across, double width);
/* The direction through pixel i, as the camera above defines it: unit, in double. */
vec3_f64 studio_direction(const studio *s, vec3_f64 view, vec3_f64 across, double width, uint32_t i);

/* False when it failed. */
bool studio_render(studio *s);
double studio_at(const studio *s, unsigned channel, uint32_t i);

/* What was measured and what it should be, at the worst of some pixels. */
typedef struct studio_worst {
    uint32_t count; /* pixels judged */
    double share;   /* of its bound that the error takes; infinite for an error where none may be */
    double measured, expected, error, bound;
} studio_worst;

void studio_judge(studio_worst *worst, double measured, double expected, double bound);
/* A row, right when something was judged, the error is within its bound and the image finite. */
void studio_row(studio *s, const char *group, double parameter, const studio_worst *worst, const char *format,
                ...) __attribute__((format(printf, 5, 6)));

/* value * (1 + twist): where a formula takes its parameter from. */
double studio_twisted(const studio *s, double value);

/* ---- the groups: each appends its rows ---- */
fathom_status shading_mirrors(fathom_context *context, const shading_options *options, shading_rows *rows);
fathom_status shading_guide(fathom_context *context, const shading_options *options, shading_rows *rows);
fathom_status shading_ior(fathom_context *context, const shading_options *options, shading_rows *rows);
fathom_status shading_highlights(fathom_context *context, const shading_options *options, shading_rows *rows);
fathom_status shading_lights(fathom_context *context, const shading_options *options, shading_rows *rows);
fathom_status shading_slants(fathom_context *context, const shading_options *options, shading_rows *rows);

#endif
