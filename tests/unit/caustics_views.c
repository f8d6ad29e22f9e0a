/* Caustics (integrate/caustics) with every kind of camera, in motion, and on textures. */
#include "caustic_rooms.h"

/* ---- the size of surfaces in the image ---- */

/* The area of the image over the area of a small square on a tilted plane, by differences: their error is of
 * the second order in the side. */
static void check_view(double orthographic_height) {
    const double side = 1e-3;
    fathom_camera from;
    shade_camera camera;
    fathom_camera_look_at((double[3]){1, 2, 9}, (double[3]){0, 0.5, 0}, up, 0.7, &from);
    if (orthographic_height > 0) from.orthographic = true, from.h = orthographic_height;
    camera_prepare(&from, 300, 200, (vec3_f64){0, 0, 0}, &camera);
    const vec3_f64 u = {side, 0, 0}, v = {0, 0.6 * side, 0.8 * side}, ng = {0, -0.8, 0.6};
    const vec3_f64 way = sub_f64((vec3_f64){0.9, -0.4, 0.7}, widen(camera.eye));
    double x[3] = {0}, y[3] = {0};
    assert_true(camera_place(&camera, way, &x[0], &y[0]));
    assert_true(camera_place(&camera, add_f64(way, u), &x[1], &y[1]));
    assert_true(camera_place(&camera, add_f64(way, v), &x[2], &y[2]));
    const double area = fabs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
    assert_near(caustic_view(&camera, way, ng) / (area / (side * side)), 1, 1e-3);
}

UNIT_TEST(the_view_is_the_size_of_an_area_in_the_image) {
    check_view(0);
    check_view(4);
}

/* ---- cameras ---- */

static void set_camera(stage *s, fathom_camera *camera) {
    assert_ok(s->context, fathom_scene_set_camera(s->scene, camera));
}

/* The caustic fills much of the image. */
static fathom_camera towards_caustic(void) {
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0.5, 1.5, 6}, (double[3]){-0.2, -0.8, 0.2}, up, 0.3, &camera);
    return camera;
}

UNIT_TEST(photons_change_no_mean_of_an_orthographic_image) {
    stage s = ball_under_lamp();
    fathom_camera camera = towards_caustic();
    camera.orthographic = true, camera.h = 2;
    set_camera(&s, &camera);
    compare_all(&s, "an orthographic camera");
}

/* The caustic is far out of focus. */
UNIT_TEST(photons_change_no_mean_before_a_lens) {
    stage s = ball_under_lamp();
    fathom_camera camera = towards_caustic();
    camera.lens_radius = 0.5, camera.focus_distance = 3;
    set_camera(&s, &camera);
    compare_all(&s, "a lens");
}

/* The ball mirrors the lamp. Light that passes it takes three bounces. */
UNIT_TEST(photons_change_no_mean_with_few_bounces) {
    stage s = ball_under_lamp();
    fathom_camera camera = towards_caustic();
    s.settings.max_depth = 2;
    set_camera(&s, &camera);
    compare_all(&s, "two bounces");
}

/* The planes cut through the caustic on the floor, on both sides of the ball. A curtain before the near plane
 * hides the scene from a camera without one. */
UNIT_TEST(photons_change_no_mean_between_clip_planes) {
    for (int orthographic = 0; orthographic < 2; ++orthographic) {
        stage s = ball_under_lamp();
        fathom_camera camera = towards_caustic();
        if (orthographic) camera.orthographic = true, camera.h = 2;
        camera.near_clip = 5.7, camera.far_clip = 6.6;
        stage_quad(&s, (double[3]){0.4, 1.1, 4.5}, (double[3]){2, 0, 0}, (double[3]){0, 2, 0},
                   stage_lambert(&s, 0.4f));
        set_camera(&s, &camera);
        compare_all(&s, "clip planes");
    }
}

/* ---- motion ---- */

static const double key_times[2] = {0, 1};

UNIT_TEST(photons_change_no_mean_before_a_moving_camera) {
    stage s = ball_under_lamp();
    fathom_camera camera = towards_caustic();
    double frames[24];
    for (int k = 0; k < 24; ++k) {
        const double row[4] = {camera.x[k / 4 % 3], camera.y[k / 4 % 3], camera.z[k / 4 % 3],
                               camera.origin[k / 4 % 3] + (k % 12 == 3 ? (k < 12 ? -0.4 : 0.4) : 0)};
        frames[k] = row[k % 4];
    }
    camera.shutter[1] = 1;
    camera.key_count = 2, camera.key_times = key_times, camera.key_frames = frames;
    set_camera(&s, &camera);
    compare_all(&s, "a moving camera");
}

static void put_moving(stage *s, fathom_id group, double x, double y) {
    const double maps[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, 0.2};
    fathom_instance instance = default_instance();
    instance.group = group;
    instance.key_count = 2, instance.key_times = key_times, instance.key_transforms = maps;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

/* The mirror, the lamp, or both move while the shutter is open. */
UNIT_TEST(photons_change_no_mean_in_motion) {
    for (int what = 1; what < 4; ++what) {
        stage s = open_room(0);
        const fathom_material silver = glass_of(1);
        fathom_camera camera = towards_caustic();
        fathom_sphere ball = default_sphere();
        fathom_quad lamp;
        camera.shutter[1] = 1;
        set_camera(&s, &camera);
        const fathom_id balls = new_group(s.scene, NULL), lamps = new_group(s.scene, NULL);
        ball.radius = 0.6, ball.center[1] = -0.2, ball.material = stage_material(&s, &silver);
        assert_ok(s.context, fathom_scene_add_sphere(s.scene, balls, &ball, NULL));
        fathom_quad_from_axes((double[3]){0.4, 3, 0.3}, (double[3]){0.3, 0, 0}, (double[3]){0, 0.1, 0.3},
                              &lamp);
        lamp.material = stage_emitter(&s, 20);
        assert_ok(s.context, fathom_scene_add_quad(s.scene, lamps, &lamp, NULL));
        put_moving(&s, balls, what & 1 ? -0.8 : 0, 0);
        put_moving(&s, lamps, what & 2 ? -1.5 : 0, what & 2 ? 0.4 : 0);
        compare_all(&s, what == 1 ? "a moving mirror" : what == 2 ? "a moving lamp" : "a mirror and a lamp");
    }
}

/* ---- textures ---- */

/* Balls of glass and a mirror, one of whose parameters follows an image of 2 × 2 pixels. */
static void compare_textured(fathom_map_kind use, const char pixels[12], const char *what) {
    stage s = ball_under_lamp();
    fathom_material m = glass_of(1);
    char bytes[24] = "P6 2 2 255\n";
    const size_t header = strlen(bytes);
    memcpy(bytes + header, pixels, 12);
    fathom_texture t = default_texture();
    t.bytes = bytes, t.byte_count = header + 12, t.color_space = FATHOM_COLOR_LINEAR;
    if (use == FATHOM_MAP_ROUGHNESS) m.roughness = 0.4f;
    assert_ok(s.context, fathom_scene_add_texture(s.scene, &t, &m.maps[use].texture));
    stage_quad(&s, (double[3]){0.9, -0.2, -0.3}, (double[3]){0.6, 0, -0.2}, (double[3]){0, 0.6, 0.1},
               stage_material(&s, &m));
    compare_all(&s, what);
}

UNIT_TEST(photons_change_no_mean_by_textured_mirrors) {
    compare_textured(FATHOM_MAP_COLOR, "\xff\xff\x20\x20\x20\xff\x20\x20\x20\xff\xff\xff", "colours");
    compare_textured(FATHOM_MAP_ROUGHNESS, "\xff\xff\xff\0\0\0\0\0\0\x80\x80\x80", "roughness");
    compare_textured(FATHOM_MAP_METALLIC, "\xff\xff\xff\0\0\0\0\0\0\x80\x80\x80", "metal");
    compare_textured(FATHOM_MAP_OPACITY, "\xff\xff\xff\0\0\0\xff\xff\xff\x80\x80\x80", "opacity");
}

int main(void) { return unit_main(NULL, NULL); }
