/* Frames in which normal maps stand: each map has that of its own texture coordinates. And light that comes
 * from behind shading normals. */
#include "render.h"

enum { SIZE = 8 };

/* A square with normals that lean by this towards -x; the second uv set is the first one turned by a right
 * angle. */
static void add_square(stage *s, fathom_id material, float lean) {
    static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0},
                       uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0}, turned[8] = {1, 1, 1, 0, 0, 0, 0, 1};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const float z = sqrtf(1 - lean * lean),
                normals[12] = {-lean, 0, z, -lean, 0, z, -lean, 0, z, -lean, 0, z};
    fathom_mesh m;
    fathom_mesh_default(&m);
    m.positions = positions, m.normals = normals, m.uvs = uvs, m.uvs_1 = turned;
    m.vertex_count = m.normal_count = m.uv_count = 4;
    m.indices = indices, m.triangle_count = 2, m.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &m, NULL));
}

static void render_coat(bool base, unsigned base_set, unsigned coat_set, float green[SIZE * SIZE]) {
    static const float even[3] = {0.5f, 0.5f, 1}, tilted[3] = {0.7f, 0.45f, 0.9f};
    stage s = stage_open(SIZE, SIZE);
    fathom_material m;
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4;
    fathom_material_default(&m);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.clearcoat = 1, m.clearcoat_roughness = 0.4f;
    fathom_map *coat = &m.maps[FATHOM_MAP_CLEARCOAT_NORMAL], *below = &m.maps[FATHOM_MAP_NORMAL];
    coat->texture = stage_texel(&s, tilted), coat->uv_set = coat_set;
    if (base) below->texture = stage_texel(&s, even), below->uv_set = base_set;
    add_square(&s, stage_material(&s, &m), 0);
    stage_point_light(&s, 1, 0.5, 1, 8);
    stage_camera(&s, (double[]){0, 0, 2}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.9);
    fathom_film *film = stage_render(&s);
    memcpy(green, fathom_film_channel(film, "G"), SIZE * SIZE * sizeof *green);
    fathom_film_destroy(film);
    stage_close(&s);
}

/* The coat's image alone, and with an even one below in the other uv set. 64 roundings of numbers near 1 are
 * more than the normals and the highlight take. */
static void a_coat_keeps_its_frame_over_an_image_of_another_uv_set(void **state) {
    (void)state;
    float sets[2][SIZE * SIZE];
    for (unsigned set = 0; set < 2; ++set) {
        float with[SIZE * SIZE];
        render_coat(false, 0, set, sets[set]);
        render_coat(true, !set, set, with);
        for (size_t i = 0; i < SIZE * SIZE; ++i)
            assert_near(with[i], sets[set][i], 64 * 0x1p-24 * (double)sets[set][i]);
    }
    /* The turned image is another one: the law above does not hold of any frame. */
    double apart = 0;
    for (size_t i = 0; i < SIZE * SIZE; ++i) apart = fmax(apart, fabs((double)(sets[0][i] - sets[1][i])));
    assert_true(apart > 0.05);
}

/* ---- lamps behind shading normals ---- */

/* The middle of a square that two lamps, of which some shine, light once. It has a normal map, or normals
 * that lean away from viewer and lamps. */
static double lit_by(const fathom_material *from, bool leans, unsigned lamps) {
    static const float tilted[3] = {0.935f, 0.5f, 0.75f};
    stage s = stage_open(16, 16);
    fathom_material m = *from;
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 64, s.settings.max_depth = 1;
    if (!leans) m.maps[FATHOM_MAP_NORMAL].texture = stage_texel(&s, tilted);
    add_square(&s, stage_material(&s, &m), leans ? 0.9f : 0);
    for (unsigned k = 0; k < 2; ++k) {
        if (lamps >> k & 1) stage_point_light(&s, leans ? 3 : -3, k, 1, 10);
    }
    stage_camera(&s, (double[]){2, 0, 0.5}, (double[]){0, 0, 0}, (double[]){0, 0, 1}, 1e-3);
    fathom_film *film = stage_render(&s);
    double sum = 0;
    for (int i = 0; i < 256; ++i) sum += (double)fathom_film_channel(film, "G")[i];
    fathom_film_destroy(film);
    stage_close(&s);
    return sum / 256;
}

/* A clear coat reflects light from behind the mapped normal of the layers below it, and a facet whose shading
 * normal faces away from the viewer is lit by its geometric normal. Each of 16384 samples takes one of two
 * lamps. A lamp of light a that is taken with a probability p adds a / p; the deviation is at most a + b if
 * both p are above 0.2, as for these lamps, which are equally far up to a factor of 1.1. */
static void lamps_behind_a_shading_normal_add_up(void **state) {
    (void)state;
    fathom_material coat, lambert;
    fathom_material_default(&coat);
    fathom_material_default(&lambert);
    coat.model = FATHOM_MODEL_METALLIC_ROUGHNESS, coat.multiscatter = false;
    coat.specular_factor = coat.metallic = 0, coat.clearcoat = 1, coat.clearcoat_roughness = 0.7f;
    for (int c = 0; c < 3; ++c) coat.base_color[c] = 0;
    for (int leans = 0; leans < 2; ++leans) {
        const fathom_material *m = leans ? &lambert : &coat;
        const double a = lit_by(m, leans, 1), b = lit_by(m, leans, 2);
        assert_true(a > 0.01 && b > 0.01);
        assert_near(lit_by(m, leans, 3), a + b, 5 * (a + b) / 128);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_behind_a_shading_normal_add_up),
        cmocka_unit_test(a_coat_keeps_its_frame_over_an_image_of_another_uv_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
