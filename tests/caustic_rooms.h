/* Scenes with caustics, and comparisons of their light with photons and without. */
#pragma once

#include "integrate/caustics/caustics.h"
#include "plans.h"

#include <math.h>

static const double up[3] = {0, 1, 0};

static inline fathom_material glass_of(float metal) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = metal, m.roughness = 0, m.transmission = m.thickness = 1 - metal;
    m.base_color[1] = 0.7f;
    return m;
}

static inline void add_face(stage *s, double x, float e) {
    stage_quad(s, (double[3]){x, 3, 0.3}, (double[3]){0.3, 0, 0}, (double[3]){0, 0.1, 0.3},
               stage_emitter(s, e));
}

/* A floor, a glossy wall, and a camera near the floor in the middle, where caustics fall. */
static inline stage open_room(double lens) {
    stage s = stage_open(32, 32);
    fathom_material glossy = glass_of(1);
    fathom_camera camera;
    glossy.roughness = 0.4f;
    stage_quad(&s, (double[3]){0, -1, 0}, (double[3]){4, 0, 0}, (double[3]){0, 0, -4},
               stage_lambert(&s, 0.6f));
    stage_quad(&s, (double[3]){0, 1, -1.8}, (double[3]){4, 0, 0}, (double[3]){0, 2, 0},
               stage_material(&s, &glossy));
    fathom_camera_look_at((double[3]){0.5, 1.5, 6}, (double[3]){-0.1, -0.6, 0}, up, 0.4, &camera);
    camera.lens_radius = lens, camera.focus_distance = 5;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    return s;
}

/* A ball of glass under a lamp. */
static inline stage ball_under_lamp(void) {
    stage s = open_room(0);
    const fathom_material glass = glass_of(0);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0;
    add_face(&s, 0.4, 20);
    stage_sphere(&s, -0.1, 0, 0, 0.7, stage_material(&s, &glass));
    return s;
}

enum { CELLS = 17, SEEDS = 16, SAMPLES = SANITIZED ? 2 : 48 };

/* The light in 4 × 4 cells of the image and in all of it, over seeds: sums, and sums of squares. */
typedef struct cell_sums {
    double light[CELLS], squares[CELLS];
} cell_sums;

static inline void add_cells(const fathom_film *film, cell_sums *to) {
    static const char *const names[3] = {"R", "G", "B"};
    double light[CELLS] = {0};
    for (int c = 0; c < 3; ++c) {
        const float *channel = fathom_film_channel(film, names[c]);
        for (int i = 0; i < 32 * 32; ++i) {
            light[i / 32 / 8 * 4 + i % 32 / 8] += (double)channel[i];
            light[CELLS - 1] += (double)channel[i];
        }
    }
    for (int k = 0; k < CELLS; ++k) to->light[k] += light[k], to->squares[k] += light[k] * light[k];
}

static inline cell_sums light_by(stage *s, bool photons) {
    cell_sums out = {{0}, {0}};
    const uint32_t depth = s->settings.max_depth;
    fathom_settings_set_integrator(&s->settings, FATHOM_INTEGRATOR_PATH);
    s->settings.target_error = 0, s->settings.spp = SAMPLES, s->settings.max_depth = depth < 8 ? depth : 8;
    s->settings.photons = photons;
    for (s->settings.seed = 0; s->settings.seed < SEEDS; ++s->settings.seed) {
        fathom_film *film;
        assert_ok(s->context, fathom_render(s->context, s->scene, &s->settings, NULL, NULL, NULL, &film));
        add_cells(film, &out);
        fathom_film_destroy(film);
    }
    return out;
}

static inline double variance_of(const cell_sums *s, int k) {
    const double mean = s->light[k] / SEEDS;
    return fmax(s->squares[k] / SEEDS - mean * mean, 0) / (SEEDS - 1);
}

/* The mean variance of the cells. Paths alone may miss a cell's caustic in all renders, and its own variance
 * is then too small; the other cells, which such paths reach as seldom, tell how much light one of them
 * brings. */
static inline double variance_of_cells(const cell_sums *s) {
    double sum = 0;
    for (int k = 0; k < CELLS - 1; ++k) sum += variance_of(s, k);
    return sum / (CELLS - 1);
}

/* With 20 other sets of seeds, the largest of 2,380 comparisons was 2.9 standard errors, and 4.2 of those
 * with the few samples under sanitizers. */
static inline void expect_same(stage *a, stage *b, const char *what) {
    const cell_sums with = light_by(a, true), without = light_by(b, false);
    const double least = variance_of_cells(&with) + variance_of_cells(&without);
    for (int k = 0; k < CELLS; ++k) {
        const double apart = (with.light[k] - without.light[k]) / SEEDS,
                     error = sqrt(fmax(variance_of(&with, k) + variance_of(&without, k), least));
        if (!(fabs(apart) <= (SANITIZED ? 6.5 : 5) * error + 1e-5 * without.light[k] / SEEDS))
            fail_msg("%s, cell %d: %g of %g, error %g", what, k, apart, without.light[k] / SEEDS, error);
    }
}

static inline void compare(stage *s, const char *what) { expect_same(s, s, what); }

static inline void expect_photons(const render_plan *plan, double unused) {
    (void)unused;
    assert_non_null(plan->caustics);
}

/* There are photons to compare with. */
static inline void compare_all(stage *s, const char *what) {
    compare(s, what);
    s->settings.photons = true;
    look_at_plan(*s, 0, expect_photons);
}
