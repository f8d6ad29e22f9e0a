/* The second implementation of path tracing: scalar, in double. It shares no formula with the fast one, and
 * is there to be right and to be read. Its directions are found by the cosine, by half vectors and by balls
 * around lamps, all weighed together. It has no light samples but of lights that no ray meets.
 *
 * Radiance is divided by the square of the index of the medium that it travels in, so that refraction does
 * not scale it: emission inside glass is what a viewer outside sees. Settings other than these do not
 * matter to it. */
#ifndef INTEGRATE_REFERENCE_H
#define INTEGRATE_REFERENCE_H

#include "math/vec.h"
#include "scene/scene.h"

typedef struct reference_settings {
    uint32_t width, height; /* of the image */
    settings_region region; /* the pixels to render */
    uint32_t samples;       /* of each pixel, at least 2 */
    uint32_t depth;         /* bounces */
    uint64_t seed;
    unsigned threads; /* 0: one */
    bool sharp;       /* all samples are of the middle of the shutter's time */
    bool without_bvh; /* closest hits by testing every primitive */
    /* Radiance from outside in a unit direction, in place of environment lights; NULL: the scene's background
     * alone. Called from several threads. */
    vec3_f64 (*environment)(void *user, vec3_f64 direction);
    void *user;
} reference_settings;

typedef struct reference_estimate {
    double mean[3], error[3]; /* error: the standard error of the mean */
} reference_estimate;

typedef struct reference_scene reference_scene;

/* FATHOM_BAD_INPUT names the first thing in the scene that the reference refuses. The scene must have passed
 * fathom_scene_check(), have a camera and outlive what comes back. */
fathom_status reference_open(const fathom_scene *scene, const reference_settings *settings,
                             reference_scene **out);
void reference_close(reference_scene *reference);

/* One sample of the radiance of a pixel, seen through the camera; (x, y) in the image. False: volumes
 * overlap, which the reference refuses. */
bool reference_sample(const reference_scene *reference, uint32_t x, uint32_t y, uint32_t index,
                      vec3_f64 *out);

/* out: of each pixel of the region, row by row from the top. */
fathom_status reference_render(const fathom_scene *scene, const reference_settings *settings,
                               reference_estimate *out);

#endif
