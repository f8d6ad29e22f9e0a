#include "cli/render/brightness.h"

#include "base/file.h"
#include "base/status.h"
#include "image/image.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The least share of the view that is worth a warning. */
#define MOST_PIXELS 0.5

/* 8 of 255 levels of sRGB, whose curve is 12.92 x there. */
#define DARK (8 / (255 * 12.92))

/* The built-in view clips at 1; of other views nothing is known. */
static bool any_for_display(const render_options *options) {
    char extension[16];
    for (size_t i = 0; i < options->outputs.count; ++i) {
        file_extension(options->outputs.items[i], extension);
        if (strcmp(extension, "exr") != 0) return image_view_is_srgb(&options->write);
    }
    return false;
}

static float strength(const fathom_light *light) {
    return fmaxf(light->intensity[0], fmaxf(light->intensity[1], light->intensity[2]));
}

static const fathom_light *strongest(const fathom_scene *scene) {
    const fathom_light *best = NULL;
    for (size_t i = 0; i < scene->lights.count; ++i) {
        if (!best || strength(&scene->lights.items[i]) > strength(best)) best = &scene->lights.items[i];
    }
    return best;
}

/* In the file's own unit: glTF's candela and lux are pi times the model's intensity (gltf_light.c). */
static void describe_light(const fathom_scene *scene, const char *path, char out[96]) {
    const fathom_light *light = strongest(scene);
    char extension[16];
    file_extension(path, extension);
    const bool gltf = strcmp(extension, "glb") == 0 || strcmp(extension, "gltf") == 0;
    if (!light)
        snprintf(out, 96, "what it shows clips");
    else if (gltf && scene->has_lights)
        snprintf(out, 96, "a light of %.5g %s clips", (double)strength(light) * 3.14159265358979324,
                 light->type == FATHOM_LIGHT_DIRECTIONAL ? "lux" : "cd");
    else
        snprintf(out, 96, "a light of intensity %.5g clips", (double)strength(light));
}

static void warn_black(fathom_context *context, const fathom_scene *scene, const char *path) {
    warn(context, "%s: all that is in view is black: %s", path,
         scene->lights.count
             ? "no light reaches it, or its materials send none on"
             : "the scene has no lights; give it some, or leave its empty list of lights out");
}

static void warn_clipped(fathom_context *context, const fathom_scene *scene, const char *path,
                         const fathom_brightness *b) {
    char light[96];
    describe_light(scene, path, light);
    warn(context, "%s: %s %.0f %% of the pixels; try --exposure %.1f, or --exposure auto", path, light,
         floor(100 * (double)b->clipped / (double)b->pixels), (double)b->exposure);
}

static void warn_dark(fathom_context *context, const char *path, const fathom_brightness *b) {
    warn(
        context,
        "%s: 99 %% of the pixels are nearly black, below 8 of 255 levels; try --exposure %.1f, or --exposure "
        "auto",
        path, (double)b->exposure);
}

void brightness_expose(const fathom_film *film, render_options *options) {
    fathom_brightness b;
    if (!options->exposure_auto) return;
    fathom_film_brightness(film, 0, &b);
    options->write.exposure = fminf(fmaxf(b.exposure, -64), 64);
}

void brightness_warn(fathom_context *context, const fathom_scene *scene, const fathom_film *film,
                     const render_options *options) {
    const float exposure = options->write.exposure;
    fathom_brightness b;
    fathom_film_brightness(film, exposure, &b);
    if (!b.pixels) return;
    if (b.black == b.pixels)
        warn_black(context, scene, options->scene);
    else if (!any_for_display(options) || options->exposure_auto)
        return;
    else if ((double)b.clipped > MOST_PIXELS * (double)b.pixels)
        warn_clipped(context, scene, options->scene, &b);
    else if (exp2((double)(exposure - b.exposure)) < DARK)
        warn_dark(context, options->scene, &b);
}
