/* Two rooms without a door between them: paths before the image tell the light samples of each room which
 * lamps it has. */
#include "light/emitters_inner.h"
#include "math/lane.h"
#include "pairs.h"
#include "plans.h"
#include "random.h"
#include "scene/scene.h"

/* Lamps of a room: one node of the light tree, or several. */
enum { FEW = 3, MANY = 24 };

static void add_box(stage *s, double x, fathom_id wall) {
    for (int side = 0; side < 6; ++side) {
        const int axis = side % 3;
        double at[3] = {x, 0, 0}, u[3] = {0}, v[3] = {0};
        at[axis] += side < 3 ? 1 : -1, u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
        stage_quad(s, at, u, v, wall);
    }
}

/* Boxes around x = -1.01 and x = 1.01, with lamps at half their height. The camera is in the first one, whose
 * lamps are dimmer. */
static stage rooms(int lamps, float near, float far) {
    stage s = stage_open(64, 64);
    const fathom_id wall = stage_lambert(&s, 0.5f), dim = stage_emitter(&s, near),
                    bright = stage_emitter(&s, far);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    for (int side = -1; side <= 1; side += 2) {
        const double x = side * 1.01;
        add_box(&s, x, wall);
        for (int k = 0; k < lamps; ++k)
            stage_sphere(&s, x + 0.7 * cos(k), 0.2 * cos(3 * k), 0.7 * sin(k), lamps == FEW ? 0.15 : 0.06,
                         side < 0 ? dim : bright);
    }
    stage_camera(&s, (double[3]){-1.9, 0.8, 0.9}, (double[3]){0.7, -0.7, -0.7}, (double[3]){0, 1, 0}, 1.2);
    return s;
}

UNIT_TEST(rooms_without_doors_are_lit_as_the_reference_says) {
    const laws_pair options = pair_of(5, 1 << 16);
    for (int k = 0; k < 2; ++k) {
        stage s = rooms(k ? MANY : FEW, 1, 300);
        laws_difference d;
        assert_ok(s.context, laws_pair_run(s.context, s.scene, &options, &d));
        if (d.p < 1e-5) fail_msg("rooms %d: p %g, %g +- %g", k, d.p, d.relative, d.relative_error);
    }
}

/* At a point of the floor or a wall of the first room: the chances of all lights, and of its own. */
static void add_chances(const emitters *e, random_state *r, double *all, double *own) {
    const vec3_f32 p = vec_f32((float)random_in(r, -2, 0), -1, (float)random_in(r, -1, 1)), n = {0, 1, 0};
    *all = *own = 0;
    for (uint32_t k = 0; k < e->surface_count; ++k) {
        emitter_ball ball;
        if (e->slot_of[k] == FATHOM_NONE) continue;
        const emitter_run *run = emitters_run_of(e, k);
        emitters_ball(e, run, k - run->first, 0, &ball);
        const double chance = tree_chance(&e->lights, p, n, emitters_view(e, p, n), e->slot_of[k]);
        *all += chance, *own += ball.center.x < 0 ? chance : 0;
    }
}

/* Without learning, the other room's lamps would get most of the samples. The sums of chances are off by the
 * roundings of the floats that they are computed from, fewer than 100. */
static void expect_own_lamps(const render_plan *plan, double rows) {
    const emitters *e = plan->emitters;
    random_state r = {1};
    double mean = 0;
    assert_non_null(e->seen.tables);
    assert_true(e->lights.rows >= rows);
    for (int k = 0; k < 200; ++k) {
        double all, own;
        add_chances(e, &r, &all, &own);
        assert_near(all, 1, 100 * 0x1p-24);
        mean += own / 200;
    }
    if (mean < 0.7) fail_msg("%g", mean);
}

static void expect_lists(const render_plan *plan, double rows) {
    const emitter_views *views = &plan->emitters->views;
    size_t lists = 0;
    (void)rows;
    for (size_t k = 0; k < views->count; ++k) lists += views->items[k].near_count > 0;
    assert_true(lists > 0);
}

UNIT_TEST(regions_list_the_lights_that_matter) { look_at_plan(rooms(MANY, 20, 1e-3f), 0, expect_lists); }

UNIT_TEST(light_samples_stay_in_the_room) {
    if (SANITIZED) skip(); /* the same paths as those of the rooms above */
    look_at_plan(rooms(FEW, 1, 20), 1, expect_own_lamps);
    look_at_plan(rooms(MANY, 1, 20), 2, expect_own_lamps);
}

static void expect_nothing(const render_plan *plan, double rows) {
    (void)rows;
    assert_null(plan->emitters->seen.tables);
}

/* The other room has hardly any light. */
UNIT_TEST(lamps_in_view_need_no_factors) { look_at_plan(rooms(MANY, 20, 1e-3f), 0, expect_nothing); }

UNIT_TEST(threads_change_no_bit_of_rooms) {
    stage s = rooms(MANY, 1, 20);
    s.settings.spp = SANITIZED ? 4 : 16;
    fathom_context_set_threads(s.context, 1);
    fathom_film *one = stage_render(&s);
    fathom_context_set_threads(s.context, 3);
    fathom_film *three = stage_render(&s);
    for (int c = 0; c < 3; ++c) assert_memory_equal(one->rgb[c], three->rgb[c], 64 * 64 * sizeof(float));
}

int main(void) { return unit_main(NULL, NULL); }
