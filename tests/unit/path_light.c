/* Path tracing against closed forms. The pixels of an image are independent, so their spread tells the error
 * of their mean. A test fails beyond 5 standard errors: 6e-7 by chance (normal, two-sided). */
#include "render.h"

static const double tiny = 1e-4;
static const double up[3] = {0, 1, 0};

static stage path_open(uint32_t spp, uint32_t depth) {
    stage s = stage_open(32, 32);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = spp, s.settings.target_error = 0, s.settings.max_depth = depth;
    return s;
}

static fathom_id gray(stage *s, float k_d, float k_e) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = k_d, m.k_e[c] = k_e;
    return stage_material(s, &m);
}

static void look(stage *s, const double eye[3], const double target[3]) {
    stage_camera(s, eye, target, fabs(eye[1] - target[1]) > 0.9 ? (double[3]){0, 0, 1} : up, tiny);
}

/* Renders, and holds the mean of all pixels against the value; `slack` is what the scene itself is off by. */
static void check_mean(stage *s, double value, double slack) {
    fathom_film *film = stage_render(s);
    const float *red = fathom_film_channel(film, "R");
    const int count = 32 * 32;
    double sum = 0, squares = 0;
    for (int i = 0; i < count; ++i) sum += (double)red[i];
    const double mean = sum / count;
    for (int i = 0; i < count; ++i) squares += ((double)red[i] - mean) * ((double)red[i] - mean);
    const double error = sqrt(squares / count / (count - 1));
    assert_near(mean, value, 5 * error + slack);
    /* A spread that hides everything would prove nothing. */
    assert_true(error < 0.01 * value);
}

/* ---- furnaces ---- */

/* L (1 - rho^(n+1)) / (1 - rho) after n bounces. Weights are float: 16 roundings a bounce. */
static void check_furnace(uint32_t depth) {
    const double rho = 0.7;
    stage s = path_open(16, depth);
    stage_sphere(&s, 0, 0, 0, 1, gray(&s, 0.7f, 1));
    look(&s, (double[3]){0.2, 0.1, 0}, (double[3]){0, 0, -1});
    const double value = (1 - pow(rho, depth + 1.0)) / (1 - rho);
    check_mean(&s, value, value * 16 * depth * 0x1p-24);
}

UNIT_TEST(a_closed_sphere_adds_up_its_bounces) {
    check_furnace(0);
    check_furnace(1);
    check_furnace(4);
    check_furnace(64);
}

UNIT_TEST(a_convex_white_body_is_not_seen_in_a_white_sky) {
    stage s = path_open(16, 16);
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){1, 1, 1}));
    stage_sphere(&s, 0, 0, -4, 1, gray(&s, 1, 0));
    look(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, -1});
    check_mean(&s, 1, 16 * 0x1p-24);
}

/* ---- lights ---- */

/* k_l = I / pi: what a bounce adds to the direct light is k_l rho / (1 - rho) in all, for a radius of 1. */
UNIT_TEST(light_at_the_centre_of_a_sphere_fills_it) {
    const double rho = 0.6, k_l = 2;
    stage s = path_open(16, 64);
    stage_sphere(&s, 0, 0, 0, 1, gray(&s, 0.6f, 0));
    stage_point_light(&s, 0, 0, 0, (float)k_l);
    look(&s, (double[3]){0.3, 0.2, 0.1}, (double[3]){0, 0, -1});
    check_mean(&s, k_l * rho / (1 - rho), 1e-5);
}

/* A rectangle a × b whose corner is above the point at height h. */
UNIT_TEST(floor_under_a_rectangle) {
    const double a = 1 / 1.5, b = 2 / 1.5, ra = sqrt(1 + a * a), rb = sqrt(1 + b * b);
    const double value = (a / ra * atan(b / ra) + b / rb * atan(a / rb)) / (2 * M_PI);
    stage s = path_open(16, 1);
    assert_near(value, 0.12235966, 5e-9);
    stage_plane(&s, (double[3]){0, 0, 0}, up, gray(&s, 1, 0));
    stage_quad(&s, (double[3]){0.5, 1.5, 1}, (double[3]){0.5, 0, 0}, (double[3]){0, 0, 1}, gray(&s, 0, 1));
    look(&s, (double[3]){-1, 1, -1}, (double[3]){0, 0, 0});
    check_mean(&s, value, 1e-4 * value);
}

/* (R/d)² cos θ */
UNIT_TEST(floor_under_a_sphere) {
    stage s = path_open(16, 1);
    stage_plane(&s, (double[3]){0, 0, 0}, up, gray(&s, 1, 0));
    stage_sphere(&s, 1, 2, 0, 0.5, gray(&s, 0, 3));
    look(&s, (double[3]){-1, 1, -1}, (double[3]){0, 0, 0});
    check_mean(&s, 3 * 0.25 / 5 * 2 / sqrt(5), 1e-4);
}

/* Inner sphere (r1, rho1, sends out E) in an outer one (r2, rho2). */
UNIT_TEST(two_spheres_exchange_light) {
    stage s = path_open(64, 64);
    stage_sphere(&s, 0, 0, 0, 0.5, gray(&s, 0.3f, 1));
    stage_sphere(&s, 0, 0, 0, 1, gray(&s, 0.7f, 0));
    look(&s, (double[3]){0, 0.6, 0.3}, (double[3]){0, 1, 0.35});
    check_mean(&s, 0.41420118, 1e-5);
    look(&s, (double[3]){0, 0.9, 0}, (double[3]){0, 0.5, 0});
    check_mean(&s, 1.12426036, 1e-5);
}

/* ---- the same light by any way ---- */

static fathom_film *render_room(unsigned threads, const uint32_t crop[4]) {
    stage s = path_open(4, 8);
    fathom_context_set_threads(s.context, threads);
    stage_sphere(&s, 0, 0, 0, 3, gray(&s, 0.7f, 0));
    stage_sphere(&s, 0.5, 0, -1, 0.5, gray(&s, 0.2f, 4));
    stage_point_light(&s, 0, 1, 0, 1);
    stage_camera(&s, (double[3]){0, 0, 2}, (double[3]){0, 0, -1}, up, 1);
    memcpy(s.settings.crop, crop, sizeof s.settings.crop);
    fathom_film *film = stage_render(&s);
    return film;
}

/* ---- panes ---- */

/* Seen from below: k_l / d² times 0.96, what a dielectric of index 1.5 lets in head on, and the colour. The
 * floor is the only surface that scatters. */
UNIT_TEST(a_pane_tints_the_light_that_passes) {
    for (int k = 0; k < 2; ++k) {
        stage s = path_open(4, 1);
        fathom_material pane = default_material();
        pane.model = FATHOM_MODEL_METALLIC_ROUGHNESS, pane.transmission = 1, pane.roughness = 0;
        for (int c = 0; c < 3; ++c) pane.base_color[c] = 0.5f;
        const fathom_id glass = stage_material(&s, &pane);
        stage_quad(&s, (double[3]){0, 1, 0}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1}, glass);
        if (k) stage_quad(&s, (double[3]){0, 1.5, 0}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1}, glass);
        stage_plane(&s, (double[3]){0, 0, 0}, up, stage_lambert(&s, 0.5f));
        stage_point_light(&s, 0, 2, 0, 4);
        look(&s, (double[3]){3, 0.5, 0}, (double[3]){0, 0, 0});
        const double value = 0.5 * 4 / 4 * pow(0.96 * 0.5, k + 1);
        /* The view is 1e-4 wide: cosines and distances differ by its square. */
        check_mean(&s, value, value * (32 * 0x1p-24 + 1e-7));
    }
}

/* ---- suns and lamps that have a size ---- */

static void add_light(stage *s, const fathom_light *light) {
    assert_ok(s->context, fathom_scene_add_light(s->scene, light, NULL));
}

static fathom_light light_of(fathom_light_type type) {
    fathom_light light = default_light();
    light.type = type, light.direction[0] = light.direction[1] = 0, light.direction[2] = -1;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 2;
    return light;
}

static void add_sun(stage *s, double radius) {
    fathom_light light = light_of(FATHOM_LIGHT_DIRECTIONAL);
    light.angular_radius = (float)radius;
    add_light(s, &light);
}

/* Four units away, of that angle as seen from the origin. */
static void add_lamp(stage *s, double radius) {
    fathom_light light = light_of(FATHOM_LIGHT_POINT);
    light.position[2] = 4, light.radius = (float)(4 * sin(radius));
    add_light(s, &light);
}

/* radiance: of one with that angle: pi L sin² a is the irradiance pi k_l at its distance. */
typedef struct sized_light {
    void (*add)(stage *s, double radius);
    double radiance;
} sized_light;
static const sized_light kinds[] = {{add_sun, 2}, {add_lamp, 2.0 / 16}};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* A shape far from the view that casts no shadow: light samples then count alone. */
static void add_unshadowed(stage *s) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = 100, sphere.radius = 0.1, sphere.flags = FATHOM_CASTS_NO_SHADOW;
    sphere.material = gray(s, 0.5f, 0);
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &sphere, NULL));
}

static void add_mirror(stage *s) {
    fathom_material mirror = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_d[c] = 0, mirror.k_r[c] = 1;
    stage_quad(s, (double[3]){0, 0, 0}, (double[3]){1, 0, 0}, (double[3]){0, 1, 0},
               stage_material(s, &mirror));
}

static void check_in_mirror(const sized_light *kind, bool unshadowed) {
    const double radius = 0.05, slack = 16 * 0x1p-24, value = kind->radiance / pow(sin(radius), 2);
    stage s = path_open(4, 4);
    add_mirror(&s);
    kind->add(&s, radius);
    if (unshadowed) add_unshadowed(&s);
    look(&s, (double[3]){0, 0, 3}, (double[3]){0, 0, 0});
    check_mean(&s, value, value * slack);
}

UNIT_TEST(suns_and_lamps_show_in_mirrors) {
    for (int k = 0; k < 2 * KINDS; ++k) check_in_mirror(&kinds[k / 2], k % 2);
}

static void check_black(stage *s) {
    fathom_film *film = stage_render(s);
    for (int i = 0; i < 32 * 32; ++i) assert_true(fathom_film_channel(film, "R")[i] == 0);
}

/* Nor past a surface that is not there. */
UNIT_TEST(suns_and_lamps_are_not_in_view) {
    for (int k = 0; k < KINDS; ++k) {
        stage s = path_open(4, 4);
        fathom_material hole = default_material();
        hole.model = FATHOM_MODEL_METALLIC_ROUGHNESS, hole.opacity = 0;
        stage_quad(&s, (double[3]){0, 0, 1}, (double[3]){1, 0, 0}, (double[3]){0, 1, 0},
                   stage_material(&s, &hole));
        kinds[k].add(&s, 0.05);
        look(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, 1});
        check_black(&s);
    }
}

/* Between them a black sheet, once nearer than the lamp's sphere and once in it. The lamp hides nothing that
 * lies behind. */
UNIT_TEST(mirrors_show_lamps_before_what_they_hit) {
    for (int k = 0; k < 3; ++k) {
        const double z[3] = {2, 4, 6}, radius = 0.3, lamp = 2.0 / 16 / pow(sin(radius), 2);
        const double value = k ? lamp + 0.5 : 0.5;
        stage s = path_open(4, 1);
        add_mirror(&s);
        add_lamp(&s, radius);
        stage_quad(&s, (double[3]){0, 0, z[k]}, (double[3]){1, 0, 0}, (double[3]){0, 1, 0},
                   gray(&s, 0, 0.5f));
        look(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, 0});
        check_mean(&s, value, value * 16 * 0x1p-24);
    }
}

/* A mirror in a lamp's sphere sees no sphere, and a camera in it neither. */
UNIT_TEST(lamps_are_points_from_inside) {
    stage s = path_open(4, 4);
    add_mirror(&s);
    fathom_light light = light_of(FATHOM_LIGHT_POINT);
    light.position[2] = 1, light.radius = 2;
    add_light(&s, &light);
    look(&s, (double[3]){0, 0, 0.5}, (double[3]){0, 0, 0});
    check_black(&s);
    stage_plane(&s, (double[3]){0, 0, 0.25}, (double[3]){0, 0, 1}, gray(&s, 1, 0));
    s.settings.max_depth = 1;
    const double value = 2 / (0.75 * 0.75);
    check_mean(&s, value, value * (16 * 0x1p-24 + 1e-7)); /* 1e-7: a view of 1e-4 */
}

static double mean_of_seed(stage *s, uint64_t seed) {
    s->settings.seed = seed;
    fathom_film *film = stage_render(s);
    const float *red = fathom_film_channel(film, "R");
    double sum = 0;
    for (int i = 0; i < 32 * 32; ++i) sum += (double)red[i] / (32 * 32);
    return sum;
}

/* Light samples weighed against rays that find the light, and light samples alone: Student's t with 30
 * degrees of freedom is beyond 6.2 in 8e-7 of cases. */
static void check_both_ways(const sized_light *kind) {
    enum { SEEDS = 16 };
    double mean[2] = {0}, squares[2] = {0};
    for (int k = 0; k < 2; ++k) {
        stage s = path_open(64, 4);
        fathom_material metal = default_material();
        metal.model = FATHOM_MODEL_METALLIC_ROUGHNESS, metal.metallic = 1, metal.roughness = 0.3f;
        stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &metal));
        kind->add(&s, 0.2);
        if (k) add_unshadowed(&s);
        stage_camera(&s, (double[3]){1, 1, 3}, (double[3]){0, 0, 0}, up, 0.6);
        for (uint64_t seed = 0; seed < SEEDS; ++seed) {
            const double x = mean_of_seed(&s, (uint64_t)k * SEEDS + seed);
            mean[k] += x / SEEDS, squares[k] += x * x / SEEDS;
        }
    }
    const double variance = squares[0] - mean[0] * mean[0] + squares[1] - mean[1] * mean[1];
    const double error = sqrt(variance / (SEEDS - 1));
    assert_true(error < 0.005 * mean[0]);
    assert_near(mean[0], mean[1], 6.2 * error);
}

UNIT_TEST(both_ways_to_suns_and_lamps_bring_the_same) {
    for (int k = 0; k < KINDS; ++k) check_both_ways(&kinds[k]);
}

UNIT_TEST(pixels_depend_on_no_thread_and_no_crop) {
    fathom_film *one = render_room(1, (uint32_t[4]){0}), *two = render_room(2, (uint32_t[4]){0}),
                *part = render_room(2, (uint32_t[4]){7, 3, 29, 30});
    const float *a = fathom_film_channel(one, "R"), *b = fathom_film_channel(two, "R"),
                *c = fathom_film_channel(part, "R");
    assert_memory_equal(a, b, 32 * 32 * sizeof *a);
    for (int y = 3; y < 30; ++y) assert_memory_equal(a + y * 32 + 7, c + (y - 3) * 22, 22 * sizeof *a);
}

int main(void) { return unit_main(NULL, NULL); }
