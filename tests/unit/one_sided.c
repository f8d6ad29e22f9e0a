/* The camera looks through the backs of one-sided surfaces; to all other rays they have two sides. Every
 * value is exact: sums of few emissions that float holds. */
#include "render.h"

static const double up[3] = {0, 1, 0};
static const double right[3] = {4, 0, 0}, above[3] = {0, 4, 0}, left[3] = {-4, 0, 0};
static const fathom_integrator both[] = {FATHOM_INTEGRATOR_PATH, FATHOM_INTEGRATOR_REFERENCE};
enum { SIZE = 8, PIXELS = SIZE * SIZE };

static stage open_at(const double eye[3], const double target[3]) {
    stage s = stage_open(SIZE, SIZE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 4, s.settings.target_error = 0, s.settings.max_depth = 1;
    stage_camera(&s, eye, target, fabs(target[1] - eye[1]) > 0.9 ? (double[3]){0, 0, 1} : up, 0.3);
    return s;
}

static fathom_material plain(bool double_sided, float reflects, float emits) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.double_sided = double_sided, m.specular_factor = 0;
    for (int c = 0; c < 3; ++c) m.base_color[c] = reflects, m.emissive[c] = emits;
    return m;
}

static fathom_id emitter(stage *s, bool double_sided, float emits) {
    const fathom_material m = plain(double_sided, 0, emits);
    return stage_material(s, &m);
}

static void check_all(stage *s, const char *channel, float value) {
    fathom_film *film = stage_render(s);
    const float *found = fathom_film_channel(film, channel);
    assert_non_null(found);
    for (int i = 0; i < PIXELS; ++i) {
        if (found[i] != value)
            fail_msg("%s of pixel %d: %g, not %g", channel, i, (double)found[i], (double)value);
    }
}

static void check_both(stage *s, float value) {
    for (size_t i = 0; i < sizeof both / sizeof *both; ++i) {
        s->settings.integrator = both[i];
        check_all(s, "R", value);
    }
    s->settings.integrator = FATHOM_INTEGRATOR_PATH;
}

/* ---- what the camera sees ---- */

/* A square that faces the camera, which looks along -z, or turns its back. */
static void add_square(stage *s, double z, bool back, fathom_id material) {
    stage_quad(s, (double[3]){0, 0, z}, back ? left : right, above, material);
}

UNIT_TEST(backs_are_looked_through_and_fronts_are_seen) {
    stage s = open_at((double[3]){0, 0, 0}, (double[3]){0, 0, -1});
    add_square(&s, -1, true, emitter(&s, false, 8));
    add_square(&s, -2, true, emitter(&s, false, 16));
    add_square(&s, -3, false, emitter(&s, false, 2));
    s.settings.max_depth = 0;
    check_both(&s, 2);
    s.settings.max_depth = 1;
    check_both(&s, 2);
    add_square(&s, -1.5, true, emitter(&s, true, 4));
    check_both(&s, 4);
}

UNIT_TEST(aovs_are_of_what_is_seen) {
    stage s = open_at((double[3]){0, 0, 0}, (double[3]){0, 0, -1});
    s.settings.aovs = FATHOM_AOV_Z | FATHOM_AOV_ALPHA | FATHOM_AOV_ID;
    add_square(&s, -1, true, emitter(&s, false, 8));
    check_all(&s, "A", 0);
    check_all(&s, "Z", INFINITY);
    add_square(&s, -3, false, emitter(&s, false, 2));
    check_all(&s, "A", 1);
    check_all(&s, "Z", 3);
    fathom_film *film = stage_render(&s);
    for (int i = 0; i < PIXELS; ++i) assert_int_equal(fathom_film_channel_id(film, "id.object")[i], 1);
}

/* A map of determinant -1 turns the winding, and leaves the front where the normal is. */
UNIT_TEST(fronts_stay_in_front_in_mirror_images) {
    static const float corners[9] = {-4, -4, 0, 4, -4, 0, 0, 8, 0};
    for (int k = 0; k < 4; ++k) {
        const bool mirrored = k & 1, back = k & 2;
        stage s = open_at((double[3]){0, 0, 0}, (double[3]){0, 0, -1});
        fathom_mesh mesh = default_mesh();
        mesh.positions = corners, mesh.vertex_count = 3, mesh.triangle_count = 1;
        mesh.indices = (const uint32_t[]){0, back ? 2 : 1, back ? 1 : 2};
        mesh.material = emitter(&s, false, 2);
        const fathom_id group = new_group(s.scene, NULL);
        assert_ok(s.context, fathom_scene_add_mesh(s.scene, group, &mesh, NULL));
        fathom_instance instance = default_instance();
        instance.group = group, instance.transform[0] = mirrored ? -1 : 1, instance.transform[11] = -3;
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
        check_both(&s, back ? 0 : 2);
    }
}

/* A tilted sheet of two meshes in one place, each cut into triangles in its own way. */
static void add_sheet(stage *s, bool back, fathom_id material) {
    static const float corners[12] = {-5.1f, -4.3f, -9.7f,   4.9f,  -4.3f, -2.9f,
                                      5.3f,  4.7f,  -2.628f, -4.7f, 4.7f,  -9.428f};
    static const uint32_t front_first[6] = {0, 1, 2, 0, 2, 3}, back_first[6] = {1, 0, 3, 2, 1, 3};
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 4, mesh.triangle_count = 2;
    mesh.indices = back ? back_first : front_first;
    mesh.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

UNIT_TEST(sheets_back_to_back_show_the_side_that_faces_the_camera) {
    static const char *const tracers[] = {"embree", "embree:user", "bvh", "linear", "linear:f64"};
    for (size_t k = 0; k < 4 * (sizeof tracers / sizeof *tracers); ++k) {
        const bool back_comes_first = k & 1, from_behind = k & 2;
        stage s = open_at((double[3]){0.3, 0.2, from_behind ? -14.1 : 0},
                          (double[3]){0.1, 0, from_behind ? 0 : -14.3});
        s.settings.tracer = tracers[k / 4];
        const fathom_id seen = emitter(&s, false, 2), hidden = emitter(&s, false, 8);
        for (int i = 0; i < 2; ++i) {
            const bool back = (i == 0) == back_comes_first;
            add_sheet(&s, back, back == from_behind ? seen : hidden);
        }
        check_both(&s, 2);
    }
}

/* The sky is white, and the body black. */
UNIT_TEST(closed_meshes_are_looked_out_of) {
    for (int inside = 0; inside < 2; ++inside) {
        stage s = open_at((double[3]){0, 0, inside ? 0 : 4}, (double[3]){0, 0, -1});
        assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){1, 1, 1}));
        stage_mesh_sphere(&s, FATHOM_ROOT, 16, 32, emitter(&s, false, 0));
        check_both(&s, inside ? 1 : 0);
    }
}

/* ---- what other rays see ---- */

/* The lamp shines on the back of a ceiling, through which the camera looks at the floor in its shadow. */
UNIT_TEST(backs_cast_shadows) {
    for (int casts = 0; casts < 2; ++casts) {
        static const double east[3] = {9, 0, 0}, north[3] = {0, 0, 9};
        const fathom_material floor = plain(true, 0.5f, 0), ceiling = plain(false, 0, 0);
        stage s = open_at((double[3]){0, 4, 0}, (double[3]){0, 0, 0});
        stage_quad(&s, (double[3]){0, 0, 0}, north, east, stage_material(&s, &floor));
        if (casts) stage_quad(&s, (double[3]){0, 2, 0}, east, north, stage_material(&s, &ceiling));
        stage_point_light(&s, 0, 6, 0, 1);
        fathom_film *film = stage_render(&s);
        for (int i = 0; i < PIXELS; ++i) {
            const float red = fathom_film_channel(film, "R")[i];
            assert_true(casts ? red == 0 : red > 0.001f);
        }
        if (casts) check_both(&s, 0);
    }
}

/* A mirror shows the back of a square, here behind the camera. */
UNIT_TEST(mirrors_show_backs) {
    fathom_material mirror = plain(true, 1, 0);
    mirror.metallic = 1, mirror.roughness = 0;
    stage s = open_at((double[3]){0, 0, 0}, (double[3]){0, 0, -1});
    add_square(&s, -1, false, stage_material(&s, &mirror));
    add_square(&s, 1, false, emitter(&s, false, 2));
    check_both(&s, 2);
}

/* Glass refracts the same light, whatever its flag. */
UNIT_TEST(volumes_have_two_sides) {
    float kept[PIXELS];
    for (int sides = 1; sides <= 2; ++sides) {
        stage s = open_at((double[3]){0, 0, 4}, (double[3]){0, 0, 0});
        fathom_material glass = plain(sides == 2, 1, 0);
        glass.specular_factor = glass.transmission = glass.thickness = 1, glass.roughness = 0;
        stage_mesh_sphere(&s, FATHOM_ROOT, 16, 32, stage_material(&s, &glass));
        add_square(&s, -2, false, emitter(&s, true, 3));
        s.settings.max_depth = 8;
        fathom_film *film = stage_render(&s);
        const float *red = fathom_film_channel(film, "R");
        if (sides == 1)
            memcpy(kept, red, sizeof kept);
        else
            assert_memory_equal(kept, red, sizeof kept);
        assert_true(red[PIXELS / 2 + SIZE / 2] > 1);
    }
}

static void keep_warning(void *user, const char *message) { snprintf(user, 300, "%s", message); }

UNIT_TEST(classic_shows_backs_and_says_so) {
    char told[300] = "";
    stage s = open_at((double[3]){0, 0, 0}, (double[3]){0, 0, -1});
    fathom_context_on_warning(s.context, keep_warning, told);
    add_square(&s, -1, true, emitter(&s, false, 8));
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_CLASSIC);
    check_all(&s, "R", 8);
    assert_string_equal(
        told, "one-sided materials whose back is shown, because only path tracing looks through it: 1");
}

int main(void) { return unit_main(NULL, NULL); }
