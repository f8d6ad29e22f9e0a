/* The second implementation of path tracing: scalar, in double. It shares no formula with the fast one; it is
 * written for correctness and readability. It samples directions by the cosine, by half vectors, by balls
 * around lamps and by images of skies, and combines their densities. Only lights that rays cannot hit have
 * light samples.
 *
 * Radiance is divided by the square of the index of its medium, so that refraction does not scale it: a
 * viewer outside sees the emission inside glass unscaled. Only the settings below have an effect. */
#pragma once

#include "camera/filter.h"
#include "math/vec.h"
#include "scene/scene.h"

typedef struct reference_settings {
    uint32_t width, height; /* of the image */
    uint32_t samples;       /* of reference_render(): per pixel, at least 2 */
    uint32_t depth;         /* bounces */
    uint64_t seed;
    unsigned threads;           /* 0: one */
    const pixel_filter *filter; /* NULL: a box, one pixel wide */
    bool sharp;                 /* all samples are at the middle of the shutter's time */
    bool terminator_fix;        /* as in fathom_settings */
    bool without_bvh;           /* closest hits by testing every primitive */
} reference_settings;

typedef struct reference_estimate {
    double mean[3], error[3]; /* error: the standard error of the mean */
} reference_estimate;

typedef struct reference_scene reference_scene;

/* FATHOM_BAD_INPUT names the first feature of the scene that the reference does not support. The scene must
 * have passed fathom_scene_check(), have a camera and outlive the result. */
fathom_status reference_open(const fathom_scene *scene, const reference_settings *settings,
                             reference_scene **out);
void reference_close(reference_scene *reference);

/* One sample of the radiance of the pixel (x, y) of the image. False: volumes overlap without priorities,
 * which is not supported; reference_check() then says so. Thread-safe. */
bool reference_sample(reference_scene *reference, uint32_t x, uint32_t y, uint32_t index, vec3_f64 *out);
/* FATHOM_BAD_INPUT if a sample of a reference failed; NULL: none is in use. */
fathom_status reference_check(const reference_scene *reference);

/* out: of each pixel, row by row from the top. */
fathom_status reference_render(const fathom_scene *scene, const reference_settings *settings,
                               reference_estimate *out);
