#include "verify/light/shading_studio.h"

#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- running ---- */

fathom_status shading_group(fathom_context *context, const shading_options *options, unsigned group,
                            shading_rows *out) {
    static void (*const groups[SHADING_GROUPS])(studio *) = {
        shading_mirrors, shading_guide, shading_ior, shading_highlights, shading_lights, shading_slants};
    studio s = {.context = context, .options = options, .rows = out};
    groups[group](&s);
    return studio_end(&s);
}

fathom_status shading_run(fathom_context *context, const shading_options *options, shading_rows *out) {
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < SHADING_GROUPS && status == FATHOM_OK; ++i)
        status = shading_group(context, options, i, out);
    return status;
}

void shading_images_free(shading_images *images) {
    for (size_t i = 0; i < images->count; ++i) free(images->items[i].png);
    array_free(images);
    *images = (shading_images){.items = NULL};
}

fathom_status studio_end(studio *s) {
    fathom_film_destroy(s->film);
    fathom_scene_destroy(s->scene);
    s->film = NULL, s->scene = NULL;
    return s->status;
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
    if (s->status == FATHOM_OK) s->status = fathom_scene_create(s->context, &s->scene);
}

/* ---- materials ---- */

fathom_material studio_black(void) {
    fathom_material m;
    fathom_material_default(&m);
    m.k_d[0] = m.k_d[1] = m.k_d[2] = 0;
    return m;
}

fathom_material studio_emitter(float r, float g, float b) {
    fathom_material m = studio_black();
    m.k_e[0] = r, m.k_e[1] = g, m.k_e[2] = b;
    return m;
}

fathom_material studio_lambert(float r, float g, float b) {
    fathom_material m = studio_black();
    m.k_d[0] = r, m.k_d[1] = g, m.k_d[2] = b;
    return m;
}

fathom_material studio_glass(float ior) {
    fathom_material m = studio_black();
    m.k_t[0] = m.k_t[1] = m.k_t[2] = 1;
    m.ior = ior;
    return m;
}

/* ---- shapes, lights, camera ---- */

static fathom_id add_material(studio *s, const fathom_material *m) {
    fathom_id id = 0;
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_material(s->scene, NULL, m, &id);
    return id;
}

void studio_quad(studio *s, vec3_f64 center, vec3_f64 u, vec3_f64 v, fathom_material m) {
    fathom_quad quad;
    fathom_quad_default(&quad);
    double at[3], axis[3], other[3];
    store_f64(at, center), store_f64(axis, u), store_f64(other, v);
    fathom_quad_from_axes(at, axis, other, &quad);
    quad.material = add_material(s, &m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_quad(s->scene, FATHOM_ROOT, &quad, NULL);
}

void studio_plane(studio *s, vec3_f64 point, vec3_f64 normal, fathom_material m) {
    fathom_plane plane;
    fathom_plane_default(&plane);
    store_f64(plane.point, point), store_f64(plane.normal, normal);
    plane.material = add_material(s, &m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_plane(s->scene, FATHOM_ROOT, &plane, NULL);
}

void studio_sphere(studio *s, vec3_f64 center, double radius, fathom_material m) {
    fathom_sphere sphere;
    fathom_sphere_default(&sphere);
    store_f64(sphere.center, center), sphere.radius = radius;
    sphere.material = add_material(s, &m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &sphere, NULL);
}

void studio_light(studio *s, const fathom_light *light) {
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_light(s->scene, light, NULL);
}

void studio_point_light(studio *s, vec3_f64 at, float r, float g, float b) {
    fathom_light light;
    fathom_light_default(&light);
    store_f64(light.position, at);
    light.intensity[0] = r, light.intensity[1] = g, light.intensity[2] = b;
    studio_light(s, &light);
}

void studio_directional_light(studio *s, vec3_f64 direction) {
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_DIRECTIONAL;
    store_f64(light.direction, direction);
    studio_light(s, &light);
}

void studio_camera(studio *s, vec3_f64 eye, vec3_f64 view, vec3_f64 across, double width) {
    fathom_camera camera;
    fathom_camera_default(&camera);
    vec3_f64 z = neg_f64(view), y = cross_f64(z, across);
    store_f64(camera.origin, eye), store_f64(camera.x, across);
    store_f64(camera.y, y), store_f64(camera.z, z);
    camera.d = 1, camera.w = width, camera.h = width / s->settings.width;
    if (s->status == FATHOM_OK) s->status = fathom_scene_set_camera(s->scene, &camera);
}

vec3_f64 studio_direction(const studio *s, vec3_f64 view, vec3_f64 across, double width, uint32_t i) {
    return normalize_f64(madd_f64(view, ((i + 0.5) / s->settings.width - 0.5) * width, across));
}

/* ---- the image and its rows ---- */

uint32_t studio_render(studio *s) {
    static const char *const names[3] = {"R", "G", "B"};
    s->broken = 0;
    if (s->status == FATHOM_OK)
        s->status = fathom_render(s->context, s->scene, &s->settings, s->options->progress, s->options->user,
                                  NULL, &s->film);
    if (s->status != FATHOM_OK) return 0;
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
    if (s->status != FATHOM_OK) return;
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
    if (!array_push(s->rows, out)) s->status = fail_memory(s->context, sizeof out);
}

double studio_twisted(const studio *s, double value) { return value * (1 + s->options->twist); }
