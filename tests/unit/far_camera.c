/* Cameras far from what they show, by closed form and against the reference: the image does not depend on the
 * distance. */
#include "pairs.h"
#include "render.h"

enum { SIDE = 16 };
/* The height of the view where the camera looks, and the size of a pixel there. */
#define TALL 0.02
#define PIXEL (TALL / SIDE)

static const double distances[] = {1e3, 1e4, 1e6, 1e8};
enum { DISTANCES = sizeof distances / sizeof *distances };

typedef enum camera_kind { PINHOLE, LENS, ORTHOGRAPHIC, KINDS } camera_kind;

/* Looks at the origin along no axis. */
static fathom_camera look_from(double distance, camera_kind kind) {
    const double eye[3] = {0.48 * distance, 0.6 * distance, 0.64 * distance};
    fathom_camera camera;
    fathom_camera_look_at(eye, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 1, &camera);
    camera.orthographic = kind == ORTHOGRAPHIC;
    camera.d = kind == ORTHOGRAPHIC ? 1 : distance, camera.h = TALL;
    camera.lens_radius = kind == LENS ? distance / 8 : 0, camera.focus_distance = distance;
    return camera;
}

/* A square of the size 2 that faces the camera, in its plane of focus. */
static void add_target(stage *s, const fathom_camera *camera) {
    stage_quad(s, (double[3]){0, 0, 0}, camera->x, camera->y, stage_emitter(s, 1));
}

static stage open_view(const fathom_camera *camera, fathom_integrator integrator) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, integrator);
    s.settings.target_error = 0, s.settings.spp = 1, s.settings.pattern = FATHOM_PATTERN_GRID;
    s.settings.aovs = FATHOM_AOV_P | FATHOM_AOV_N | FATHOM_AOV_Z;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, camera));
    return s;
}

static void load_three(const fathom_film *film, const char *const names[3], int pixel, double out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = (double)fathom_film_channel(film, names[c])[pixel];
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Float rounds coordinates below 4, of the square and of the rays' starts, by 2^-23 at most, and directions
 * by 2^-25 in each axis, over a distance below 4. Double rounds the eye and the ways from it in a few steps
 * of 2^-53 of the distance. */
static double place_error(double distance) { return 8 * 0x1p-23 + 8 * 0x1p-53 * distance; }

static void assert_shows_target(stage *s, const fathom_camera *camera, double distance) {
    static const char *const p_names[] = {"P.X", "P.Y", "P.Z"}, *const n_names[] = {"N.X", "N.Y", "N.Z"};
    fathom_film *film = stage_render(s);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        double p[3], n[3];
        load_three(film, p_names, i, p), load_three(film, n_names, i, n);
        assert_near(dot(p, camera->x), (i % SIDE + 0.5 - SIDE / 2.0) * PIXEL, place_error(distance));
        assert_near(dot(p, camera->y), (SIDE / 2.0 - i / SIDE - 0.5) * PIXEL, place_error(distance));
        assert_near(dot(p, camera->z), 0, place_error(distance));
        for (int c = 0; c < 3; ++c) assert_near(n[c], camera->z[c], 0x1p-22);
        assert_near(fathom_film_channel(film, "Z")[i], distance, 2 * 0x1p-24 * distance);
    }
}

UNIT_TEST(pixels_show_the_same_points_from_any_distance) {
    static const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_CLASSIC, FATHOM_INTEGRATOR_PATH};
    for (int i = 0; i < 2 * KINDS * DISTANCES; ++i) {
        const double distance = distances[i / 2 / KINDS];
        const fathom_camera camera = look_from(distance, (camera_kind)(i / 2 % KINDS));
        stage s = open_view(&camera, integrators[i % 2]);
        add_target(&s, &camera);
        assert_shows_target(&s, &camera, distance);
    }
}

/* A pane in front of the square lies outside of the bounds of all else, as a plane does. */
UNIT_TEST(planes_on_the_way_are_not_skipped) {
    for (int i = 0; i < DISTANCES; ++i) {
        const fathom_camera camera = look_from(distances[i], PINHOLE);
        const double at = distances[i] / 2, point[3] = {at * camera.z[0], at * camera.z[1], at * camera.z[2]};
        stage s = open_view(&camera, FATHOM_INTEGRATOR_PATH);
        add_target(&s, &camera);
        stage_plane(&s, point, camera.z, stage_emitter(&s, 2));
        fathom_film *film = stage_render(&s);
        for (int k = 0; k < SIDE * SIDE; ++k) {
            assert_near(fathom_film_channel(film, "Z")[k], at, 4 * 0x1p-24 * at);
            assert_true(fathom_film_channel(film, "R")[k] == 2);
        }
    }
}

/* The camera moves by one pixel to the right. From the middle of the shutter's time to its end, what it shows
 * moves half a pixel to the left. */
UNIT_TEST(a_camera_may_move_far_away) {
    static const double times[2] = {0, 1};
    for (int i = 0; i < DISTANCES; ++i) {
        fathom_camera camera = look_from(distances[i], PINHOLE);
        double frames[24];
        for (int k = 0; k < 2; ++k)
            for (int r = 0; r < 3; ++r) {
                const double by = (k - 0.5) * PIXEL;
                const double row[4] = {camera.x[r], camera.y[r], camera.z[r],
                                       camera.origin[r] + by * camera.x[r]};
                memcpy(frames + 12 * k + 4 * r, row, sizeof row);
            }
        camera.shutter[1] = 1, camera.key_count = 2, camera.key_times = times, camera.key_frames = frames;
        stage s = open_view(&camera, FATHOM_INTEGRATOR_PATH);
        s.settings.motion_blur = false;
        s.settings.aovs |= FATHOM_AOV_MOTION;
        add_target(&s, &camera);
        assert_shows_target(&s, &camera, distances[i]);
        fathom_film *film = stage_render(&s);
        const float *u = fathom_film_channel(film, "forward.u");
        for (int k = 0; k < SIDE * SIDE; ++k) assert_near(u[k], -0.5, 2 * place_error(distances[i]) / PIXEL);
    }
}

/* A checker of 256 x 256 texels, black and white. */
static fathom_id add_checker(stage *s) {
    enum { TEXELS = 256, MOST = TEXELS * TEXELS };
    static char bytes[32 + MOST * sizeof(float)];
    const int header = snprintf(bytes, 32, "Pf\n%d %d\n-1.0\n", TEXELS, TEXELS);
    for (int i = 0; i < MOST; ++i)
        memcpy(bytes + header + (size_t)i * sizeof(float), &(float){(float)((i + i / TEXELS) % 2)},
               sizeof(float));
    fathom_texture t = default_texture();
    t.bytes = bytes, t.byte_count = (size_t)header + MOST * sizeof(float), t.name = "checker.pfm";
    t.color_space = FATHOM_COLOR_LINEAR;
    return new_texture(s->scene, &t);
}

/* A pixel covers about 16 x 16 texels, and is as grey as their mean. Levels of smaller images are grey all
 * over; one may have rounded to half floats. Without a filter a pixel is black or white. */
UNIT_TEST(textures_are_filtered_alike_from_any_distance) {
    for (int i = 0; i < KINDS * DISTANCES; ++i) {
        fathom_camera camera = look_from(distances[i / KINDS], (camera_kind)(i % KINDS));
        camera.h = 1.97; /* centres of pixels lie anywhere between texels */
        stage s = open_view(&camera, FATHOM_INTEGRATOR_PATH);
        fathom_material m = default_material();
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
        m.metallic = 1; /* the albedo is the base colour */
        m.maps[FATHOM_MAP_COLOR].texture = add_checker(&s);
        s.settings.max_depth = 0, s.settings.aovs = FATHOM_AOV_ALBEDO;
        stage_quad(&s, (double[3]){0, 0, 0}, camera.x, camera.y, stage_material(&s, &m));
        fathom_film *film = stage_render(&s);
        for (int k = 0; k < SIDE * SIDE; ++k)
            assert_near(fathom_film_channel(film, "albedo.R")[k], 0.5, 0x1p-11);
    }
}

/* A ball over a board of 8 x 8 lamps and a lens that blurs it: the means of 16 cells, by the path integrator
 * and by the reference, which is in double. One false alarm in 1e5; the allowance is that of `fathom validate
 * --light`. */
UNIT_TEST(the_reference_shows_the_same_from_any_distance) {
    const laws_pair options = pair_of(4, 1 << 17);
    for (int i = 0; i < 2 * DISTANCES; ++i) {
        const double distance = distances[i / 2];
        fathom_camera camera = look_from(distance, i % 2 ? LENS : PINHOLE);
        camera.h = 4;
        if (i % 2) camera.lens_radius = distance / 32, camera.focus_distance = distance - 1;
        stage s = open_view(&camera, FATHOM_INTEGRATOR_PATH);
        for (int k = 0; k < 64; ++k) {
            const double x = (k % 8 - 3.5) / 2, y = (k / 8 - 3.5) / 2, u = 0.25;
            double center[3], right[3], up[3];
            for (int c = 0; c < 3; ++c)
                center[c] = x * camera.x[c] + y * camera.y[c] - camera.z[c], right[c] = u * camera.x[c],
                up[c] = u * camera.y[c];
            const fathom_id material = (k + k / 8) % 2 ? stage_lambert(&s, 0.5f) : stage_emitter(&s, 1);
            stage_quad(&s, center, right, up, material);
        }
        stage_sphere(&s, 0, 0, 0, 0.7, stage_lambert(&s, 0.8f));
        stage_point_light(&s, 2, 3, 2, 5);
        assert_ok(s.context, fathom_scene_check(s.scene));
        laws_difference d;
        assert_ok(s.context, laws_pair_run(s.context, s.scene, &options, &d));
        if (d.p < 1e-5)
            fail_msg("%g, %s: p %g, path less reference %g +- %g", distance, i % 2 ? "lens" : "pinhole", d.p,
                     d.relative, d.relative_error);
    }
}

int main(void) { return unit_main(NULL, NULL); }
