/* Surfaces that are not there: rays pass them without a bounce, and nothing in an image tells of them. */
#include "render.h"

static const char *const channels[] = {"R",   "G",   "B",   "A",   "Z",        "N.X",      "N.Y",
                                       "N.Z", "P.X", "P.Y", "P.Z", "albedo.R", "albedo.G", "albedo.B"};
static const char *const ids[] = {"id.object", "id.primitive", "id.instance"};

static void assert_same_films(const fathom_film *a, const fathom_film *b) {
    uint32_t width, height;
    fathom_film_size(a, &width, &height);
    const size_t pixels = (size_t)width * height;
    for (size_t k = 0; k < sizeof channels / sizeof *channels; ++k) {
        const float *x = fathom_film_channel(a, channels[k]), *y = fathom_film_channel(b, channels[k]);
        if (memcmp(x, y, pixels * sizeof *x) != 0) fail_msg("channel %s differs", channels[k]);
    }
    for (size_t k = 0; k < sizeof ids / sizeof *ids; ++k) {
        const uint32_t *x = fathom_film_channel_id(a, ids[k]), *y = fathom_film_channel_id(b, ids[k]);
        if (memcmp(x, y, pixels * sizeof *x) != 0) fail_msg("channel %s differs", ids[k]);
    }
}

static fathom_material clear_material(void) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_t[c] = 1;
    m.ior = 1;
    return m;
}

/* A ball and a mirror on a floor, with all AOVs and a single bounce. */
static stage open_view(void) {
    stage s = stage_open(64, 48);
    const fathom_id matte = stage_lambert(&s, 0.8f);
    fathom_material mirror = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_r[c] = 0.5f;
    stage_sphere(&s, 0, 0.6, 0, 0.6, matte);
    stage_quad(&s, (double[3]){0, 0, 0}, (double[3]){3, 0, 0}, (double[3]){0, 0, -3}, matte);
    stage_quad(&s, (double[3]){0, 1, -2}, (double[3]){2, 0, 0}, (double[3]){0, 1, 0},
               stage_material(&s, &mirror));
    stage_point_light(&s, 2, 3, 2, 10);
    stage_camera(&s, (double[3]){0.5, 1.5, 5}, (double[3]){0, 0.6, 0}, (double[3]){0, 1, 0}, 0.7);
    s.settings.max_depth = 1;
    s.settings.aovs =
        FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_N | FATHOM_AOV_P | FATHOM_AOV_ALBEDO | FATHOM_AOV_ID;
    return s;
}

static fathom_id add_group(stage *s, fathom_id material) {
    fathom_instance instance = default_instance();
    assert_ok(s->context, fathom_scene_add_group(s->scene, NULL, &instance.group));
    instance.transform[7] = 0.25, instance.material = material;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
    return instance.group;
}

/* Twelve sheets in front of it, a ball around everything, a mesh and a plane. */
static void add_clear_shapes(stage *s, fathom_id group, fathom_id clear, unsigned flags) {
    fathom_quad quad;
    fathom_sphere ball = default_sphere();
    fathom_plane plane = default_plane();
    for (int k = 0; k < 12; ++k) {
        fathom_quad_from_axes((double[3]){0, 1, 2 + 0.1 * k}, (double[3]){3, 0, 0}, (double[3]){0, 3, 0},
                              &quad);
        quad.material = clear, quad.flags = flags;
        assert_ok(s->context, fathom_scene_add_quad(s->scene, group, &quad, NULL));
    }
    ball.radius = 20, ball.material = clear, ball.flags = flags;
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, group, &ball, NULL));
    plane.point[2] = 1.5, plane.material = clear, plane.flags = flags;
    assert_ok(s->context, fathom_scene_add_plane(s->scene, group, &plane, NULL));
    const float p[9] = {-3, -3, 1.75f, 3, -3, 1.75f, 0, 6, 1.75f};
    const uint32_t index[3] = {0, 1, 2};
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 3, mesh.indices = index, mesh.triangle_count = 1;
    mesh.material = clear, mesh.flags = flags;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

UNIT_TEST(shapes_that_are_not_there_change_nothing) {
    for (int k = 0; k < 4; ++k) {
        stage plain = open_view(), with = open_view();
        const fathom_material clear = clear_material();
        const fathom_id id = stage_material(&with, &clear);
        add_clear_shapes(&with, k & 1 ? add_group(&with, FATHOM_NONE) : FATHOM_ROOT, id,
                         FATHOM_CASTS_NO_SHADOW);
        plain.settings.tracer = with.settings.tracer = k & 2 ? "reference" : "embree";
        fathom_film *a = stage_render(&plain), *b = stage_render(&with);
        assert_same_films(a, b);
    }
}

static bool sees_object(stage *s, uint32_t from) {
    fathom_film *film = stage_render(s);
    bool seen = false;
    for (size_t i = 0; i < 64 * 48; ++i) {
        uint32_t id = fathom_film_channel_id(film, "id.object")[i];
        seen |= id >= from && id != FATHOM_NONE;
    }
    return seen;
}

/* One that casts a shadow is there, and so is one whose material an instance replaces. */
UNIT_TEST(what_can_be_told_is_there) {
    for (int k = 0; k < 2; ++k) {
        stage s = open_view();
        const fathom_material clear = clear_material();
        const fathom_id id = stage_material(&s, &clear);
        const fathom_id group = k ? add_group(&s, stage_lambert(&s, 0.3f)) : FATHOM_ROOT;
        add_clear_shapes(&s, group, id, k ? FATHOM_CASTS_NO_SHADOW : 0);
        assert_true(sees_object(&s, 3));
    }
}

int main(void) { return unit_main(NULL, NULL); }
