#include "verify/light/shading_studio.h"

#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

void studio_open(fathom_context *context, const shading_options *options, shading_rows *rows, uint32_t width,
                 studio *out) {
    *out = (studio){.context = context, .options = options, .rows = rows};
    fathom_settings_default(&out->settings);
    out->settings.width = width, out->settings.height = 1;
    out->settings.max_depth = 64;
    out->settings.min_weight = 0;
    out->settings.tracer_spec = options->spec;
    out->status = fathom_scene_create(context, &out->scene);
}

fathom_status studio_close(studio *s) {
    fathom_film_destroy(s->film);
    fathom_scene_destroy(s->scene);
    return s->status;
}

/* ---- materials ---- */

fathom_material studio_black(void) {
    fathom_material m;
    fathom_material_default(&m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0;
    return m;
}

static void set_rgb(float out[3], float r, float g, float b) { out[0] = r, out[1] = g, out[2] = b; }

fathom_material studio_emitter(float r, float g, float b) {
    fathom_material m = studio_black();
    set_rgb(m.k_e, r, g, b);
    return m;
}

fathom_material studio_lambert(float r, float g, float b) {
    fathom_material m = studio_black();
    set_rgb(m.k_d, r, g, b);
    return m;
}

fathom_material studio_glass(float ior) {
    fathom_material m = studio_black();
    set_rgb(m.k_t, 1, 1, 1);
    m.ior = ior;
    return m;
}

/* ---- shapes, lights, camera ---- */

static fathom_id add_material(studio *s, const fathom_material *m) {
    fathom_id id = 0;
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_material(s->scene, NULL, m, &id);
    return id;
}

void studio_quad(studio *s, vec3_f64 center, vec3_f64 u, vec3_f64 v, const fathom_material *m) {
    fathom_quad quad;
    fathom_quad_default(&quad);
    double at[3], axis[3], other[3];
    store_f64(at, center), store_f64(axis, u), store_f64(other, v);
    fathom_quad_from_axes(at, axis, other, &quad);
    quad.material = add_material(s, m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_quad(s->scene, FATHOM_ROOT, &quad, NULL);
}

void studio_plane(studio *s, vec3_f64 point, vec3_f64 normal, const fathom_material *m) {
    fathom_plane plane;
    fathom_plane_default(&plane);
    store_f64(plane.point, point), store_f64(plane.normal, normal);
    plane.material = add_material(s, m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_plane(s->scene, FATHOM_ROOT, &plane, NULL);
}

void studio_sphere(studio *s, vec3_f64 center, double radius, const fathom_material *m) {
    fathom_sphere sphere;
    fathom_sphere_default(&sphere);
    store_f64(sphere.center, center), sphere.radius = radius;
    sphere.material = add_material(s, m);
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &sphere, NULL);
}

void studio_light(studio *s, const fathom_light *light) {
    if (s->status == FATHOM_OK) s->status = fathom_scene_add_light(s->scene, light, NULL);
}

void studio_point_light(studio *s, vec3_f64 at, float r, float g, float b) {
    fathom_light light;
    fathom_light_default(&light);
    store_f64(light.position, at);
    set_rgb(light.intensity, r, g, b);
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

/* ---- the image ---- */

bool studio_render(studio *s) {
    static const char *const names[3] = {"R", "G", "B"};
    fathom_film_destroy(s->film);
    s->film = NULL;
    s->broken = 0;
    if (s->status == FATHOM_OK)
        s->status = fathom_render(s->context, s->scene, &s->settings, s->options->progress, s->options->user,
                                  NULL, &s->film);
    if (s->status != FATHOM_OK) return false;
    for (int c = 0; c < 3; ++c) {
        s->channel[c] = fathom_film_channel(s->film, names[c]);
        for (uint32_t i = 0; i < s->settings.width; ++i) s->broken += isfinite(s->channel[c][i]) ? 0 : 1;
    }
    return true;
}

double studio_at(const studio *s, unsigned channel, uint32_t i) { return (double)s->channel[channel][i]; }

/* ---- rows ---- */

void studio_judge(studio_worst *worst, double measured, double expected, double bound) {
    double error = fabs(measured - expected);
    double share = error == 0 && bound >= 0 ? 0 : (bound > 0 ? error / bound : (double)INFINITY);
    if (!(share >= 0)) share = (double)INFINITY;
    if (worst->count++ && share <= worst->share) return;
    worst->share = share;
    worst->measured = measured, worst->expected = expected;
    worst->error = error, worst->bound = bound;
}

void studio_row(studio *s, const char *group, double parameter, const studio_worst *worst, const char *format,
                ...) {
    if (s->status != FATHOM_OK) return;
    shading_row row = {.group = group,
                       .parameter = parameter,
                       .spec = s->options->spec,
                       .measured = worst->measured,
                       .expected = worst->expected,
                       .error = worst->error,
                       .bound = worst->bound,
                       .ok = worst->count && worst->error <= worst->bound && !s->broken};
    va_list args;
    va_start(args, format);
    vsnprintf(row.what, sizeof row.what, format, args);
    va_end(args);
    if (!array_push(s->rows, row)) s->status = fail_memory(s->context, sizeof row);
}

double studio_twisted(const studio *s, double value) { return value * (1 + s->options->twist); }
