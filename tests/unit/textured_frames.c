/* Frames in which normal maps stand: each map has that of its own texture coordinates, and moves with its
 * mesh. And light that comes from behind shading normals. */
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
    fathom_mesh m = default_mesh();
    m.positions = positions, m.normals = normals, m.uvs = uvs, m.uvs_1 = turned;
    m.vertex_count = m.normal_count = m.uv_count = 4;
    m.indices = indices, m.triangle_count = 2, m.material = material;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &m, NULL));
}

/* grooves: of a metal below an even coat. */
static void render_coat(bool base, unsigned base_set, unsigned coat_set, bool grooves,
                        float green[SIZE * SIZE]) {
    static const float even[3] = {0.5f, 0.5f, 1}, tilted[3] = {0.7f, 0.45f, 0.9f};
    stage s = stage_open(SIZE, SIZE);
    fathom_material m = default_material();
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.clearcoat = 1, m.clearcoat_roughness = 0.4f;
    fathom_map *coat = &m.maps[FATHOM_MAP_CLEARCOAT_NORMAL], *below = &m.maps[FATHOM_MAP_NORMAL];
    coat->texture = stage_texel(&s, grooves ? even : tilted), coat->uv_set = coat_set;
    if (grooves) m.metallic = 1, m.anisotropy = 0.9f;
    if (base) below->texture = stage_texel(&s, even), below->uv_set = base_set;
    add_square(&s, stage_material(&s, &m), 0);
    stage_point_light(&s, 1, 0.5, 1, 8);
    stage_camera(&s, (double[]){0, 0, 2}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.9);
    fathom_film *film = stage_render(&s);
    memcpy(green, fathom_film_channel(film, "G"), SIZE * SIZE * sizeof *green);
}

/* The coat's image alone, and with an even one below in the other uv set. 64 roundings of numbers near 1 are
 * more than the normals and the highlight take. */
UNIT_TEST(a_coat_keeps_its_frame_over_an_image_of_another_uv_set) {
    float sets[2][SIZE * SIZE];
    for (unsigned set = 0; set < 2; ++set) {
        float with[SIZE * SIZE];
        render_coat(false, 0, set, false, sets[set]);
        render_coat(true, !set, set, false, with);
        for (size_t i = 0; i < SIZE * SIZE; ++i)
            assert_near(with[i], sets[set][i], 64 * 0x1p-24 * (double)sets[set][i]);
    }
    /* The turned image is another one: the law above does not hold of any frame. */
    double apart = 0;
    for (size_t i = 0; i < SIZE * SIZE; ++i) apart = fmax(apart, fabs((double)(sets[0][i] - sets[1][i])));
    assert_true(apart > 0.05);
}

/* The second uv set is turned by a right angle, and the normals of the metal itself do turn the grooves. */
UNIT_TEST(a_coat_does_not_turn_the_grooves_below) {
    float sets[2][SIZE * SIZE];
    double apart = 0;
    for (unsigned set = 0; set < 2; ++set) render_coat(false, 0, set, true, sets[set]);
    for (size_t i = 0; i < SIZE * SIZE; ++i) assert_true(sets[0][i] == sets[1][i]);
    render_coat(true, 1, 0, true, sets[1]);
    for (size_t i = 0; i < SIZE * SIZE; ++i) apart = fmax(apart, fabs((double)(sets[0][i] - sets[1][i])));
    assert_true(apart > 0.05);
}

/* ---- lamps behind shading normals ---- */

/* The mean of an image of the origin, seen from 2 aside and 0.5 above, lit once. Closes the stage. */
static double mean_from_aside(stage *s) {
    double sum = 0;
    fathom_settings_set_integrator(&s->settings, FATHOM_INTEGRATOR_PATH);
    s->settings.target_error = 0, s->settings.spp = 64, s->settings.max_depth = 1;
    stage_camera(s, (double[]){2, 0, 0.5}, (double[]){0, 0, 0}, (double[]){0, 0, 1}, 1e-3);
    fathom_film *film = stage_render(s);
    for (int i = 0; i < 256; ++i) sum += (double)fathom_film_channel(film, "G")[i];
    return sum / 256;
}

/* The middle of a square that two lamps, of which some shine, light once. It has a normal map, or normals
 * that lean away from viewer and lamps. */
static double lit_by(const fathom_material *from, bool leans, unsigned lamps) {
    static const float tilted[3] = {0.935f, 0.5f, 0.75f};
    stage s = stage_open(16, 16);
    fathom_material m = *from;
    if (!leans) m.maps[FATHOM_MAP_NORMAL].texture = stage_texel(&s, tilted);
    add_square(&s, stage_material(&s, &m), leans ? 0.9f : 0);
    for (unsigned k = 0; k < 2; ++k) {
        if (lamps >> k & 1) stage_point_light(&s, leans ? 3 : -3, k, 1, 10);
    }
    return mean_from_aside(&s);
}

/* A clear coat reflects light from behind the mapped normal of the layers below it, and a facet whose shading
 * normal faces away from the viewer is lit by its geometric normal. Each of 16384 samples takes one of two
 * lamps. A lamp of light a that is taken with a probability p adds a / p; the deviation is at most a + b if
 * both p are above 0.2, as for these lamps, which are equally far up to a factor of 1.1. */
UNIT_TEST(lamps_behind_a_shading_normal_add_up) {
    fathom_material coat = default_material(), lambert = default_material();
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

/* ---- normals that mirror the viewer behind the surface ---- */

/* The middle of a square that is viewed along it, with a normal map that leans away: its mirrored viewer is
 * behind the square. Lit once, by a lamp or by a white room. */
static double lit_along(const fathom_material *from, bool room) {
    static const float leaning[3] = {0.4f, 0.5f, 1};
    stage s = stage_open(16, 16);
    fathom_material m = *from;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.maps[FATHOM_MAP_NORMAL].texture = stage_texel(&s, leaning);
    add_square(&s, stage_material(&s, &m), 0);
    if (room)
        assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){1, 1, 1}));
    else
        stage_point_light(&s, -1, 0.5, 1, 10);
    return mean_from_aside(&s);
}

/* White metal reflects all light of a white room but what its facets reflect downwards. The mirrored viewer
 * is raised by a cosine of h = 1/64, so these are facets with slopes of more than h/2 in one direction: for
 * GGX a part of 1/2 (1 - s / sqrt(s^2 + alpha^2)) = 0.024 at alpha = 1/400. */
UNIT_TEST(no_normal_map_makes_metal_black) {
    fathom_material metal = default_material();
    metal.metallic = 1, metal.roughness = 0.05f;
    assert_near(lit_along(&metal, true), 1, 0.04);
}

/* Reflecting facets of a reflectance of 1e-6 do not change what the map's normal does to Lambert's lobe. In
 * the white room 16384 samples deviate by less than 0.4 each: 0.02 is six standard errors. */
UNIT_TEST(lamberts_lobe_takes_the_normal_of_the_map) {
    fathom_material plain = default_material(), facets;
    plain.metallic = plain.specular_factor = 0;
    facets = plain, facets.specular_factor = 1e-6f;
    const double expected = lit_along(&plain, false);
    assert_true(expected > 0.1);
    assert_near(lit_along(&facets, false), expected, 1e-4 * expected);
    assert_near(lit_along(&facets, true), lit_along(&plain, true), 0.02);
}

/* ---- vertices that move ---- */

enum { STILL, TURNED_STILL, TURNED_OPEN, TANGENTS = 4, MIRRORED = 8 };

/* A bent sheet of two triangles; half of it is turned by a right angle around y, which its keys reach at time
 * 1 of 0 to 2: to there they move on straight lines. */
static void add_sheet(stage *s, fathom_id material, int how) {
    static const float tangents[16] = {1, 0, 0.2f, 1, 1, 0.3f, 0, 1, 1, 0, 0, 1, 1, 0, -0.1f, 1},
                       uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const float points[2][12] = {{-1, -1, 0.2f, 1, -1, 0, 1, 1, -0.2f, -1, 1, 0.1f},
                                        {0, 0.2f, 1, 0.2f, 0, 1, -0.1f, 0, 1, 0, -0.3f, 1}};
    static const double times[2] = {0, 2};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    float turned[3][12], turned_tangents[16], keys[2][2][12];
    for (int k = 0; k < 4; ++k) {
        const float *v[3] = {points[0] + 3 * k, points[1] + 3 * k, tangents + 4 * k};
        for (int j = 0; j < 3; ++j)
            memcpy(turned[j] + 3 * k, ((const float[]){v[j][2], v[j][1], -v[j][0]}), 3 * sizeof(float));
        memcpy(turned_tangents + 4 * k, turned[2] + 3 * k, 3 * sizeof(float));
        turned_tangents[4 * k + 3] = 1;
    }
    for (int j = 0; j < 2; ++j)
        for (int c = 0; c < 12; ++c)
            keys[j][0][c] = points[j][c], keys[j][1][c] = 2 * turned[j][c] - points[j][c];
    const bool moves = (how & ~TANGENTS) != STILL;
    fathom_mesh m = default_mesh();
    m.positions = moves ? points[0] : turned[0], m.normals = moves ? points[1] : turned[1], m.uvs = uvs;
    if (how & TANGENTS) m.tangents = moves ? tangents : turned_tangents;
    m.vertex_count = m.normal_count = m.uv_count = 4;
    m.indices = indices, m.triangle_count = 2, m.material = material;
    if (moves) m.key_count = 2, m.key_times = times, m.key_positions = keys[0][0], m.key_normals = keys[1][0];
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &m, NULL));
}

static void render_sheet(int how, float normal[3][SIZE * SIZE]) {
    const float tilted[3] = {how & MIRRORED ? 0.3f : 0.7f, 0.45f, 0.9f};
    static const char *const channels[] = {"N.X", "N.Y", "N.Z"};
    const bool open = (how & ~(TANGENTS | MIRRORED)) == TURNED_OPEN;
    stage s = stage_open(SIZE, SIZE);
    fathom_material m = default_material();
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4, s.settings.motion_blur = false;
    s.settings.aovs = FATHOM_AOV_N;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.maps[FATHOM_MAP_NORMAL].texture = stage_texel(&s, tilted);
    if (how & MIRRORED) m.maps[FATHOM_MAP_NORMAL].transform[0] = -1;
    add_sheet(&s, stage_material(&s, &m), how & ~MIRRORED);
    stage_point_light(&s, 3, 0.5, 1, 8);
    fathom_camera camera;
    fathom_camera_look_at((double[]){4, 0.5, 0.5}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.6, &camera);
    camera.shutter[0] = open ? 0 : 1, camera.shutter[1] = open ? 2 : 1;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    fathom_film *film = stage_render(&s);
    for (int c = 0; c < 3; ++c)
        memcpy(normal[c], fathom_film_channel(film, channels[c]), SIZE * SIZE * sizeof(float));
}

/* Tangents that are given, and those that are made of texture coordinates, on a sheet that its keys turn and
 * on one that was built turned. Both know the corners to a few roundings of numbers up to 4; 64 of them are
 * more than the normals take. */
UNIT_TEST(normal_maps_turn_with_the_vertices) {
    for (int tangents = 0; tangents <= TANGENTS; tangents += TANGENTS) {
        float built[3][SIZE * SIZE];
        render_sheet(STILL | tangents, built);
        for (int how = TURNED_STILL; how <= TURNED_OPEN; ++how) {
            float found[3][SIZE * SIZE];
            render_sheet(how | tangents, found);
            for (int c = 0; c < 3; ++c)
                for (size_t i = 0; i < SIZE * SIZE; ++i)
                    assert_near(found[c][i], built[c][i], 64 * 4 * 0x1p-24);
        }
    }
}

/* The image is turned left to right by its texel and by its transform: by both, nothing changes, smooth as
 * the tangents are. */
UNIT_TEST(mirrored_images_keep_smooth_tangents) {
    float plain[3][SIZE * SIZE], mirrored[3][SIZE * SIZE];
    render_sheet(STILL, plain);
    render_sheet(STILL | MIRRORED, mirrored);
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < SIZE * SIZE; ++i) assert_near(mirrored[c][i], plain[c][i], 64 * 4 * 0x1p-24);
}

int main(void) { return unit_main(NULL, NULL); }
