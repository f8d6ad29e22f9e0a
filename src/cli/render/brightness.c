#include "cli/render/brightness.h"

#include "base/file_name.h"

#include <fathom/survey.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The share of the pixels from which on there is a warning. */
#define MOST_PIXELS 0.5

/* 8 of 255 levels of sRGB, whose curve is 12.92 x there. */
#define DARK (8 / (255 * 12.92))

/* Only the built-in view is known to clip at 1. */
static bool any_for_display(const render_options *options) {
    char extension[16];
    for (size_t i = 0; i < options->outputs.count; ++i) {
        file_extension(options->outputs.items[i], extension);
        if (strcmp(extension, "exr") != 0) return fathom_write_is_srgb(&options->write);
    }
    return false;
}

static float strength(const fathom_light *light) {
    return fmaxf(light->intensity[0], fmaxf(light->intensity[1], light->intensity[2]));
}

/* Below 0: there is none. */
static float strongest(const fathom_scene *scene) {
    fathom_light light;
    float best = -1;
    for (uint32_t i = 0; i < fathom_scene_lights(scene); ++i) {
        if (fathom_scene_light(scene, i, &light) == FATHOM_OK) best = fmaxf(best, strength(&light));
    }
    return best;
}

static void warn_black(warning_list *warnings, const fathom_scene *scene, const char *path) {
    warnings_tell(warnings, "%s: all that is in view is black: %s", path,
                  fathom_scene_lights(scene)
                      ? "no light reaches it, or its materials send none on"
                      : "the scene has no lights; give it some, or leave its empty list of lights out");
}

static void warn_clipped(warning_list *warnings, const fathom_scene *scene, const char *path,
                         const fathom_brightness *b) {
    const float most = strongest(scene);
    char light[96] = "what it shows clips";
    if (most >= 0) snprintf(light, sizeof light, "a light of intensity %.5g clips", (double)most);
    warnings_tell(warnings, "%s: %s %.0f %% of the pixels; try --exposure %.1f, or --exposure auto", path,
                  light, floor(100 * (double)b->clipped / (double)b->pixels), (double)b->exposure);
}

static void warn_dark(warning_list *warnings, const char *path, const fathom_brightness *b) {
    warnings_tell(
        warnings,
        "%s: 99 %% of the pixels are nearly black, below 8 of 255 levels; try --exposure %.1f, or --exposure "
        "auto",
        path, (double)b->exposure);
}

void brightness_expose(const fathom_film *film, render_options *options) {
    fathom_brightness b = {.size = sizeof b};
    if (!options->exposure_auto) return;
    fathom_film_brightness(film, 0, &b);
    options->write.exposure = fminf(fmaxf(b.exposure, -64), 64);
}

void brightness_warn(warning_list *warnings, const fathom_scene *scene, const fathom_film *film,
                     const render_options *options) {
    const float exposure = options->write.exposure;
    fathom_brightness b = {.size = sizeof b};
    fathom_film_brightness(film, exposure, &b);
    if (!b.pixels) return;
    if (b.black == b.pixels)
        warn_black(warnings, scene, options->scene);
    else if (!any_for_display(options) || options->exposure_auto)
        return;
    else if ((double)b.clipped > MOST_PIXELS * (double)b.pixels)
        warn_clipped(warnings, scene, options->scene, &b);
    else if (exp2((double)(exposure - b.exposure)) < DARK)
        warn_dark(warnings, options->scene, &b);
}
