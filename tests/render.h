/* Scenes from a few lines, rendered in memory: for tests of images. */
#pragma once

#include "owned.h"

#include <stdio.h>

typedef struct stage {
    fathom_context *context;
    fathom_scene *scene;
    fathom_settings settings;
} stage;

static inline stage stage_open(uint32_t width, uint32_t height) {
    stage s = {.context = new_context()};
    s.scene = new_scene(s.context);
    fathom_settings_default(&s.settings);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_CLASSIC);
    s.settings.width = width, s.settings.height = height;
    return s;
}

static inline fathom_film *stage_render(stage *s) {
    fathom_film *film;
    assert_ok(s->context, fathom_render(s->context, s->scene, &s->settings, NULL, NULL, NULL, &film));
    return own_film(film);
}

static inline void stage_camera(stage *s, const double eye[3], const double target[3], const double up[3],
                                double fovy) {
    fathom_camera camera;
    fathom_camera_look_at(eye, target, up, fovy, &camera);
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
}

/* A camera on the z axis with this shutter, for scenes that move. */
static inline void stage_shutter(stage *s, double open, double close) {
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0, 0, 8}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.8, &camera);
    camera.shutter[0] = open, camera.shutter[1] = close;
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
}

static inline fathom_id stage_material(stage *s, const fathom_material *m) {
    return new_material(s->scene, NULL, m);
}

/* Sends out radiance `e` and nothing else. */
static inline fathom_id stage_emitter(stage *s, float e) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_e[c] = e;
    return stage_material(s, &m);
}

static inline fathom_id stage_lambert(stage *s, float k_d) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = k_d;
    return stage_material(s, &m);
}

static inline void stage_sphere(stage *s, double x, double y, double z, double radius, fathom_id material) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = x, sphere.center[1] = y, sphere.center[2] = z;
    sphere.radius = radius, sphere.material = material;
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &sphere, NULL));
}

static inline void stage_quad(stage *s, const double center[3], const double u[3], const double v[3],
                              fathom_id material) {
    fathom_quad quad;
    fathom_quad_from_axes(center, u, v, &quad);
    quad.material = material;
    assert_ok(s->context, fathom_scene_add_quad(s->scene, FATHOM_ROOT, &quad, NULL));
}

static inline void stage_plane(stage *s, const double point[3], const double normal[3], fathom_id material) {
    fathom_plane plane = default_plane();
    for (int i = 0; i < 3; ++i) plane.point[i] = point[i], plane.normal[i] = normal[i];
    plane.material = material;
    assert_ok(s->context, fathom_scene_add_plane(s->scene, FATHOM_ROOT, &plane, NULL));
}

static inline void stage_point_light(stage *s, double x, double y, double z, float intensity) {
    fathom_light light = default_light();
    light.position[0] = x, light.position[1] = y, light.position[2] = z;
    for (int c = 0; c < 3; ++c) light.intensity[c] = intensity;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

/* An image of one texel, of these numbers. */
static inline fathom_id stage_texel(stage *s, const float rgb[3]) {
    char bytes[32];
    const int header = snprintf(bytes, sizeof bytes, "PF\n1 1\n-1.0\n");
    memcpy(bytes + header, rgb, 3 * sizeof *rgb);
    fathom_texture t = default_texture();
    fathom_id id;
    t.bytes = bytes, t.byte_count = (size_t)header + 3 * sizeof *rgb, t.name = "texel.pfm";
    t.color_space = FATHOM_COLOR_LINEAR, t.filter = FATHOM_TEXTURE_NEAREST;
    assert_ok(s->context, fathom_scene_add_texture(s->scene, &t, &id));
    return id;
}

/* A sphere of 2 (rows - 1) segments triangles with its exact normals. */
static inline void stage_mesh_sphere(stage *s, fathom_id group, uint32_t rows, uint32_t segments,
                                     fathom_id material) {
    uint32_t vertices = (rows + 1) * segments, triangles = 2 * rows * segments;
    float *p = malloc(vertices * 3 * sizeof *p);
    uint32_t *index = malloc(triangles * 3 * sizeof *index);
    assert_non_null(p);
    assert_non_null(index);
    for (uint32_t r = 0; r <= rows; ++r) {
        for (uint32_t k = 0; k < segments; ++k) {
            double theta = 3.14159265358979 * r / rows, phi = 2 * 3.14159265358979 * k / segments;
            float *v = p + 3 * (r * segments + k);
            v[0] = (float)(sin(theta) * cos(phi)), v[1] = (float)cos(theta),
            v[2] = (float)(-sin(theta) * sin(phi));
        }
    }
    uint32_t *t = index;
    for (uint32_t r = 0; r < rows; ++r) {
        for (uint32_t k = 0; k < segments; ++k, t += 6) {
            uint32_t a = r * segments + k, b = r * segments + (k + 1) % segments, c = a + segments,
                     d = b + segments;
            t[0] = a, t[1] = c, t[2] = b, t[3] = b, t[4] = c, t[5] = d;
        }
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = mesh.normals = p;
    mesh.vertex_count = mesh.normal_count = vertices;
    mesh.indices = index, mesh.triangle_count = triangles, mesh.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
    free(p);
    free(index);
}
