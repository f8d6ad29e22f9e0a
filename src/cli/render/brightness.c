#include "cli/render/brightness.h"

#include "cli/outputs.h"

#include <fathom/survey.h>
#include <math.h>
#include <stdio.h>

/* Warns if more than this fraction of the pixels is affected. */
#define MOST_PIXELS 0.5

/* 8 of 255 levels of sRGB; the slope of the sRGB curve is 12.92 there. */
#define DARK (8 / (255 * 12.92))

/* In the studio, this fraction of the pixels may clip (highlights, lamps in mirrors). Above it, the exposure
 * drops by at most STUDIO_STOPS: a white surface in the studio has a radiance of at most 1.4, half a stop. */
#define STUDIO_CLIPPED 0.02
#define STUDIO_STOPS 0.5f

/* True if a file for the display clips at 1; this is known only of the built-in view. */
static bool any_for_display(const render_options *options) {
    if (options->part.path) return true; /* fathom merge may write one */
    return outputs_count_exr(&options->outputs) < options->outputs.count &&
           fathom_write_is_srgb(&options->write);
}

static float strength(const fathom_light *light) {
    return fmaxf(light->intensity[0], fmaxf(light->intensity[1], light->intensity[2]));
}

/* The intensity of the strongest light; below 0: there is no light. */
static float strongest(const fathom_scene *scene) {
    fathom_light light;
    float best = -1;
    for (uint32_t i = 0; i < fathom_scene_lights(scene); ++i) {
        if (fathom_scene_light(scene, i, &light) == FATHOM_OK) best = fmaxf(best, strength(&light));
    }
    return best;
}

static void warn_black(warning_list *warnings, const fathom_scene *scene, const char *path) {
    static const char unseen[] = "the camera sees no object or is inside one",
                      unlit[] = "no light reaches it, its materials reflect none",
                      none[] =
                          "the scene has no lights; give it some, or leave out its empty list of lights, or "
                          "--no-studio";
    warnings_tell(warnings, "%s: all that is in view is black: %s, or %s", path,
                  fathom_scene_lights(scene) ? unlit : unseen, fathom_scene_lights(scene) ? unseen : none);
}

static bool has_objects(const fathom_scene *scene) {
    const fathom_survey *survey;
    if (fathom_scene_survey(scene, &survey) != FATHOM_OK) return false;
    const bool found = survey->has_bounds || survey->planes;
    fathom_survey_destroy(survey);
    return found;
}

/* Not of a part of the image, nor of a frame of many: these may be empty. */
static void warn_empty(warning_list *warnings, const fathom_scene *scene, const char *path,
                       const render_options *options) {
    if (!options->settings.crop[2] && !frames_asked(&options->frames) && has_objects(scene))
        warnings_tell(warnings,
                      "%s: the image shows only the background: no object is in view, or all look like it",
                      path);
}

/* Describes the problem of the image at this exposure; false: there is none. scene: NULL if only its film is
 * known. */
static bool shows_little(const fathom_scene *scene, const fathom_brightness *b, float exposure,
                         char out[160]) {
    if ((double)b->clipped > MOST_PIXELS * (double)b->pixels) {
        const float most = scene ? strongest(scene) : -1;
        const int length = snprintf(out, 160, "%.0f %% of the pixels that show objects are white",
                                    floor(100 * (double)b->clipped / (double)b->pixels));
        if (most > 1)
            snprintf(out + length, 160 - (size_t)length, ", under a light of intensity %.5g", (double)most);
        return true;
    }
    if (exp2((double)(exposure - b->exposure)) >= DARK) return false;
    snprintf(out, 160, "99 %% of the lit pixels are nearly black, below 8 of 255 levels");
    return true;
}

static float within_limits(float exposure) { return fminf(fmaxf(exposure, -64), 64); }

/* Lowers the exposure for a white model, as photographers do. */
static float studio_exposure(const fathom_brightness *b) {
    if ((double)b->clipped <= STUDIO_CLIPPED * (double)b->pixels) return 0;
    return fminf(fmaxf(b->exposure, -STUDIO_STOPS), 0);
}

bool brightness_is_open(const render_options *options) {
    return options->exposure == EXPOSURE_AUTO ||
           (options->exposure == EXPOSURE_USUAL && any_for_display(options));
}

#define LARGEST_HALF 65504.0f
/* An image that needs more stops has nearly all pixels below 2^-14, where half floats lose digits. */
#define HALF_STOPS 14

static bool exceeds_half(const fathom_film *film) {
    static const char *const names[] = {"R", "G", "B"};
    uint32_t width, height;
    fathom_film_size(film, &width, &height);
    for (int c = 0; c < 3; ++c) {
        const float *values = fathom_film_channel(film, names[c]);
        for (size_t i = 0; i < (size_t)width * height; ++i) {
            if (values[i] > LARGEST_HALF) return true;
        }
    }
    return false;
}

static void warn_of_half(warning_list *warnings, const char *name, const fathom_film *film,
                         const fathom_brightness *b, const render_options *options) {
    if (options->write.float_color || !outputs_count_exr(&options->outputs)) return;
    if (exceeds_half(film))
        warnings_tell(warnings,
                      "%s: the .exr shows pixels above 65504 as 65504, the largest half float; --exr-float "
                      "keeps them",
                      name);
    if (b->exposure > HALF_STOPS)
        warnings_tell(
            warnings,
            "%s: the .exr has few digits of pixels as dark as these, below 0.00006, because they are "
            "half floats; --exr-float keeps them",
            name);
}

bool brightness_settle(warning_list *warnings, const fathom_scene *scene, const char *name,
                       const fathom_film *film, render_options *options) {
    float *exposure = &options->write.exposure;
    fathom_brightness b = {.size = sizeof b};
    char why[160];
    fathom_film_brightness(film, *exposure, &b);
    warn_of_half(warnings, name, film, &b, options);
    options->in_studio = b.in_studio;
    if (b.black == b.pixels) {
        if (scene && b.pixels) warn_black(warnings, scene, name);
        if (scene && !b.pixels) warn_empty(warnings, scene, name, options);
        return false;
    }
    if (options->exposure == EXPOSURE_AUTO) *exposure = within_limits(b.exposure);
    if (options->exposure == EXPOSURE_AUTO || !any_for_display(options)) return true;
    if (options->exposure == EXPOSURE_USUAL && b.in_studio) {
        *exposure = studio_exposure(&b);
        return true;
    }
    if (!shows_little(scene, &b, *exposure, why)) return true;
    if (options->exposure >= EXPOSURE_GIVEN) {
        warnings_tell(warnings, "%s: %s; try --exposure %.1f%s", name, why, (double)b.exposure,
                      options->exposure == EXPOSURE_KEPT ? " for all frames" : ", or --exposure auto");
        return true;
    }
    *exposure = within_limits(b.exposure);
    warnings_tell(warnings, "%s: %s, so the exposure is %.1f; --exposure 0 leaves it as it is", name, why,
                  (double)*exposure);
    return true;
}

void brightness_print(const render_options *options) {
    const bool chosen = options->exposure == EXPOSURE_AUTO ||
                        (options->exposure != EXPOSURE_GIVEN && options->write.exposure != 0);
    if (options->in_studio) fputs(", in the studio", stdout);
    if (chosen) printf(", exposure %g", (double)options->write.exposure);
}
