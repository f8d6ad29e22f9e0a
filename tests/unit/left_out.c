/* A render says what it does without, and no pixel shows that it was left out. */
#include "image/pack.h"
#include "scene/scene.h"

#include "random.h"
#include "render.h"

/* ---- films ---- */

static const char *const names[] = {"R",   "G",   "B",   "A",   "Z",        "N.X",      "N.Y",
                                    "N.Z", "P.X", "P.Y", "P.Z", "albedo.R", "albedo.G", "albedo.B"};

static void assert_same_channel(const fathom_film *a, const fathom_film *b, const char *name) {
    uint32_t width, height;
    fathom_film_size(a, &width, &height);
    const float *x = fathom_film_channel(a, name), *y = fathom_film_channel(b, name);
    assert_int_equal(x == NULL, y == NULL);
    if (x && memcmp(x, y, (size_t)width * height * sizeof *x) != 0) fail_msg("channel %s differs", name);
}

static void assert_same(const fathom_film *a, const fathom_film *b) {
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) assert_same_channel(a, b, names[i]);
}

static fathom_film *render(stage *s, fathom_stats *stats) {
    fathom_film *film;
    assert_ok(s->context, fathom_render(s->context, s->scene, &s->settings, NULL, NULL, stats, &film));
    return own_film(film);
}

static bool says(const fathom_film *film, const char *what) {
    const fathom_left_out *items;
    uint32_t count = fathom_film_left_out(film, &items);
    for (uint32_t i = 0; i < count; ++i) {
        if (strcmp(items[i].what, what) == 0) return true;
    }
    return false;
}

/* ---- the list ---- */

static void look_at_origin(stage *s) {
    stage_camera(s, (double[3]){0.4, 0.6, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7);
}

/* Faceted and open, lit from one side: needs nothing but a light. */
static stage open_plain(void) {
    stage s = stage_open(48, 40);
    static const float corners[] = {-1, -1, 0, 1, -1, 0.3f, 1, 1, 0, -1, 1, 0.4f};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 4, mesh.indices = indices, mesh.triangle_count = 2;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    stage_point_light(&s, 2, 3, 2, 20);
    look_at_origin(&s);
    return s;
}

static const char *const stages[] = {"background", "mirrored and refracted rays", "buffers of AOVs",
                                     "watertight repair", "shading normals"};

UNIT_TEST(a_plain_scene_does_without_all) {
    stage s = open_plain();
    fathom_film *film = render(&s, NULL);
    for (size_t i = 0; i < sizeof stages / sizeof *stages; ++i) assert_true(says(film, stages[i]));
    assert_true(says(film, "sphere geometry") && says(film, "quad geometry") && says(film, "planes"));
    assert_true(says(film, "instances") && says(film, "error estimates"));
    assert_true(says(film, "unlit shadow rays"));
    assert_false(says(film, "triangle geometry") || says(film, "lights[0]"));
}

UNIT_TEST(a_scene_that_needs_all_stages_does_without_none) {
    stage s = stage_open(48, 40);
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_s[c] = 0.5f, m.k_r[c] = m.k_t[c] = 0.3f, m.k_e[c] = 0.1f;
    m.specular = FATHOM_SPECULAR_BLINN;
    fathom_generate_options ball; /* closed */
    fathom_generate_options_default(&ball);
    ball.kind = FATHOM_GENERATE_SPHERE, ball.triangles = 500, ball.material = stage_material(&s, &m);
    assert_ok(s.context, fathom_scene_generate(s.scene, FATHOM_ROOT, &ball));
    stage_point_light(&s, 2, 3, 2, 20);
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.1f, 0.2f, 0.3f}));
    s.settings.aovs = FATHOM_AOV_Z;
    look_at_origin(&s);
    fathom_film *film = render(&s, NULL);
    for (size_t i = 0; i < sizeof stages / sizeof *stages; ++i) assert_false(says(film, stages[i]));
    assert_ok(s.context, fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH));
    s.settings.spp = 4, s.settings.target_error = 0, s.settings.aovs = FATHOM_AOV_ERROR;
    film = render(&s, NULL);
    assert_false(says(film, "error estimates"));
}

UNIT_TEST(surfaces_that_only_emit_cast_no_shadow_rays) {
    stage s = stage_open(48, 40);
    stage_mesh_sphere(&s, FATHOM_ROOT, 8, 16, stage_emitter(&s, 1));
    stage_point_light(&s, 2, 3, 2, 20);
    look_at_origin(&s);
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film = render(&s, &stats);
    assert_true(says(film, "lights and their shadow rays"));
    assert_int_equal(stats.shadow_rays + stats.unlit_shadow_rays, 0);
}

/* ---- texture coordinates ---- */

static void write_text(const char *path, const char *text) { unit_write_file(path, text, strlen(text)); }

/* Reads the file either way: the same image, and texture coordinates in the second only if they are used. */
static void assert_read_without(const char *path, bool used) {
    stage with = {.context = new_context()}, without = {.context = new_context()};
    with.scene = scene_of_file(with.context, path);
    assert_ok(without.context, fathom_scene_read_to_render(without.context, path, &without.scene));
    own_scene(without.scene);
    assert_int_equal(with.scene->meshes.count, without.scene->meshes.count);
    for (size_t i = 0; i < with.scene->meshes.count; ++i) {
        const fathom_mesh *a = &with.scene->meshes.items[i], *b = &without.scene->meshes.items[i];
        assert_true(a->uvs && a->uv_count);
        if (!used) assert_true(!b->uvs && !b->uv_indices && !b->uv_count);
        assert_int_equal(a->triangle_count, b->triangle_count);
    }
    fathom_scene_settings(with.scene, &with.settings);
    with.settings.width = 48, with.settings.height = 36;
    with.settings.spp = 4;
    without.settings = with.settings;
    fathom_film *x = render(&with, NULL), *y = render(&without, NULL);
    assert_same(x, y);
    assert_true(says(y, "textures"));
}

/* Normals have indices of their own, and one face counts back, over uvs too. */
static const char obj_text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nvn 0 0 1\nvn 0.1 0 1\n"
                               "vt 0 0\nvt 1 0\nvt 0 1\nf 1/1/1 2/2/1 3/3/2\nf -3/-1/-1 -1/-2/-2 -2/-3/-1\n";
static const char json_text[] =
    "{ \"lights\": [ { \"type\": \"directional\", \"direction\": [0, -1, -1] } ], \"objects\": [\n"
    "{ \"type\": \"mesh\", \"positions\": [[0,0,0], [1,0,0], [0,1,0]], \"indices\": [[0,1,2]],"
    " \"uvs\": [[0,0], [1,0], [0,1]] },\n"
    "{ \"type\": \"mesh\", \"file\": \"left_out.obj\" } ] }\n";

UNIT_TEST(images_do_not_depend_on_reading_texture_coordinates) {
    stage s = open_plain();
    write_text("left_out.obj", obj_text);
    write_text("left_out.json", json_text);
    fathom_scene *scene = scene_of_file(s.context, "left_out.obj");
    assert_ok(s.context, fathom_scene_write(scene, "left_out.ply"));
    assert_ok(s.context, fathom_scene_write(scene, "left_out.glb"));
    const char *const paths[] = {"left_out.obj", "left_out.ply", "left_out.glb", "left_out.json"};
    for (int i = 0; i < 4; ++i) assert_read_without(paths[i], false);
    for (int i = 0; i < 4; ++i) remove(paths[i]);
}

/* Its grooves run across u, whether or not anything has an image. */
UNIT_TEST(brushed_metal_uses_texture_coordinates) {
    write_text(
        "brushed.json",
        "{ \"background\": [0.2, 0.5, 1], \"lights\": [ { \"type\": \"sun\", \"direction\": [1, -1, -1],"
        " \"angularDiameter\": 20 } ],\n"
        "\"materials\": { \"it\": { \"model\": \"metallicRoughness\", \"metallic\": 1, \"roughness\": 0.4,"
        " \"anisotropy\": 0.9 } },\n"
        "\"objects\": [ { \"type\": \"mesh\", \"material\": \"it\", \"positions\": [[0,0,0], [1,0,0], "
        "[0,1,0]],"
        " \"indices\": [[0,1,2]], \"uvs\": [[0,0], [1,2], [-1,0.5]] } ] }\n");
    assert_read_without("brushed.json", true);
    remove("brushed.json");
}

/* ---- lights and shadow rays ---- */

static uint64_t hit_pixels(const fathom_film *film) {
    const uint32_t *object = fathom_film_channel_id(film, "id.object");
    uint64_t count = 0;
    for (size_t i = 0; i < 48 * 40; ++i) count += object[i] != FATHOM_NONE;
    return count;
}

UNIT_TEST(each_point_has_a_ray_to_each_light_cast_or_counted) {
    stage s = stage_open(48, 40);
    stage_sphere(&s, 0, 0, 0, 1, 0);
    stage_point_light(&s, 3, 3, 2, 20);
    stage_point_light(&s, 0, 0, -9, 20); /* behind all that is seen */
    s.settings.aovs = FATHOM_AOV_ID;
    look_at_origin(&s);
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film = render(&s, &stats);
    assert_int_equal(stats.shadow_rays + stats.unlit_shadow_rays, 2 * hit_pixels(film));
    assert_true(stats.unlit_shadow_rays > stats.shadow_rays && stats.shadow_rays > 0);
}

/* ---- faint light ---- */

/* A mirroring ball and a floor under lights of a few to next to nothing. */
static stage open_faint(void) {
    stage s = stage_open(64, 48);
    fathom_material m = default_material();
    m.k_r[0] = m.k_r[1] = m.k_r[2] = 0.4f;
    stage_mesh_sphere(&s, FATHOM_ROOT, 12, 24, stage_material(&s, &m));
    stage_plane(&s, (double[3]){0, -1, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.6f));
    random_state random = {5};
    for (int k = 0; k < 30; ++k)
        stage_point_light(&s, random_in(&random, -5, 5), random_in(&random, 0, 6), random_in(&random, -5, 5),
                          (float)random_log(&random, 1e-8, 3));
    s.settings.spp = 4;
    look_at_origin(&s);
    return s;
}

/* What each channel lost is within what was allowed; float sums of up to 64 terms, in either image, are each
 * off by 64 units of 2^-24. */
static void assert_lost(const fathom_film *whole, const fathom_film *less, const fathom_settings *settings) {
    uint32_t width, height;
    fathom_film_size(whole, &width, &height);
    for (int c = 0; c < 3; ++c) {
        const float *x = fathom_film_channel(whole, names[c]), *y = fathom_film_channel(less, names[c]);
        for (size_t i = 0; i < (size_t)width * height; ++i) {
            double lost = (double)x[i] - (double)y[i], rounding = 128 * 0x1p-24 * (double)x[i];
            double most = (double)settings->max_loss + (double)settings->max_relative_loss * (double)y[i];
            assert_true(lost >= -rounding && lost <= most + rounding);
        }
    }
}

static void assert_loses_little(stage *s, uint64_t *faint) {
    fathom_settings exact = s->settings, loses = s->settings;
    exact.max_loss = exact.max_relative_loss = 0;
    fathom_stats stats = {.size = sizeof stats};
    s->settings = exact;
    fathom_film *whole = render(s, NULL);
    s->settings = loses;
    fathom_film *less = render(s, &stats);
    assert_lost(whole, less, &loses);
    *faint = stats.faint_shadow_rays;
}

UNIT_TEST(no_channel_loses_more_than_is_allowed) {
    stage s = open_faint();
    const float losses[][2] = {{1e-9f, 0}, {1e-4f, 0}, {0, 1e-4f}, {0.01f, 0.01f}, {1, 1}};
    uint64_t before = 0, faint;
    for (size_t i = 0; i < sizeof losses / sizeof *losses; ++i) {
        s.settings.max_loss = losses[i][0], s.settings.max_relative_loss = losses[i][1];
        assert_loses_little(&s, &faint);
        assert_true(faint > before || losses[i][0] == 0);
        before = faint;
    }
}

UNIT_TEST(each_ray_is_cast_or_faint_or_unlit) {
    stage s = open_faint();
    s.settings.max_depth = 0; /* the same points in either image */
    fathom_stats exact = {.size = sizeof exact}, loses = {.size = sizeof loses};
    render(&s, &exact);
    fathom_settings_set_loss(&s.settings, FATHOM_LOSS_8BIT, 0);
    fathom_film *film = render(&s, &loses);
    assert_true(says(film, "faint shadow rays"));
    assert_int_equal(exact.faint_shadow_rays, 0);
    assert_true(loses.faint_shadow_rays > exact.shadow_rays / 10);
    assert_int_equal(loses.shadow_rays + loses.faint_shadow_rays, exact.shadow_rays);
    assert_int_equal(loses.unlit_shadow_rays, exact.unlit_shadow_rays);
}

static int srgb_level(float value) {
    double v = (double)value, shown = v <= 0.0030399 ? 12.9233 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
    return (int)(255 * fmin(fmax(shown, 0), 1) + 0.5);
}

/* Files of the kind that was named change by one step at most, and some do. */
static void assert_one_step(stage *s, fathom_loss loss, float exposure) {
    fathom_settings_set_loss(&s->settings, FATHOM_LOSS_NONE, exposure);
    fathom_film *whole = render(s, NULL);
    fathom_settings_set_loss(&s->settings, loss, exposure);
    fathom_film *less = render(s, NULL);
    const float *x = fathom_film_channel(whole, "G"), *y = fathom_film_channel(less, "G");
    int changed = 0;
    for (size_t i = 0; i < 64 * 48; ++i) {
        float gain = exp2f(exposure);
        int step = loss == FATHOM_LOSS_8BIT ? srgb_level(gain * x[i]) - srgb_level(gain * y[i])
                                            : half_from_float(x[i]) - half_from_float(y[i]);
        assert_true(step >= 0 && step <= 1);
        changed += step;
    }
    assert_true(changed > 0);
}

UNIT_TEST(files_change_by_one_step_at_most) {
    stage s = open_faint();
    assert_one_step(&s, FATHOM_LOSS_8BIT, 0);
    assert_one_step(&s, FATHOM_LOSS_8BIT, 6);
    assert_one_step(&s, FATHOM_LOSS_HALF, 0);
}

/* What a sample loses depends on nothing but its own paths. */
UNIT_TEST(a_crop_loses_what_the_whole_image_loses) {
    stage s = open_faint();
    fathom_settings_set_loss(&s.settings, FATHOM_LOSS_8BIT, 0);
    fathom_film *whole = render(&s, NULL);
    const uint32_t crop[4] = {13, 7, 51, 39};
    memcpy(s.settings.crop, crop, sizeof crop);
    fathom_film *part = render(&s, NULL);
    const float *x = fathom_film_channel(whole, "R"), *y = fathom_film_channel(part, "R");
    for (uint32_t row = crop[1]; row < crop[3]; ++row)
        assert_memory_equal(x + row * 64 + crop[0], y + (row - crop[1]) * 38, 38 * sizeof *x);
}

UNIT_TEST(losses_outside_0_to_1_are_refused) {
    stage s = open_plain();
    fathom_film *film;
    const float wrong[] = {-1, 2, NAN};
    for (int i = 0; i < 3; ++i) {
        s.settings.max_loss = wrong[i];
        assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                     FATHOM_BAD_INPUT, "max loss");
    }
}

/* The last test: after all of these scenes read and rendered, nothing has asked for it. */
UNIT_TEST(rendering_does_not_load_the_image_libraries) {
    char line[512];
    FILE *maps = fopen("/proc/self/maps", "r");
    if (!maps) skip();
    while (fgets(line, sizeof line, maps)) {
        if (strstr(line, "fathom_image") || strstr(line, "OpenImageIO")) fail_msg("loaded: %s", line);
    }
    fclose(maps);
}

int main(void) { return unit_main(NULL, NULL); }
