/* A room that a sky lights through a window: paths before the image tell its light samples where
 * the window is. */
#include "image/image.h"
#include "math/lane.h"
#include "pairs.h"
#include "plans.h"
#include "random.h"
#include "scene/scene.h"
#include "unit_folder.h"

enum { WIDTH = 64, HEIGHT = 32 };

static void write_sky(void) {
    static float texels[WIDTH * HEIGHT][3];
    random_state r = {1};
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 0.1, 10);
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], 3 * sizeof(float)},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], 3 * sizeof(float)},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], 3 * sizeof(float)}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0, 0};
    assert_ok(context, exr_write_plain(context, &img, in_folder("sky.exr")));
}

static void add_sky(stage *s) {
    fathom_light light = default_light();
    write_sky();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

/* It shines through the window onto the floor. */
static void add_sun(stage *s, float intensity) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_DIRECTIONAL;
    for (int c = 0; c < 3; ++c) light.intensity[c] = intensity, light.direction[c] = (float[3]){1, -1, 0}[c];
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

typedef struct room_parts {
    bool painted, pane; /* under an image of a sky, or an even background */
    float lamp, sun;
} room_parts;

/* A box from -2 to 2, whose side at x = -2 has a window from -1 to 1; in it a ball. */
static stage room(room_parts with) {
    stage s = stage_open(64, 64);
    const fathom_id wall = stage_lambert(&s, 0.6f);
    fathom_material clear = default_material();
    clear.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    clear.metallic = clear.roughness = 0, clear.transmission = 1;
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    if (with.painted)
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
    if (with.pane)
        stage_quad(&s, (double[3]){-2, 0, 0}, (double[3]){0, 1, 0}, (double[3]){0, 0, 1},
                   stage_material(&s, &clear));
    if (with.lamp > 0)
        stage_quad(&s, (double[3]){0, 1.9, 0}, (double[3]){0.2, 0, 0}, (double[3]){0, 0, 0.2},
                   stage_emitter(&s, with.lamp));
    if (with.sun > 0) add_sun(&s, with.sun);
    stage_sphere(&s, 0.5, -1, 0, 0.7, wall);
    stage_camera(&s, (double[3]){1.5, 1, 1.9}, (double[3]){-0.5, -1, -1}, (double[3]){0, 1, 0}, 1.2);
    return s;
}

UNIT_TEST(rooms_are_lit_as_the_reference_says) {
    const laws_pair options = pair_of(6, 1 << 17);
    const room_parts rooms[] = {{true, false, 0, 0},  {true, true, 0, 0},  {true, false, 5, 0},
                                {false, false, 0, 0}, {false, true, 0, 0}, {false, false, 5, 0},
                                {true, false, 0, 2},  {false, false, 5, 1}};
    for (int k = 0; k < 8; ++k) {
        stage s = room(rooms[k]);
        laws_difference d;
        assert_ok(s.context, laws_pair_run(s.context, s.scene, &options, &d));
        if (d.p < 1e-5) fail_msg("room %d: p %g, %g +- %g", k, d.p, d.relative, d.relative_error);
    }
}

/* Points in the middle of a surface, at most so far from it along x and z. */
typedef struct spot {
    vec3_f32 p, n;
    double wide, deep;
} spot;

static void sample_lights(const render_plan *plan, const spot *at, random_state *r, emitter_query *q,
                          emitter_sample *light) {
    _Alignas(64) lanes3 u;
    memset(q, 0, sizeof *q);
    for (unsigned i = 0; i < LANES; ++i) {
        const float x = (float)random_in(r, -at->wide, at->wide),
                    z = (float)random_in(r, -at->deep, at->deep);
        put_lane_f32(q->p, i, vec_f32(at->p.x + x, at->p.y, at->p.z + z));
        put_lane_f32(q->n, i, at->n);
        for (int c = 0; c < 3; ++c) u[c][i] = (float)random_in(r, 0, 0.999);
    }
    emitters_sample(plan->emitters, q, u, light);
}

/* A window shows at most a twentieth of the sky's upper half, which alone would take half of the samples. An
 * even background next to a lamp would take none. */
static void expect_window(const render_plan *plan, double least) {
    const spot floor = {vec_f32(0.75f, -2, 0), vec_f32(0, 1, 0), 0.75, 1};
    random_state r = {2};
    int out = 0, all = 0;
    for (int k = 0; k < 400; ++k) {
        emitter_query q;
        emitter_sample light;
        sample_lights(plan, &floor, &r, &q, &light);
        for (unsigned i = 0; i < LANES; ++i, ++all) {
            const vec3_f64 p = widen(lane_f32(q.p, i)), d = widen(lane_f32(light.direction, i)),
                           at = madd_f64(p, (-2 - p.x) / d.x, d);
            out += d.x < 0 && fabs(at.y) < 1 && fabs(at.z) < 1;
        }
    }
    if (out < least * all) fail_msg("%d of %d", out, all);
}

UNIT_TEST(light_samples_leave_by_the_window) {
    if (SANITIZED) skip(); /* the same paths as those of the rooms above */
    look_at_plan(room((room_parts){false, false, 0, 0}), 0.3, expect_window);
    look_at_plan(room((room_parts){false, true, 0, 0}), 0.3, expect_window);
    look_at_plan(room((room_parts){false, false, 5, 0}), 0.25, expect_window);
    look_at_plan(room((room_parts){true, true, 0, 0}), 0.3, expect_window);
    look_at_plan(room((room_parts){true, false, 0, 0}), 0.3, expect_window);
}

/* The fraction of light samples that go to the sun. */
static double to_the_sun(const render_plan *plan, spot at) {
    random_state r = {3};
    int suns = 0;
    for (int k = 0; k < 100; ++k) {
        emitter_query q;
        emitter_sample light;
        sample_lights(plan, &at, &r, &q, &light);
        for (unsigned i = 0; i < LANES; ++i) suns += light.part[i] == EMITTER_DIRECTIONAL;
    }
    return suns / (100.0 * LANES);
}

/* The sun's light enters between heights of -1 and 1, and meets the floor at x from -1 to 1. The wall at z =
 * 2 is parallel to it. */
static void expect_sun(const render_plan *plan, double least) {
    const double floor = to_the_sun(plan, (spot){vec_f32(-0.5f, -2, 0), vec_f32(0, 1, 0), 0.3, 0.3}),
                 wall = to_the_sun(plan, (spot){vec_f32(-0.5f, 0, 2), vec_f32(0, 0, -1), 0.3, 0});
    if (floor < least || wall > 0.2) fail_msg("%g on the floor, %g on the wall", floor, wall);
}

UNIT_TEST(light_samples_go_to_the_sun_where_it_shines) {
    look_at_plan(room((room_parts){true, false, 0, 20}), 0.5, expect_sun);
}

/* Paths before the image are the same for all of them. */
UNIT_TEST(threads_and_crops_change_no_bit) {
    stage s = room((room_parts){true, true, 5, 1});
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
}

int main(void) { return unit_main(open_folder, remove_folder); }
