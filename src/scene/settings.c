#include "scene/settings.h"

#include "base/sized.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

/* The losses are half a level, or half a unit in the last place, minus 2 % for the rounding errors of sums.
 * The sRGB curve is concave and steepest in its linear part, with slope 12.9233. If the curve changes by less
 * than half a level, the rounded level changes by at most one. Half floats near a value I are at least
 * max(2^-24, 2^-11 I) apart. Half of that is at least 2^-26 + 2^-13 I, because a sum is at most twice the
 * larger term. */
fathom_status fathom_settings_set_loss(fathom_settings *settings, fathom_loss loss, float exposure) {
    fathom_settings full;
    fathom_status status = SIZED_OWN(NULL, fathom_settings, settings, &full);
    if (status == FATHOM_OK && loss > FATHOM_LOSS_HALF) status = FATHOM_BAD_USAGE;
    if (status != FATHOM_OK) return status;
    const float most = 0.98f;
    full.max_loss = full.max_relative_loss = 0;
    switch (loss) {
    case FATHOM_LOSS_NONE: break;
    case FATHOM_LOSS_8BIT: full.max_loss = fminf(most * 0.5f / 255 / 12.9233f * exp2f(-exposure), 1); break;
    case FATHOM_LOSS_HALF: full.max_loss = most * 0x1p-26f, full.max_relative_loss = most * 0x1p-13f; break;
    }
    sized_write(settings, &full, sizeof full);
    return FATHOM_OK;
}

fathom_status fathom_settings_set_integrator(fathom_settings *settings, fathom_integrator integrator) {
    fathom_settings full;
    fathom_status status = SIZED_OWN(NULL, fathom_settings, settings, &full);
    if (status == FATHOM_OK && integrator > FATHOM_INTEGRATOR_REFERENCE) status = FATHOM_BAD_USAGE;
    if (status != FATHOM_OK) return status;
    const bool path = integrator != FATHOM_INTEGRATOR_CLASSIC;
    full.integrator = integrator;
    full.pattern = path ? FATHOM_PATTERN_SOBOL : FATHOM_PATTERN_GRID;
    full.max_depth = path ? 16 : 8;
    full.spp = path ? 1024 : 1;
    full.target_error = path ? 0.02 : 0;
    sized_write(settings, &full, sizeof full);
    return FATHOM_OK;
}

void fathom_scene_settings_sized(const fathom_scene *scene, fathom_settings *out, size_t size) {
    if (!scene) {
        fathom_settings_default_sized(out, size);
        return;
    }
    fathom_settings settings = scene->settings;
    settings.size = size;
    sized_give(out, size, &settings, sizeof settings);
}

bool settings_spp_is_square(uint32_t n) {
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

/* Every pass of adaptive sampling doubles the samples of a Sobol sequence, so spp is a power of two. */
static fathom_status check_adaptive(fathom_context *context, const fathom_settings *s) {
    if (!(s->target_error > 0 || s->max_time > 0)) return FATHOM_OK;
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
    if (s->min_spp && (s->min_spp > s->spp || !is_power(s->min_spp))) {
        return fail_field(context, FATHOM_BAD_INPUT, "min spp",
                          "expected a power of two from 4 to spp, which is %u, found %u", s->spp, s->min_spp);
    }
    return FATHOM_OK;
}

/* The error can be estimated only from samples with several independent scrambles. */
static fathom_status check_error(fathom_context *context, const fathom_settings *s) {
    const bool in_groups =
        s->pattern == FATHOM_PATTERN_SOBOL &&
        (s->integrator != FATHOM_INTEGRATOR_CLASSIC || s->target_error > 0 || s->max_time > 0);
    if (!(s->aovs & FATHOM_AOV_ERROR) || in_groups) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_INPUT, "aovs",
                      "error needs the pattern sobol, and the integrator path or a target error or max time");
}

fathom_status scene_check_settings(fathom_context *context, const fathom_settings *s) {
    fathom_status status = parameters_check(context, settings_table, s);
    if (status == FATHOM_OK) status = check_adaptive(context, s);
    if (status == FATHOM_OK) status = check_error(context, s);
    if (status != FATHOM_OK) return status;
    if (s->pattern != FATHOM_PATTERN_SOBOL && !settings_spp_is_square(s->spp)) {
        uint32_t root = (uint32_t)sqrt((double)s->spp);
        return fail_field(context, FATHOM_BAD_INPUT, "spp",
                          "the pattern is n x n, so expected a square number such as %u or %u, found %u; or "
                          "use the pattern sobol",
                          root * root, (root + 1) * (root + 1), s->spp);
    }
    return check_crop(context, s);
}

fathom_status fathom_scene_set_settings(fathom_scene *scene, const fathom_settings *settings) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_settings full;
    fathom_status status = SIZED_OWN(scene->context, fathom_settings, settings, &full);
    if (status == FATHOM_OK) status = scene_check_settings(scene->context, &full);
    if (status != FATHOM_OK) return status;
    char *tracer = full.tracer ? strdup(full.tracer) : NULL; /* full.tracer may be the scene's own text */
    if (full.tracer && !tracer) return fail_memory(scene->context, strlen(full.tracer) + 1);
    free(scene->tracer);
    scene->settings = full;
    scene->settings.tracer = scene->tracer = tracer;
    return FATHOM_OK;
}

fathom_status fathom_settings_check(fathom_context *context, const fathom_settings *settings) {
    if (!context) return FATHOM_BAD_USAGE;
    fathom_settings full;
    fathom_status status = SIZED_OWN(context, fathom_settings, settings, &full);
    return status == FATHOM_OK ? scene_check_settings(context, &full) : status;
}

/* ---- by name ---- */

static fathom_status find(fathom_context *context, const fathom_settings *settings, const char *name,
                          const void *value, const fathom_parameter **out, fathom_settings *full) {
    *out = NULL;
    if (!context) return FATHOM_BAD_USAGE;
    fathom_status status = SIZED_OWN(context, fathom_settings, settings, full);
    if (status != FATHOM_OK) return status;
    if (!name) return fail_null(context, "name");
    if (!value) return fail_null(context, "value");
    *out = parameter_find(settings_table, name);
    if (*out && (*out)->offset < settings->size) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, "settings",
                      "there is no \"%.60s\"; expected a name in fathom_settings_parameters()", name);
}

fathom_status fathom_settings_set_text(fathom_context *context, fathom_settings *settings, const char *name,
                                       const char *value) {
    char wrong[PARAMETER_WRONG], shown[PARAMETER_NAME];
    const fathom_parameter *p;
    fathom_settings full;
    fathom_status status = find(context, settings, name, value, &p, &full);
    if (status != FATHOM_OK) return status;
    parameter_name(p, ' ', shown);
    if (!parameter_read(p, value, &full, wrong))
        return fail_field(context, FATHOM_BAD_INPUT, shown, "%s", wrong);
    sized_write(settings, &full, sizeof full);
    return FATHOM_OK;
}

fathom_status fathom_settings_get_text(fathom_context *context, const fathom_settings *settings,
                                       const char *name, char *out, size_t size) {
    const fathom_parameter *p;
    fathom_settings full;
    fathom_status status = find(context, settings, name, out, &p, &full);
    if (status != FATHOM_OK) return status;
    const size_t length = parameter_print(p, &full, out, size);
    if (length < size) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, name, "its text takes %zu bytes, found room for %zu",
                      length + 1, size);
}
