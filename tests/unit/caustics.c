/* Caustics (integrate/caustics): photons bring the light that paths alone would bring, and most of it where
 * lamps shine through glass. */
#include "caustic_rooms.h"
#include "image/image.h"
#include "scene/scene.h"
#include "unit_folder.h"

/* ---- densities ---- */

/* The ray from (x, 0, 0) along x to a light at a distance. */
static bool enters(const caustics *c, double distance, caustic_entry *out) {
    return caustic_enter(c, (vec3_f64){0, 0, 0}, (vec3_f64){1, 0, 0}, distance, out);
}

UNIT_TEST(a_ray_belongs_to_the_sphere_that_it_enters_first) {
    const caustics c = {.casters = {{{10, 0, 0}, 2, 0.25, 0}, {{4, 1, 0}, 2, 0.75, 0}}, .count = 2};
    caustic_entry at;
    assert_true(enters(&c, 20, &at));
    assert_int_equal(at.caster, 0);
    assert_true(at.p.x == 12 && at.p.y == 0 && at.n.x == 1);
    assert_near(at.density, 0.25 / (16 * M_PI), 1e-12);
    assert_false(enters(&c, 11, &at)); /* the light is inside the farther sphere */
    assert_true(enters(&c, 7, &at));   /* and here between the two */
    assert_int_equal(at.caster, 1);
    assert_near((double)at.p.x, 4 + sqrt(3), 1e-6);
    assert_near(at.density, 0.75 / (16 * M_PI * sqrt(0.75)), 1e-12);
    assert_false(enters(&c, 4, &at));
    assert_true(enters(&c, INFINITY, &at));
    assert_int_equal(at.caster, 0);
    assert_false(caustic_enter(&c, (vec3_f64){0, 4, 0}, (vec3_f64){1, 0, 0}, 20, &at)); /* past both */
}

/* ---- scenes ---- */

typedef enum lamp_kind { FACE, BALL, TWO, SUN, SKY, POINT, SPOT, LAMPS } lamp_kind;
static const char *const lamp_names[LAMPS] = {"a face", "a ball",        "two faces", "a sun",
                                              "a sky",  "a point light", "two lights"};

static void add_sun(stage *s) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_DIRECTIONAL, light.angular_radius = 0.2f;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 2, light.direction[c] = (float[3]){0.5f, -1, 0.2f}[c];
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

/* Grey, with a bright spot near the zenith. */
static void add_sky(stage *s) {
    static float texels[32 * 16][3];
    for (int i = 0; i < 32 * 16 * 3; ++i) texels[i / 3][i % 3] = i / 3 == 3 * 32 + 5 ? 100 : 0.2f;
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], 3 * sizeof(float)},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], 3 * sizeof(float)},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], 3 * sizeof(float)}};
    const image img = {32, 16, 0, 0, 32, 16, channels, 3, NULL, 0, 0};
    fathom_light light = default_light();
    assert_ok(s->context, exr_write_plain(s->context, &img, in_folder("sky.exr")));
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

static void add_light(stage *s, fathom_light_type type, double x) {
    fathom_light light = default_light();
    light.type = type, light.radius = 0.3f;
    light.position[0] = x, light.position[1] = 2.5, light.position[2] = 0.3;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 1, light.direction[c] = (float[3]){-0.2f, -1, -0.1f}[c];
    light.outer_angle = 0.6f;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

static void add_lamp(stage *s, lamp_kind kind) {
    if (kind == FACE || kind == TWO) add_face(s, 0.4, 20);
    if (kind == TWO) add_face(s, -1.2, 10);
    if (kind == BALL) stage_sphere(s, 0.4, 3, 0.3, 0.3, stage_emitter(s, 15));
    if (kind == SUN) add_sun(s);
    if (kind == SKY) add_sky(s);
    if (kind == POINT || kind == SPOT) add_light(s, FATHOM_LIGHT_POINT, -0.6);
    if (kind == SPOT) add_light(s, FATHOM_LIGHT_SPOT, 0.4);
}

UNIT_TEST(photons_change_no_mean_under_any_light) {
    for (int kind = 0; kind < LAMPS; ++kind) {
        stage s = open_room(0);
        const fathom_material glass = glass_of(0);
        add_lamp(&s, (lamp_kind)kind);
        stage_sphere(&s, -0.1, 0, 0, 0.7, stage_material(&s, &glass));
        compare_all(&s, lamp_names[kind]);
    }
}

/* A coarse mesh with smooth normals does not conserve the étendue. Two casters share a lamp. */
UNIT_TEST(photons_change_no_mean_by_any_caster) {
    stage s = open_room(0.1);
    fathom_material m = glass_of(0);
    add_lamp(&s, FACE);
    stage_mesh_sphere(&s, FATHOM_ROOT, 12, 16, stage_material(&s, &m));
    compare(&s, "a mesh of glass");
    s = open_room(0.1);
    add_lamp(&s, FACE);
    m = glass_of(1);
    stage_sphere(&s, -0.9, -0.3, 0.2, 0.6, stage_material(&s, &m));
    m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.2f, m.k_r[c] = m.k_t[c] = c ? 0.7f : 0.5f;
    m.fresnel = true;
    stage_sphere(&s, 0.9, -0.3, 0.2, 0.6, stage_material(&s, &m));
    compare(&s, "a mirror and classic glass");
}

static stage open_box(bool mirror);

/* The filter is wide, and takes light from beyond the image's edges. */
UNIT_TEST(photons_change_no_mean_with_a_filter) {
    stage s = open_box(true);
    s.settings.filter = FATHOM_FILTER_BLACKMAN_HARRIS;
    compare(&s, "a filter");
}

/* A glass in a liquid that absorbs light, behind a sheet that is there in part. */
UNIT_TEST(photons_change_no_mean_in_volumes) {
    stage s = open_room(0);
    fathom_material outer = glass_of(0), inner = glass_of(0), sheet = glass_of(0);
    outer.ior = 1.3f, outer.priority = 1, outer.attenuation_distance = 1, outer.attenuation_color[0] = 0.5f;
    inner.ior = 1.6f, inner.priority = 2;
    sheet.opacity = 0.6f, sheet.roughness = 0.8f, sheet.transmission = sheet.thickness = 0;
    add_lamp(&s, BALL);
    stage_sphere(&s, -0.1, 0, 0, 0.7, stage_material(&s, &outer));
    stage_sphere(&s, 0.2, 0.2, 0, 0.4, stage_material(&s, &inner));
    stage_quad(&s, (double[3]){0, 1.5, 0}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1},
               stage_material(&s, &sheet));
    compare(&s, "volumes");
}

/* The camera looks through the wall's back, and photons reach it through that. */
UNIT_TEST(photons_pass_the_backs_of_walls_to_the_camera) {
    stage s = open_room(0);
    fathom_material glass = glass_of(0), wall = glass_of(0);
    wall.roughness = 1, wall.transmission = wall.thickness = 0, wall.double_sided = false;
    add_lamp(&s, FACE);
    stage_sphere(&s, -0.1, 0, 0, 0.7, stage_material(&s, &glass));
    stage_quad(&s, (double[3]){0, 0, 3}, (double[3]){-2, 0, 0}, (double[3]){0, 2, 0},
               stage_material(&s, &wall));
    compare(&s, "a wall seen from behind");
}

/* ---- a mirror, and the room behind it ---- */

static void add_wall(stage *s, double x, double y, double z, double u, double v, int axis,
                     fathom_id material) {
    double across[3] = {0}, along[3] = {0};
    across[(axis + 1) % 3] = u, along[(axis + 2) % 3] = v;
    stage_quad(s, (double[3]){x, y, z}, across, along, material);
}

/* A box from -1 to 1 around (x, 0, 0), without the side at x = 1, and a lamp; side: 1, or -1 for its mirror
 * image. */
static void add_half(stage *s, double x, double side, fathom_id wall) {
    add_wall(s, x - side, 0, 0, 1, 1, 0, wall);
    for (int end = -1; end <= 1; end += 2) {
        add_wall(s, x, end, 0, 1, 1, 1, wall);
        add_wall(s, x, 0, end, 1, 1, 2, wall);
    }
    stage_sphere(s, x + 0.2 * side, 0.5, 0.3, 0.05, stage_emitter(s, 40));
}

/* The side at x = 1, around a square of 0.6 × 0.6. */
static void add_frame(stage *s, fathom_id wall) {
    for (int end = -1; end <= 1; end += 2) {
        add_wall(s, 1, 0.65 * end, 0, 0.35, 1, 0, wall);
        add_wall(s, 1, 0, 0.65 * end, 0.3, 0.35, 0, wall);
    }
}

static stage open_box(bool mirror) {
    stage s = stage_open(32, 32);
    fathom_material silver = glass_of(1);
    const fathom_id wall = stage_lambert(&s, 0.5f);
    silver.base_color[1] = 1;
    add_half(&s, 0, 1, wall);
    add_frame(&s, wall);
    if (mirror)
        add_wall(&s, 1, 0, 0, 0.3, 0.3, 0, stage_material(&s, &silver));
    else
        add_half(&s, 2, -1, wall);
    stage_camera(&s, (double[3]){0.9, 0, 0.9}, (double[3]){-1, -0.4, -0.6}, up, 1.2);
    return s;
}

/* Photons bring all light of the lamp by the mirror, also after further bounces; light samples bring that of
 * the lamp behind a hole. */
UNIT_TEST(a_mirror_is_a_hole_to_a_second_room) {
    stage mirror = open_box(true), hole = open_box(false);
    expect_same(&mirror, &hole, "a mirror");
}

/* ---- the map ---- */

static double light_of(const caustics *c, uint32_t group) {
    double sum = 0;
    const size_t count = (size_t)c->width * c->height * 3;
    for (size_t k = 0; k < count; ++k) sum += (double)c->map[group * c->layers * count + k];
    return sum;
}

/* The image's light in the sum of its channels, without photons, would be less by what they bring. */
static void expect_map(const render_plan *plan, double least) {
    assert_non_null(plan->caustics);
    assert_int_equal(plan->caustics->groups, 1);
    assert_true(light_of(plan->caustics, 0) > least * 256 * 256);
}

static void expect_none(const render_plan *plan, double unused) {
    (void)unused;
    assert_null(plan->caustics);
    assert_int_equal(caustics_bytes(plan->caustics), 0);
}

/* The lamp of radiance 20 covers 0.38, the ball a disc of 1.5 at a distance of 3: about 1 in 20 of the image
 * gets a light near 1. */
UNIT_TEST(a_lamp_through_glass_makes_a_map) { look_at_plan(ball_under_lamp(), 0.005, expect_map); }

UNIT_TEST(without_glass_or_lamp_or_photons_there_is_no_map) {
    stage s = open_room(0);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    add_lamp(&s, FACE);
    look_at_plan(s, 0, expect_none);
    s = open_room(0);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    const fathom_material glass = glass_of(0);
    stage_sphere(&s, -0.1, 0, 0, 0.7, stage_material(&s, &glass));
    stage_point_light(&s, 0.4, 3, 0.3, 5);
    look_at_plan(s, 0, expect_none);
    s = ball_under_lamp();
    s.settings.photons = false;
    look_at_plan(s, 0, expect_none);
}

static void expect_four(const render_plan *plan, double unused) {
    (void)unused;
    const caustics *c = plan->caustics;
    double least = INFINITY, most = 0;
    assert_int_equal(c->groups, 4);
    assert_int_equal(caustics_bytes(c), 4ull * 256 * 256 * 3 * sizeof(float));
    assert_int_equal(caustics_bytes(c), caustics_bytes_expected(plan->scene, &plan->settings));
    for (uint32_t g = 0; g < 4; ++g) least = fmin(least, light_of(c, g)), most = fmax(most, light_of(c, g));
    assert_true(least > 0 && least < most && most < 1.5 * least); /* each is the whole, and they differ */
}

UNIT_TEST(groups_of_samples_have_maps_of_their_own) {
    stage s = ball_under_lamp();
    s.settings.aovs = FATHOM_AOV_ERROR;
    look_at_plan(s, 0, expect_four);
}

/* A crop, and any number of threads, change no pixel. Light of the mirror falls outside the crop. */
UNIT_TEST(maps_do_not_depend_on_crops_or_threads) {
    stage s = ball_under_lamp();
    const fathom_material silver = glass_of(1);
    stage_sphere(&s, -1.6, -0.6, 0, 0.4, stage_material(&s, &silver));
    s.settings.width = s.settings.height = 96, s.settings.spp = 4;
    const fathom_film *whole = stage_render(&s);
    const uint32_t crop[4] = {37, 41, 90, 77};
    memcpy(s.settings.crop, crop, sizeof crop);
    fathom_context_set_threads(s.context, 1);
    const fathom_film *part = stage_render(&s);
    const float *a = fathom_film_channel(whole, "R"), *b = fathom_film_channel(part, "R");
    for (uint32_t y = crop[1]; y < crop[3]; ++y)
        assert_memory_equal(a + y * 96 + crop[0], b + (y - crop[1]) * (crop[2] - crop[0]),
                            (crop[2] - crop[0]) * sizeof *a);
}

static bool not_photons(void *seen, const fathom_progress *now) {
    if (now->phase != FATHOM_PHASE_PHOTONS) return true;
    *(double *)seen = now->fraction;
    return false;
}

/* Enough photons for the first call of progress to come between them. */
UNIT_TEST(photons_tell_their_progress_and_stop) {
    stage s = ball_under_lamp();
    fathom_film *film;
    double seen = 0;
    s.settings.width = s.settings.height = 512, s.settings.spp = 1 << 14;
    assert_int_equal(fathom_render(s.context, s.scene, &s.settings, not_photons, &seen, NULL, &film),
                     FATHOM_INTERRUPTED);
    assert_true(seen > 0 && seen < 1);
    fathom_film_destroy(film); /* without pixels */
}

int main(void) { return unit_main(open_folder, remove_folder); }
