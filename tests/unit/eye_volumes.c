/* A camera inside of volumes: what it sees is what they leave of an even background, in closed form. */
#include "render.h"

static const float red[3] = {0.2f, 0.5f, 0.9f}, green[3] = {0.7f, 1, 0.4f};

/* It bends nothing and leaves `color` of white light after a length of 2. */
static fathom_material clear_volume(const float color[3], uint32_t priority) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = m.roughness = 0, m.ior = 1, m.transmission = m.thickness = 1, m.priority = priority;
    for (int c = 0; c < 3; ++c) m.base_color[c] = 1, m.attenuation_color[c] = color[c];
    m.attenuation_distance = 2;
    return m;
}

static stage open_white(double eye_x, const double target[3]) {
    stage s = stage_open(8, 8);
    const float white[3] = {1, 1, 1};
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 1, s.settings.target_error = 0;
    assert_ok(s.context, fathom_scene_set_background(s.scene, white));
    stage_camera(&s, (double[3]){eye_x, 0, 0}, target, (double[3]){0, 1, 0}, 1e-6);
    return s;
}

/* Lengths and powers in float. */
static void expect(stage *s, double in_red, double in_green) {
    static const char *const names[] = {"R", "G", "B"};
    fathom_film *film = stage_render(s);
    for (int c = 0; c < 3; ++c) {
        const float *pixels = fathom_film_channel(film, names[c]);
        const double left = pow((double)red[c], in_red / 2) * pow((double)green[c], in_green / 2);
        for (int i = 0; i < 64; ++i) assert_near((double)pixels[i], left, 1e-5);
    }
}

UNIT_TEST(a_volume_around_the_eye_absorbs) {
    static const char *const tracers[] = {"embree", "embree:user", "bvh", "linear"};
    for (size_t i = 0; i < sizeof tracers / sizeof *tracers; ++i) {
        const fathom_material m = clear_volume(red, 0);
        stage s = open_white(0.5, (double[3]){9, 0, 0});
        s.settings.tracer = tracers[i];
        stage_sphere(&s, 0, 0, 0, 2, stage_material(&s, &m));
        /* One that the ray of the look around enters and leaves again. */
        stage_sphere(&s, 0.5 + 0.36 * 9, 0.8 * 9, 0.48 * 9, 1, 1);
        expect(&s, 1.5, 0);
    }
}

/* No light comes from infinity through water that absorbs it, but that of other colours does. */
UNIT_TEST(a_sea_without_end_passes_what_it_does_not_absorb) {
    static const float clear_red[3] = {1, 0.5f, 1};
    for (int kind = 0; kind < 2; ++kind) {
        const fathom_material m = clear_volume(clear_red, 0);
        stage s = open_white(0, (double[3]){9, 0, 0});
        fathom_settings_set_integrator(&s.settings,
                                       kind ? FATHOM_INTEGRATOR_REFERENCE : FATHOM_INTEGRATOR_PATH);
        s.settings.spp = 4, s.settings.target_error = 0;
        stage_plane(&s, (double[3]){1, 0, 0}, (double[3]){-1, 0, 0}, stage_material(&s, &m));
        fathom_film *film = stage_render(&s);
        for (int i = 0; i < 64; ++i) {
            assert_near((double)fathom_film_channel(film, "R")[i], 1, 1e-6);
            assert_true(fathom_film_channel(film, "G")[i] == 0);
            assert_near((double)fathom_film_channel(film, "B")[i], 1, 1e-6);
        }
    }
}

/* Every path arrives, with the weight that the volumes leave it. */
UNIT_TEST(roulette_ends_no_path_that_crosses_smooth_surfaces) {
    const fathom_material m = clear_volume(red, 0);
    stage s = open_white(0, (double[3]){9, 0, 0});
    const fathom_id id = stage_material(&s, &m);
    for (int k = 1; k < 5; ++k) stage_sphere(&s, 10 * k, 0, 0, 1, id);
    expect(&s, 8, 0);
}

UNIT_TEST(a_volume_beside_the_eye_does_not) {
    const fathom_material m = clear_volume(red, 0);
    stage s = open_white(0, (double[3]){9, 0, 0});
    stage_sphere(&s, 0.36 * 9, 0.8 * 9, 0.48 * 9, 2, stage_material(&s, &m));
    expect(&s, 0, 0);
}

/* The inner one fills its space alone where it has the higher priority, or where neither has any. */
UNIT_TEST(volumes_around_each_other) {
    static const uint32_t priorities[3][2] = {{0, 0}, {1, 2}, {2, 1}};
    for (int i = 0; i < 3; ++i) {
        const fathom_material outer = clear_volume(red, priorities[i][0]),
                              inner = clear_volume(green, priorities[i][1]);
        stage s = open_white(0, (double[3]){9, 0, 0});
        stage_sphere(&s, 0, 0, 0, 3, stage_material(&s, &outer));
        stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &inner));
        expect(&s, i == 2 ? 3 : 2, i == 2 ? 0 : 1);
    }
}

/* Under a plane, and in a mesh that an instance mirrors. */
UNIT_TEST(other_shapes_bound_volumes_too) {
    const fathom_material m = clear_volume(red, 0);
    stage s = open_white(0, (double[3]){9, 9, 0});
    stage_plane(&s, (double[3]){0, 2, 0}, (double[3]){0, 1, 0}, stage_material(&s, &m));
    expect(&s, 2 * sqrt(2), 0);
    s = open_white(0, (double[3]){0, -9, 0.01});
    fathom_instance instance = default_instance();
    assert_ok(s.context, fathom_scene_add_group(s.scene, NULL, &instance.group));
    stage_mesh_sphere(&s, instance.group, 64, 64, stage_material(&s, &m));
    const double map[12] = {-3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0};
    memcpy(instance.transform, map, sizeof map);
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    /* A facet is up to 1 - cos(pi / 64)^2 nearer. */
    fathom_film *film = stage_render(&s);
    assert_near((double)fathom_film_channel(film, "R")[0], pow((double)red[0], 1.5), 0.003);
}

/* Below a plane without end: light from infinitely far away does not get through a volume that absorbs. */
UNIT_TEST(a_volume_without_end_lets_no_light_in_if_it_absorbs) {
    static const float white[3] = {1, 1, 1};
    for (int i = 0; i < 4; ++i) {
        const fathom_material m = clear_volume(i % 2 ? white : red, 0);
        stage s = open_white(0, (double[3]){9, -1, 0});
        fathom_settings_set_integrator(&s.settings,
                                       i < 2 ? FATHOM_INTEGRATOR_PATH : FATHOM_INTEGRATOR_REFERENCE);
        s.settings.spp = 1, s.settings.target_error = 0;
        stage_plane(&s, (double[3]){0, 3, 0}, (double[3]){0, 1, 0}, stage_material(&s, &m));
        expect(&s, i % 2 ? 0 : (double)INFINITY, 0);
    }
}

/* ---- rays that start in different volumes ---- */

static void render_each(stage *s, void (*check)(const float *pixels)) {
    static const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_PATH, FATHOM_INTEGRATOR_REFERENCE};
    for (int k = 0; k < 2; ++k) {
        fathom_settings_set_integrator(&s->settings, integrators[k]);
        s->settings.target_error = 0;
        fathom_film *film = stage_render(s);
        check(fathom_film_channel(film, "R"));
    }
}

/* A ball of radius 2 around the origin. The camera moves along x, from -4 to 5 while the shutter is open. */
static stage open_moving(void) {
    static const double times[2] = {0, 1};
    const fathom_material m = clear_volume(red, 0);
    stage s = open_white(-4, (double[3]){9, 0, 0});
    fathom_camera camera;
    double frames[24];
    fathom_camera_look_at((double[3]){-4, 0, 0}, (double[3]){9, 0, 0}, (double[3]){0, 1, 0}, 1e-6, &camera);
    for (int i = 0; i < 24; ++i) {
        const int row = i % 12 / 4;
        const double columns[4] = {camera.x[row], camera.y[row], camera.z[row], row ? 0 : i < 12 ? -4 : 5};
        frames[i] = columns[i % 4];
    }
    camera.shutter[1] = 1;
    camera.key_count = 2, camera.key_times = times, camera.key_frames = frames;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    stage_sphere(&s, 0, 0, 0, 2, stage_material(&s, &m));
    return s;
}

/* The camera is at 0.5 in the middle of the time. */
UNIT_TEST(a_sharp_image_knows_what_is_around_the_eye_halfway) {
    stage s = open_moving();
    s.settings.motion_blur = false;
    expect(&s, 1.5, 0);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_REFERENCE);
    s.settings.spp = 4, s.settings.target_error = 0;
    expect(&s, 1.5, 0);
}

/* A number of standard deviations that 1 of 10^5 means exceeds. */
static const double errors = 4.42;

/* Light passes a length of 4 in 2/9 of the time, of 4 to 0 in 4/9, and none in the rest. No value differs
 * from the mean by more than 1. */
static void check_moving(const float *pixels) {
    const double c = (double)red[0], mean = (2 * c * c + 2 * (c * c - 1) / log(c) + 3) / 9;
    double sum = 0;
    for (int i = 0; i < 64; ++i) sum += (double)pixels[i];
    assert_near(sum / 64, mean, errors / sqrt(64 * 1024));
}

UNIT_TEST(an_eye_that_moves_into_a_volume_and_out_of_it) {
    stage s = open_moving();
    s.settings.spp = 1024;
    render_each(&s, check_moving);
}

/* A sea up to y = 0 or x = 2, and a camera at the origin. Without specularFactor 0 it would reflect at
 * grazing angles, even with an index of 1: glTF approximates Fresnel's equations by Schlick's. */
static stage open_sea(bool afloat, fathom_camera *camera) {
    fathom_material m = clear_volume(red, 0);
    m.specular_factor = 0;
    stage s = open_white(0, (double[3]){9, 0, 0});
    fathom_camera_look_at((double[3]){0, 0, 0}, (double[3]){9, 0, 0}, (double[3]){0, 1, 0}, 1e-6, camera);
    stage_plane(&s, (double[3]){afloat ? 0 : 2, 0, 0}, (double[3]){!afloat, afloat, 0},
                stage_material(&s, &m));
    return s;
}

static void check_halves(const float *pixels) {
    for (int i = 0; i < 64; ++i) assert_true(pixels[i] == (i < 32 ? 1.0f : 0.0f));
}

UNIT_TEST(half_of_an_orthographic_camera_is_in_the_sea) {
    fathom_camera camera;
    stage s = open_sea(true, &camera);
    camera.orthographic = true, camera.h = 2, camera.w = 0;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    s.settings.spp = 4;
    render_each(&s, check_halves);
}

/* Rays from the lower half of the lens pass a length of 2 to where all meet, and no water beyond; of the
 * others nothing is left. Lengths differ by less than the fraction 1e-4 of 2; no sample is above 1. */
static void check_lens(const float *pixels) {
    double sum = 0;
    for (int i = 0; i < 64; ++i) sum += (double)pixels[i];
    assert_near(sum / 64, (double)red[0] / 2, errors / sqrt(64 * 256) + 1e-4);
}

UNIT_TEST(half_of_a_lens_is_in_the_sea) {
    fathom_camera camera;
    stage s = open_sea(true, &camera);
    camera.lens_radius = 0.02, camera.focus_distance = 2;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    s.settings.spp = 256;
    render_each(&s, check_lens);
}

/* Below a plane at x = 2, where all is in focus: a ray from r off the lens's middle has the length l, with
 * l^2 = 4 + r^2, and r^2 is uniform up to 4. The mean of c^(l/2) is an integral of l e^(k l); all of its
 * values are within 0.1 of each other. */
static double part_of_mean(double l) {
    const double k = log((double)red[0]) / 2;
    return exp(k * l) * (l / k - 1 / (k * k)) / 2;
}

static void check_wide_lens(const float *pixels) {
    double sum = 0;
    for (int i = 0; i < 64; ++i) sum += (double)pixels[i];
    assert_near(sum / 64, part_of_mean(sqrt(8)) - part_of_mean(2), errors * 0.1 / sqrt(64 * 1024));
}

UNIT_TEST(a_volume_absorbs_on_the_way_from_each_point_of_a_lens) {
    fathom_camera camera;
    stage s = open_sea(false, &camera);
    camera.lens_radius = camera.focus_distance = 2;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    render_each(&s, check_wide_lens);
}

/* ---- dispersion between volumes ---- */

/* Below z = 0 is one volume, and up to z = 5 another one, which holds the camera. Light in it is reflected
 * totally by the air above. So a channel sees all of the white below, or nothing if z = 0 reflects it
 * totally, too: there sin(a) n = m for the indices n of the upper and m of the lower volume. */
static void check_channels(float upper, float upper_dispersion, float lower, float lower_dispersion,
                           double sine, const double expected[3]) {
    static const float clear[3] = {1, 1, 1};
    static const char *const names[] = {"R", "G", "B"};
    const double eye[3] = {0, 0, 1}, target[3] = {sine, 0, 1 - sqrt(1 - sine * sine)};
    stage s = stage_open(8, 8);
    fathom_material above = clear_volume(clear, 1), below = clear_volume(clear, 2);
    above.ior = upper, above.dispersion = upper_dispersion;
    below.ior = lower, below.dispersion = lower_dispersion;
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 48, s.settings.target_error = 0, s.settings.max_depth = 256; /* each channel has 16 */
    assert_ok(s.context, fathom_scene_set_background(s.scene, clear));
    stage_camera(&s, eye, target, (double[3]){0, 1, 0}, 1e-6);
    stage_plane(&s, (double[3]){0, 0, 5}, (double[3]){0, 0, 1}, stage_material(&s, &above));
    stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, stage_material(&s, &below));
    fathom_film *film = stage_render(&s);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 64; ++i)
            assert_near((double)fathom_film_channel(film, names[c])[i], expected[c], 1e-4);
    }
}

/* The index of a channel differs from that of green by 0.025 (ior - 1) dispersion. */
UNIT_TEST(volumes_disperse_inside_each_other) {
    /* n sin(a) is 1.229, 1.277, 1.325. */
    check_channels(1.6f, 4, 1.3f, 0, 0.798, (double[3]){1, 1, 0});
    /* m is 1.24, 1.3, 1.36; n sin(a) is 1.328. */
    check_channels(1.6f, 0, 1.3f, 8, 0.83, (double[3]){0, 0, 1});
    /* n sin(a) is 1.233, 1.289, 1.344, and m 1.24, 1.3, 1.36: the quotients hardly differ. */
    check_channels(1.6f, 4.6f, 1.3f, 8, 0.8055, (double[3]){1, 1, 1});
}

int main(void) { return unit_main(NULL, NULL); }
