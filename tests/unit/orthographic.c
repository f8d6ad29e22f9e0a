/* Parallel views, by closed form: what is seen does not depend on how far it is. */
#include "render.h"

enum { WIDTH = 40, HEIGHT = 24 };
#define TALL 3.0

/* From (1, 2, 3) along -z, TALL high. */
static void look_along(stage *s) {
    fathom_camera camera = default_camera();
    camera.orthographic = true, camera.h = TALL;
    camera.origin[0] = 1, camera.origin[1] = 2, camera.origin[2] = 3;
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
}

static stage with_sphere(fathom_integrator integrator, double distance, double radius) {
    stage s = stage_open(WIDTH, HEIGHT);
    fathom_settings_set_integrator(&s.settings, integrator);
    s.settings.spp = 4, s.settings.target_error = 0;
    stage_sphere(&s, 1.2, 1.9, 3 - distance, radius, stage_emitter(&s, 1));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){0, 0, 0}));
    look_along(&s);
    return s;
}

/* The least and the largest distance of a pixel's points from the middle of the disc. */
static void reach(uint32_t x, uint32_t y, double *low, double *high) {
    const double side = TALL / HEIGHT;
    const double cx = (x + 0.5 - WIDTH / 2.0) * side - 0.2, cy = (HEIGHT / 2.0 - y - 0.5) * side + 0.1;
    *low = hypot(fmax(fabs(cx) - side / 2, 0), fmax(fabs(cy) - side / 2, 0));
    *high = hypot(fabs(cx) + side / 2, fabs(cy) + side / 2);
}

/* Rays are off by float's rounding of places below 8 in each axis, and so is the sphere. */
UNIT_TEST(a_sphere_is_a_disc_of_its_radius_at_any_distance) {
    static const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_CLASSIC, FATHOM_INTEGRATOR_PATH,
                                                    FATHOM_INTEGRATOR_REFERENCE};
    static const double distances[] = {1.5, 4, 100}, radius = 1.1, slack = 8 * 0x1p-23;
    for (int i = 0; i < 9; ++i) {
        stage s = with_sphere(integrators[i / 3], distances[i % 3], radius);
        fathom_film *film = stage_render(&s);
        const float *red = fathom_film_channel(film, "R");
        int inside = 0, outside = 0;
        for (uint32_t k = 0; k < WIDTH * HEIGHT; ++k) {
            double low, high;
            reach(k % WIDTH, k / WIDTH, &low, &high);
            if (high < radius - slack) assert_true(red[k] == 1), ++inside;
            if (low > radius + slack) assert_true(red[k] == 0), ++outside;
        }
        assert_true(inside > 150 && outside > 500);
    }
}

/* Depths count along the view: that of a plane that faces it is the same everywhere. */
UNIT_TEST(a_facing_plane_has_one_depth) {
    stage s = stage_open(WIDTH, HEIGHT);
    stage_plane(&s, (double[]){0, 0, -4}, (double[]){0, 0, 1}, stage_emitter(&s, 1));
    look_along(&s);
    s.settings.aovs = FATHOM_AOV_Z;
    fathom_film *film = stage_render(&s);
    const float *z = fathom_film_channel(film, "Z");
    for (int k = 0; k < WIDTH * HEIGHT; ++k) assert_near(z[k], 7, 7 * 0x1p-23);
}

UNIT_TEST(a_crop_is_a_part_of_the_image) {
    static const uint32_t crop[4] = {5, 3, 31, 17};
    stage s = with_sphere(FATHOM_INTEGRATOR_PATH, 3, 1.1);
    fathom_film *whole = stage_render(&s);
    memcpy(s.settings.crop, crop, sizeof crop);
    fathom_film *part = stage_render(&s);
    const float *a = fathom_film_channel(whole, "R"), *b = fathom_film_channel(part, "R");
    for (uint32_t y = crop[1]; y < crop[3]; ++y)
        assert_memory_equal(a + y * WIDTH + crop[0], b + (size_t)(y - crop[1]) * (crop[2] - crop[0]),
                            (crop[2] - crop[0]) * sizeof *a);
}

/* The plane that rays leave cuts through a closed mesh: those that begin in it see its inside, all others its
 * outside, and none the background beyond. */
UNIT_TEST(rays_may_begin_inside_a_mesh) {
    stage s = stage_open(WIDTH, HEIGHT);
    stage_mesh_sphere(&s, FATHOM_ROOT, 24, 48, stage_emitter(&s, 1));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){0, 0, 0}));
    fathom_camera camera = default_camera();
    camera.orthographic = true, camera.h = 1.2;
    camera.origin[2] = 0.8;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    s.settings.aovs = FATHOM_AOV_Z;
    fathom_film *film = stage_render(&s);
    const float *z = fathom_film_channel(film, "Z"), *red = fathom_film_channel(film, "R");
    for (uint32_t k = 0; k < WIDTH * HEIGHT; ++k) {
        const double side = 1.2 / HEIGHT;
        const double r =
            hypot((k % WIDTH + 0.5 - WIDTH / 2.0) * side, (HEIGHT / 2.0 - k / WIDTH - 0.5) * side);
        /* The mesh lies within 1 - cos(2 pi / 48) of its sphere. */
        if (r > 0.95) continue;
        assert_true(red[k] == 1);
        if (r < 0.55) assert_true(z[k] > 1.6f);
    }
}

UNIT_TEST(lens_and_width_are_refused) {
    stage s = stage_open(8, 8);
    fathom_camera camera = default_camera();
    camera.orthographic = true, camera.w = 1;
    assert_fails(s.context, fathom_scene_set_camera(s.scene, &camera), FATHOM_BAD_INPUT,
                 "its pixels are square");
    camera.w = 0, camera.lens_radius = 0.1, camera.focus_distance = 1;
    assert_fails(s.context, fathom_scene_set_camera(s.scene, &camera), FATHOM_BAD_INPUT, "no plane of focus");
}

int main(void) { return unit_main(NULL, NULL); }
