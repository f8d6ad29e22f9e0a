/* A scene in which a turned quad, a nested sphere, the vertices of a mesh and the camera move. */
#pragma once

#include "render.h"

#include <string.h>

static fathom_material shiny(void) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = 0.5f, m.roughness = 0.5f, m.multiscatter = false;
    m.base_color[1] = 0.6f, m.base_color[2] = 0.3f;
    return m;
}

/* The moving things in the scene of moving_stage(). */
enum { TURN = 1, FLY = 2, BEND = 4, PAN = 8, NEST = 16, ALL = 31 };

static const double key_times[2] = {0, 2};
static const double still_map[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static fathom_id place(stage *s, fathom_id parent, fathom_id group, const double from[12],
                       const double to[12], bool moves) {
    double maps[24];
    memcpy(maps, from, 12 * sizeof *maps);
    memcpy(maps + 12, moves ? to : from, 12 * sizeof *maps);
    fathom_instance instance = default_instance();
    instance.parent = parent, instance.group = group;
    instance.key_count = 2, instance.key_times = key_times, instance.key_transforms = maps;
    fathom_id id;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, &id));
    return id;
}

static void look(stage *s, bool pans, double open, double close) {
    const double frames[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 6, 1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 5.5};
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0, 0, 6}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7, &camera);
    camera.shutter[0] = open, camera.shutter[1] = close;
    if (pans) camera.key_count = 2, camera.key_times = key_times, camera.key_frames = frames;
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
}

static void bending_mesh(stage *s, bool moves, fathom_id material) {
    const float from[18] = {-2, -1, 0, -1, -1, 0, -1.5f, 0.5f, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const float to[9] = {-2, -1, 0, -1, -1, 0.5f, -0.5f, 1, 0.5f};
    float keys[18], normals[18];
    memcpy(keys, from, 9 * sizeof *keys);
    memcpy(keys + 9, moves ? to : from, 9 * sizeof *keys);
    memcpy(normals, from + 9, 9 * sizeof *normals);
    memcpy(normals + 9, from + 9, 9 * sizeof *normals);
    if (moves) normals[9] = -0.3f;
    fathom_mesh mesh = default_mesh();
    mesh.positions = from, mesh.vertex_count = 3, mesh.normals = from + 9, mesh.normal_count = 3;
    mesh.indices = (const uint32_t[]){0, 1, 2}, mesh.triangle_count = 1, mesh.material = material;
    mesh.key_count = 2, mesh.key_times = key_times, mesh.key_positions = keys, mesh.key_normals = normals;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

static inline stage moving_stage(unsigned moves, double open, double close) {
    const double turned[12] = {-1, 0, 0, 0.3, 0, -1.2, 0,
                               0,  0, 0, 1,   0}; /* half around z, which is refused
                                                      no sooner than a whole turn */
    const double flown[12] = {1, 0, 0, 0.8, 0, 1, 0, 0.6, 0, 0, 1, 0.4},
                 arm[12] = {1, 0, 0, 1.2, 0, 1, 0, 0, 0, 0, 1, 0};
    const double quarter[12] = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};
    stage s = stage_open(32, 32);
    const fathom_material m = shiny();
    const fathom_id material = stage_material(&s, &m), red = stage_lambert(&s, 0.6f);
    const fathom_id turning = new_group(s.scene, NULL), flying = new_group(s.scene, NULL),
                    nest = new_group(s.scene, NULL);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 64, s.settings.max_depth = 4;
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.3f, 0.4f, 0.5f}));
    stage_quad(&s, (double[3]){0, 3, 1}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1}, stage_emitter(&s, 4));
    stage_quad(&s, (double[3]){0, -1.5, 0}, (double[3]){5, 0, 0}, (double[3]){0, 0, -5}, red);
    fathom_quad plate;
    fathom_quad_from_axes((double[3]){0, 0, 0}, (double[3]){0.9, 0.2, 0}, (double[3]){0, 0.5, 0.2}, &plate);
    plate.material = material;
    assert_ok(s.context, fathom_scene_add_quad(s.scene, turning, &plate, NULL));
    fathom_sphere ball = default_sphere();
    ball.radius = 0.4, ball.material = red;
    assert_ok(s.context, fathom_scene_add_sphere(s.scene, flying, &ball, NULL));
    place(&s, FATHOM_ROOT, turning, still_map, turned, moves & TURN);
    place(&s, FATHOM_ROOT, nest, still_map, quarter, moves & NEST);
    place(&s, nest, flying, arm, flown, moves & FLY);
    bending_mesh(&s, moves & BEND, red);
    look(&s, moves & PAN, open, close);
    return s;
}
