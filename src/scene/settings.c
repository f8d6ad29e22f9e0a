#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

void fathom_settings_default(fathom_settings *settings) {
    if (!settings) return;
    *settings = (fathom_settings){.width = 1280,
                                  .height = 720,
                                  .spp = 1,
                                  .pattern = FATHOM_PATTERN_GRID,
                                  .max_depth = 8,
                                  .min_weight = 1.0f / 65536,
                                  .terminator_fix = true,
                                  .tracer = FATHOM_TRACER_EMBREE,
                                  .block_width = 16,
                                  .tile_size = 32};
}

/* Half a level or unit, less a fiftieth for the roundings of the sums. The sRGB curve is concave: nowhere is
 * it steeper than in its linear part, of slope 12.9233, and rounding to levels moves by one where the curve
 * moves by less than half a level. Half floats of a value I are at least max(2^-24, 2^-11 I) apart, so half
 * of that is lost by no more than 2^-26 + 2^-13 I: the sum is at most twice the larger. */
void fathom_settings_set_loss(fathom_settings *settings, fathom_loss loss, float exposure) {
    if (!settings) return;
    const float most = 0.98f;
    settings->max_loss = settings->max_relative_loss = 0;
    switch (loss) {
    case FATHOM_LOSS_NONE: break;
    case FATHOM_LOSS_8BIT:
        settings->max_loss = fminf(most * 0.5f / 255 / 12.9233f * exp2f(-exposure), 1);
        break;
    case FATHOM_LOSS_HALF:
        settings->max_loss = most * 0x1p-26f, settings->max_relative_loss = most * 0x1p-13f;
        break;
    }
}

void fathom_scene_settings(const fathom_scene *scene, fathom_settings *out) {
    if (scene && out)
        *out = scene->settings;
    else
        fathom_settings_default(out);
}

static bool is_square(uint32_t n) {
    uint32_t root = (uint32_t)(sqrt((double)n) + 0.5);
    return root * root == n;
}

static fathom_status check_crop(fathom_context *context, const fathom_settings *s) {
    const uint32_t *c = s->crop;
    if (!c[0] && !c[1] && !c[2] && !c[3]) return FATHOM_OK;
    if (c[0] < c[2] && c[1] < c[3] && c[2] <= s->width && c[3] <= s->height) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, "crop",
                      "expected x0 < x1 <= %u and y0 < y1 <= %u, found x0 %u, y0 %u, x1 %u, y1 %u", s->width,
                      s->height, c[0], c[1], c[2], c[3]);
}

static bool is_power(uint32_t n) { return n && !(n & (n - 1)); }

static fathom_status check_target(fathom_context *context, const char *name, double value) {
    if (value >= 0 && isfinite(value)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, name, "expected a number >= 0 (0: off), found %g", value);
}

/* Every pass doubles the samples of a Sobol sequence. */
static fathom_status check_adaptive(fathom_context *context, const fathom_settings *s) {
    fathom_status status = check_target(context, "target error", s->target_error);
    if (status == FATHOM_OK) status = check_target(context, "max time", s->max_time);
    if (status != FATHOM_OK || !(s->target_error > 0 || s->max_time > 0)) return status;
    if (s->pattern != FATHOM_PATTERN_SOBOL) {
        return fail_field(context, FATHOM_BAD_INPUT, "pattern",
                          "sampling to an error or a time needs the pattern sobol");
    }
    if (s->spp < 4 || !is_power(s->spp)) {
        return fail_field(
            context, FATHOM_BAD_INPUT, "spp",
            "the most samples of a pixel when sampling to an error or a time; expected a power of "
            "two from 4, such as 1024, found %u",
            s->spp);
    }
    if (s->min_spp && (s->min_spp < 4 || s->min_spp > s->spp || !is_power(s->min_spp))) {
        return fail_field(context, FATHOM_BAD_INPUT, "min spp",
                          "expected a power of two from 4 to spp, which is %u, found %u", s->spp, s->min_spp);
    }
    return FATHOM_OK;
}

/* Values that no enumerator or bit stands for: the program's fault, no file's. */
static fathom_status check_choices(fathom_context *context, const fathom_settings *s) {
    if ((unsigned)s->pattern > FATHOM_PATTERN_SOBOL)
        return fail_field(context, FATHOM_BAD_USAGE, "pattern", "there is no pattern %u",
                          (unsigned)s->pattern);
    if ((unsigned)s->tracer > FATHOM_TRACER_REFERENCE)
        return fail_field(context, FATHOM_BAD_USAGE, "tracer", "there is no kind %u", (unsigned)s->tracer);
    if (s->aovs & ~(unsigned)FATHOM_AOVS)
        return fail_field(context, FATHOM_BAD_USAGE, "aovs", "expected FATHOM_AOV_ bits, found %#x", s->aovs);
    return FATHOM_OK;
}

fathom_status scene_check_settings(fathom_context *context, const fathom_settings *s) {
    fathom_status status = check_choices(context, s);
    if (status != FATHOM_OK) return status;
    if (s->width < 1 || s->width > 65536 || s->height < 1 || s->height > 65536) {
        return fail_field(context, FATHOM_BAD_INPUT, "image size",
                          "expected 1 to 65536 pixels each way, found %ux%u", s->width, s->height);
    }
    if (s->spp < 1 || s->spp > 65536) {
        return fail_field(context, FATHOM_BAD_INPUT, "spp", "expected 1 to 65536 samples a pixel, found %u",
                          s->spp);
    }
    status = check_adaptive(context, s);
    if (status != FATHOM_OK) return status;
    if (s->pattern != FATHOM_PATTERN_SOBOL && !is_square(s->spp)) {
        uint32_t root = (uint32_t)sqrt((double)s->spp);
        return fail_field(context, FATHOM_BAD_INPUT, "spp",
                          "the pattern is n x n, so expected a square number such as %u or %u, found %u; or "
                          "use the pattern sobol",
                          root * root, (root + 1) * (root + 1), s->spp);
    }
    if (s->max_depth > 64)
        return fail_field(context, FATHOM_BAD_INPUT, "max depth", "expected 0 to 64, found %u", s->max_depth);
    if (!(s->min_weight >= 0 && s->min_weight < 1)) {
        return fail_field(context, FATHOM_BAD_INPUT, "min weight", "expected a number in [0, 1), found %g",
                          (double)s->min_weight);
    }
    if (!(s->max_loss >= 0 && s->max_loss <= 1 && s->max_relative_loss >= 0 && s->max_relative_loss <= 1)) {
        return fail(context, FATHOM_BAD_INPUT,
                    "max loss, max relative loss: expected numbers in [0, 1], found %g and %g",
                    (double)s->max_loss, (double)s->max_relative_loss);
    }
    if (!(s->epsilon >= 0) || !isfinite(s->epsilon)) {
        return fail_field(context, FATHOM_BAD_INPUT, "epsilon",
                          "expected a number >= 0 (0: automatic), found %g", s->epsilon);
    }
    if (s->block_width != 1 && s->block_width != 4 && s->block_width != 8 && s->block_width != 16) {
        return fail_field(context, FATHOM_BAD_INPUT, "block width", "expected 1, 4, 8 or 16, found %u",
                          s->block_width);
    }
    if (s->tile_size < 32 || s->tile_size > 65536 || s->tile_size % 32) {
        return fail_field(context, FATHOM_BAD_INPUT, "tile size",
                          "expected a multiple of 32 up to 65536, found %u", s->tile_size);
    }
    return check_crop(context, s);
}

fathom_status fathom_scene_set_settings(fathom_scene *scene, const fathom_settings *settings) {
    if (!scene) return FATHOM_BAD_USAGE;
    if (!settings) return fail_null(scene->context, "settings");
    fathom_status status = scene_check_settings(scene->context, settings);
    if (status != FATHOM_OK) return status;
    char *spec = settings->tracer_spec ? strdup(settings->tracer_spec) : NULL; /* may be the scene's own */
    if (settings->tracer_spec && !spec) return fail_memory(scene->context, strlen(settings->tracer_spec) + 1);
    free(scene->tracer_spec);
    scene->settings = *settings;
    scene->settings.tracer_spec = scene->tracer_spec = spec;
    return FATHOM_OK;
}
