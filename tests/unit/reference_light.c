/* The reference path tracer meets the closed forms of light, and refuses what it does not implement. */
#include "integrate/reference/reference.h"
#include "unit_scene.h"
#include "verify/laws/laws.h"

/* Pixels are independent, so the squares of their errors add up. */
static fathom_status render_room(const law_room *room, uint64_t samples, uint64_t seed, sample_mean out[3]) {
    enum { WIDTH = 16, PIXELS = WIDTH * WIDTH };
    reference_estimate pixels[PIXELS];
    const reference_settings settings = {.width = WIDTH,
                                         .height = WIDTH,
                                         .samples = (uint32_t)(samples / PIXELS),
                                         .depth = room->depth,
                                         .seed = seed,
                                         .threads = 2,
                                         .terminator_fix = true};
    const fathom_status status = reference_render(room->b.scene, &settings, pixels);
    for (int c = 0; c < 3 && status == FATHOM_OK; ++c) {
        double mean = 0, square = 0;
        for (int i = 0; i < PIXELS; ++i)
            mean += pixels[i].mean[c] / PIXELS, square += pixels[i].error[c] * pixels[i].error[c];
        out[c] = (sample_mean){mean, sqrt(square) / PIXELS, PIXELS * (settings.samples - 1.0)};
    }
    return status;
}

/* A false alarm in one of 100,000 runs of these; the seed is fixed. Sums in double round to parts in 1e12,
 * and the closed forms of disks and of the far camera are good to 1e-5. */
UNIT_TEST(reference_meets_every_closed_form) {
    const laws_options options = {.render = render_room,
                                  .level = 1e-5,
                                  .error = SANITIZED ? 0.1 : 0.01,
                                  .allowance = 2e-5,
                                  .pilot = SANITIZED ? 1024 : 8192,
                                  .samples = 1 << 21,
                                  .seed = 1};
    laws_rows rows = {.tests = 0};
    assert_ok(context, laws_run(context, &options, &rows));
    assert_true(rows.rows.count >= 30);
    for (size_t i = 0; i < rows.rows.count; ++i) {
        const laws_row *r = &rows.rows.items[i];
        if (r->verdict != LAWS_HOLDS)
            print_message("%s: %g +- %g, expected %g: %.2f errors\n", r->law->name, r->found[r->worst].mean,
                          r->found[r->worst].error, r->value[r->worst], r->off);
    }
    assert_int_equal(laws_failed(&rows), 0);
    laws_rows_free(&rows);
}

static const reference_settings few = {
    .width = 8, .height = 8, .samples = 4, .depth = 4, .seed = 7, .threads = 2};

static void add_ball_mesh(void) {
    enum { RINGS = 12, AROUND = 16 };
    float p[RINGS * AROUND][3];
    uint32_t t[2 * RINGS * AROUND][3], count = 0;
    for (uint32_t i = 0; i < RINGS; ++i) {
        for (uint32_t k = 0; k < AROUND; ++k) {
            const double a = 3.14159 * (i + 0.5) / RINGS, b = 6.28318 * k / AROUND;
            float *v = p[i * AROUND + k];
            v[0] = (float)(sin(a) * cos(b)), v[1] = (float)(sin(a) * sin(b)), v[2] = (float)cos(a);
            const uint32_t next = i * AROUND + (k + 1) % AROUND;
            if (i + 1 == RINGS) continue;
            const uint32_t two[2][3] = {{i * AROUND + k, next, next + AROUND},
                                        {i * AROUND + k, next + AROUND, i * AROUND + k + AROUND}};
            memcpy(t[count], two, sizeof two);
            count += 2;
        }
    }
    const fathom_mesh mesh = {.color_channels = 3,
                              .positions = p[0],
                              .vertex_count = RINGS * AROUND,
                              .indices = t[0],
                              .triangle_count = count,
                              .normals = p[0],
                              .normal_count = RINGS * AROUND};
    fathom_instance instance = default_instance();
    const double map[12] = {0.5, 0, 0.2, 1, 0, -1.5, 0, 0, 0, 0.1, 0.7, -1};
    memcpy(instance.transform, map, sizeof map);
    const fathom_id group = new_group(scene, NULL);
    instance.group = group;
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
}

static void look_at_ball(void) {
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0, -4, 1}, (double[3]){0.4, 0, -0.4}, (double[3]){0, 0, 1}, 0.7,
                          &camera);
    assert_ok(context, fathom_scene_set_camera(scene, &camera));
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){1, 0.5f, 0.25f}));
}

UNIT_TEST(boxes_do_not_change_the_closest_hit) {
    reference_settings settings = few;
    reference_estimate boxes[64], linear[64];
    add_ball_mesh();
    look_at_ball();
    assert_ok(context, reference_render(scene, &settings, boxes));
    settings.without_bvh = true;
    assert_ok(context, reference_render(scene, &settings, linear));
    assert_memory_equal(boxes, linear, sizeof boxes);
    assert_true(boxes[27].mean[0] > 0);
}

UNIT_TEST(image_does_not_depend_on_threads) {
    reference_settings settings = few;
    reference_estimate two[64], one[64];
    add_ball_mesh();
    look_at_ball();
    assert_ok(context, reference_render(scene, &settings, two));
    settings.threads = 1;
    assert_ok(context, reference_render(scene, &settings, one));
    assert_memory_equal(one, two, sizeof one);
}

static void refused_with(fathom_material m, const char *word) {
    reference_estimate out[64];
    fathom_sphere sphere = {.radius = 1};
    assert_ok(context, fathom_scene_add_material(scene, NULL, &m, &sphere.material));
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    look_at_ball();
    assert_fails(context, reference_render(scene, &few, out), FATHOM_BAD_INPUT, word);
    open_scene(NULL);
}

UNIT_TEST(unknown_parameters_are_refused_by_name) {
    fathom_material m = law_metallic();
    m.clearcoat = m.transmission = 1, refused_with(m, "clearcoat");
    m.clearcoat = 0, m.sheen_color[1] = 1, refused_with(m, "sheen_color");
    m.sheen_color[1] = 0, m.iridescence = m.thickness = 1, refused_with(m, "iridescence");
    m = law_metallic(), m.transmission = m.thickness = 1;
    m.specular_factor = 0.5f, refused_with(m, "specular_factor");
}

/* The largest relative standard deviation of a pixel's samples. */
static double spread_of(const reference_estimate *pixels, const reference_settings *o, int channel) {
    double most = 0;
    for (int i = 0; i < 64; ++i)
        most = fmax(most, pixels[i].error[channel] * sqrt(o->samples - 1.0) / pixels[i].mean[channel]);
    return most;
}

/* Comparisons with path tracing estimate their error from such samples. A bounce off a facet or through it
 * multiplies the mean square of a sample's weight by about 1.3, the choice of one of three channels by 3.
 * With a mean of three bounces, the spread is 1.1 and 2.4. */
UNIT_TEST(rough_glass_has_no_rare_bright_paths) {
    for (int k = 0; k < 2; ++k) {
        reference_estimate out[64];
        reference_settings settings = few;
        fathom_sphere sphere = {.radius = 1};
        fathom_material m = law_metallic();
        settings.samples = 1024, settings.depth = 16;
        m.transmission = m.thickness = m.specular_factor = 1, m.metallic = 0, m.roughness = k ? 0.4f : 0.5f;
        m.anisotropy = k ? 0 : 0.8f, m.dispersion = k ? 2 : 0;
        assert_ok(context, fathom_scene_add_material(scene, NULL, &m, &sphere.material));
        assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
        look_at_ball();
        assert_ok(context, reference_render(scene, &settings, out));
        assert_true(spread_of(out, &settings, 0) < 4);
        open_scene(NULL);
    }
}

UNIT_TEST(overlapping_volumes_are_refused) {
    reference_estimate out[64];
    fathom_material m = law_metallic();
    m.transmission = m.thickness = m.specular_factor = 1;
    for (int i = 0; i < 2; ++i) {
        fathom_sphere sphere = {.center = {0.5 * i, 0, 0}, .radius = 1};
        assert_ok(context, fathom_scene_add_material(scene, NULL, &m, &sphere.material));
        assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    }
    look_at_ball();
    assert_fails(context, reference_render(scene, &few, out), FATHOM_BAD_INPUT, "overlap");
    fathom_settings settings = default_settings();
    fathom_film *film;
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_REFERENCE);
    settings.width = settings.height = 8;
    for (int how = 0; how < 3; ++how) {
        settings.target_error = how == 1 ? 0.1 : 0, settings.max_time = how == 2 ? 60 : 0, settings.spp = 16;
        assert_fails(context, fathom_render(context, scene, &settings, NULL, NULL, NULL, &film),
                     FATHOM_BAD_INPUT, "overlap");
    }
}

int main(void) { return unit_main_each(open_scene, NULL); }
