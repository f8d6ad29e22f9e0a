/* A room that a sky lights through a window: paths before the image tell its light samples where
 * the window is. */
#include "image/image.h"
#include "integrate/plan.h"
#include "math/lane.h"
#include "random.h"
#include "render.h"
#include "scene/scene.h"
#include "unit_folder.h"
#include "verify/laws/laws.h"

enum { WIDTH = 64, HEIGHT = 32 };

static void write_sky(void) {
    static float texels[WIDTH * HEIGHT][3];
    random_state r = {1};
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 0.1, 10);
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], 3 * sizeof(float)},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], 3 * sizeof(float)},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], 3 * sizeof(float)}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0};
    assert_ok(context, exr_write_plain(context, &img, in_folder("sky.exr")));
}

static void add_sky(stage *s) {
    fathom_light light;
    write_sky();
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

/* A box from -2 to 2, whose side at x = -2 has a window from -1 to 1, with a pane or without, under an image
 * of a sky or an even background; in it a ball and a lamp. */
static stage room(bool painted, bool pane, float lamp) {
    stage s = stage_open(64, 64);
    const fathom_id wall = stage_lambert(&s, 0.6f);
    fathom_material clear;
    fathom_material_default(&clear);
    clear.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    clear.metallic = clear.roughness = 0, clear.transmission = 1;
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    if (painted)
        add_sky(&s);
    else
        assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.5f, 1, 2}));
    for (int side = 0; side < 5; ++side) {
        const int axis = side < 3 ? side : side - 2;
        double at[3] = {0}, u[3] = {0}, v[3] = {0};
        at[axis] = side < 3 ? 2 : -2, u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2;
        stage_quad(&s, at, u, v, wall);
    }
    for (int sign = -1; sign <= 1; sign += 2) {
        stage_quad(&s, (double[3]){-2, sign * 1.5, 0}, (double[3]){0, 0.5, 0}, (double[3]){0, 0, 2}, wall);
        stage_quad(&s, (double[3]){-2, 0, sign * 1.5}, (double[3]){0, 1, 0}, (double[3]){0, 0, 0.5}, wall);
    }
    if (pane)
        stage_quad(&s, (double[3]){-2, 0, 0}, (double[3]){0, 1, 0}, (double[3]){0, 0, 1},
                   stage_material(&s, &clear));
    if (lamp > 0)
        stage_quad(&s, (double[3]){0, 1.9, 0}, (double[3]){0.2, 0, 0}, (double[3]){0, 0, 0.2},
                   stage_emitter(&s, lamp));
    stage_sphere(&s, 0.5, -1, 0, 0.7, wall);
    stage_camera(&s, (double[3]){1.5, 1, 1.9}, (double[3]){-0.5, -1, -1}, (double[3]){0, 1, 0}, 1.2);
    return s;
}

UNIT_TEST(rooms_are_lit_as_the_reference_says) {
    const laws_pair options = {
        .across = 4, .down = 4, .depth = 6, .samples = 1 << 17, .seed = 1, .threads = 2, .allowance = 2e-5};
    for (int k = 0; k < 6; ++k) {
        stage s = room(k < 3, k % 3 == 1, k % 3 == 2 ? 5 : 0);
        laws_difference d;
        assert_ok(s.context, laws_pair_run(s.context, s.scene, &options, &d));
        if (d.p < 1e-5) fail_msg("room %d: p %g, %g +- %g", k, d.p, d.relative, d.relative_error);
        stage_close(&s);
    }
}

/* A window shows at most a twentieth of the sky's upper half, which alone would take half of the samples. An
 * even background next to a lamp would take none. */
static void expect_window(const render_plan *plan, double least) {
    random_state r = {2};
    int out = 0, all = 0;
    for (int k = 0; k < 400; ++k) {
        _Alignas(64) lanes3 u;
        emitter_query q;
        emitter_sample light;
        memset(&q, 0, sizeof q);
        for (unsigned i = 0; i < LANES; ++i) {
            put_lane_f32(q.p, i, vec_f32((float)random_in(&r, 0, 1.5), -2, (float)random_in(&r, -1, 1)));
            put_lane_f32(q.n, i, vec_f32(0, 1, 0));
            for (int c = 0; c < 3; ++c) u[c][i] = (float)random_in(&r, 0, 0.999);
        }
        emitters_sample(plan->emitters, &q, u, &light);
        for (unsigned i = 0; i < LANES; ++i, ++all) {
            const vec3_f64 p = widen(lane_f32(q.p, i)), d = widen(lane_f32(light.direction, i)),
                           at = madd_f64(p, (-2 - p.x) / d.x, d);
            out += d.x < 0 && fabs(at.y) < 1 && fabs(at.z) < 1;
        }
    }
    if (out < least * all) fail_msg("%d of %d", out, all);
}

UNIT_TEST(light_samples_leave_by_the_window) {
    for (int k = 0; k < 5; ++k) {
        stage s = room(k > 2, k == 1 || k == 3, k == 2 ? 5 : 0);
        const trace_options options = {.timed = true, .threads = 2, .expected_rays = 1000000};
        trace_tracer *tracer;
        render_plan *plan;
        world *w;
        s.settings.width = s.settings.height = 256;
        assert_ok(s.context, world_create(s.scene, &w));
        assert_ok(s.context, trace_create(s.context, w, &options, &tracer));
        assert_ok(s.context, plan_create(s.context, w, tracer, &s.settings, NULL, &plan));
        expect_window(plan, k == 2 ? 0.25 : 0.3);
        plan_destroy(plan);
        trace_destroy(tracer);
        world_destroy(w);
        stage_close(&s);
    }
}

/* Paths before the image are the same for all of them. */
UNIT_TEST(threads_and_crops_change_no_bit) {
    stage s = room(true, true, 5);
    s.settings.spp = 4;
    fathom_context_set_threads(s.context, 1);
    fathom_film *one = stage_render(&s);
    fathom_context_set_threads(s.context, 3);
    fathom_film *three = stage_render(&s);
    memcpy(s.settings.crop, (uint32_t[4]){20, 30, 37, 39}, sizeof s.settings.crop);
    fathom_film *part = stage_render(&s);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(one->rgb[c], three->rgb[c], 64 * 64 * sizeof(float));
        for (uint32_t y = 0; y < part->height; ++y)
            assert_memory_equal(one->rgb[c] + (part->y + y) * 64 + part->x, part->rgb[c] + y * part->width,
                                part->width * sizeof(float));
    }
    fathom_film_destroy(one), fathom_film_destroy(three), fathom_film_destroy(part);
    stage_close(&s);
}

static int end(void **state) {
    unlink(in_folder("sky.exr"));
    return remove_folder(state);
}

int main(void) { return unit_main(open_folder, end); }
