#include "verify/light/shading_studio.h"

#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

fathom_status shading_group(fathom_context *context, const shading_options *options, unsigned group,
                            shading_rows *out) {
    static void (*const groups[SHADING_GROUPS])(studio *) = {
        shading_mirrors, shading_guide, shading_ior, shading_highlights, shading_lights, shading_slants};
    studio s = {.b = {.context = context}, .options = options, .rows = out};
    groups[group](&s);
    return studio_end(&s);
}

fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out) {
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < SHADING_GROUPS && status == FATHOM_OK; ++i)
        status = shading_group(context, options, i, out);
    return status;
}

fathom_status studio_end(studio *s) {
    fathom_film_destroy(s->film);
    fathom_scene_destroy(s->b.scene);
    s->film = NULL, s->b.scene = NULL;
    return s->b.status;
}

void studio_begin(studio *s, uint32_t width) {
    studio_end(s);
    memset(s->worst, 0, sizeof s->worst);
    fathom_settings_default(&s->settings);
    fathom_settings_set_integrator(&s->settings, FATHOM_INTEGRATOR_CLASSIC);
    s->settings.width = width, s->settings.height = 1;
    s->settings.max_depth = 64;
    s->settings.min_weight = 0;
    s->settings.tracer = s->options->spec;
    if (s->b.status == FATHOM_OK) build_open(s->b.context, &s->b);
}

fathom_material studio_glass(float ior) {
    fathom_material m = build_black();
    m.k_t[0] = m.k_t[1] = m.k_t[2] = 1;
    m.ior = ior;
    return m;
}

void studio_camera(studio *s, vec3_f64 eye, vec3_f64 view, vec3_f64 across, double width) {
    fathom_camera camera;
    fathom_camera_default(&camera);
    vec3_f64 z = neg_f64(view), y = cross_f64(z, across);
    store_f64(camera.origin, eye), store_f64(camera.x, across);
    store_f64(camera.y, y), store_f64(camera.z, z);
    camera.d = 1, camera.w = width, camera.h = width / s->settings.width;
    build_camera(&s->b, camera);
}

vec3_f64 studio_direction(const studio *s, vec3_f64 view, vec3_f64 across, double width, uint32_t i) {
    return normalize_f64(madd_f64(view, ((i + 0.5) / s->settings.width - 0.5) * width, across));
}

uint32_t studio_render(studio *s) {
    static const char *const names[3] = {"R", "G", "B"};
    s->broken = 0;
    if (s->b.status == FATHOM_OK)
        s->b.status = fathom_render(s->b.context, s->b.scene, &s->settings, s->options->progress,
                                    s->options->user, NULL, &s->film);
    if (s->b.status != FATHOM_OK) return 0;
    for (int c = 0; c < 3; ++c) {
        s->channel[c] = fathom_film_channel(s->film, names[c]);
        for (uint32_t i = 0; i < s->settings.width; ++i) s->broken += isfinite(s->channel[c][i]) ? 0 : 1;
    }
    return s->settings.width;
}

double studio_at(const studio *s, unsigned channel, uint32_t i) { return (double)s->channel[channel][i]; }

void studio_judge(studio *s, unsigned row, double measured, double expected, double bound) {
    studio_worst *worst = &s->worst[row];
    double error = fabs(measured - expected);
    double share = error == 0 && bound >= 0 ? 0 : (bound > 0 ? error / bound : (double)INFINITY);
    if (!(share >= 0)) share = (double)INFINITY;
    if (worst->count++ && share <= worst->share) return;
    worst->share = share;
    worst->measured = measured, worst->expected = expected;
    worst->error = error, worst->bound = bound;
}

void studio_row(studio *s, unsigned row, const char *group, double parameter, const char *format, ...) {
    const studio_worst *worst = &s->worst[row];
    if (s->b.status != FATHOM_OK) return;
    shading_row out = {.group = group,
                       .parameter = parameter,
                       .spec = s->options->spec,
                       .measured = worst->measured,
                       .expected = worst->expected,
                       .error = worst->error,
                       .bound = worst->bound,
                       .ok = worst->count && worst->error <= worst->bound && !s->broken};
    va_list args;
    va_start(args, format);
    vsnprintf(out.what, sizeof out.what, format, args);
    va_end(args);
    if (!array_push(s->rows, out)) s->b.status = fail_memory(s->b.context, sizeof out);
}

double studio_twisted(const studio *s, double value) { return value * (1 + s->options->twist); }
