/* Smooth normals: weighted by angle, whatever the triangles, threads and sizes are. */
#include "read/mesh/normals.h"

#include "math/vec.h"
#include "random.h"
#include "unit_context.h"

static void smooth(const float (*p)[3], uint32_t vertices, const uint32_t *indices, size_t triangles,
                   float (*out)[3]) {
    const fathom_mesh mesh = {.positions = p[0],
                              .position_stride = sizeof *p,
                              .indices = indices,
                              .triangle_count = (uint32_t)triangles};
    assert_ok(context, normals_smooth(context, &mesh, NULL, vertices, out[0]));
}

/* A cube's corners point along its diagonals however its faces are cut: with area or no weights the cuts
 * would show. The angles' error is 2e-8 of pi/2, the sums' rounding 2^-29, float's own 2^-24. */
UNIT_TEST(a_cube_has_normals_along_its_diagonals) {
    float p[8][3], n[8][3];
    for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 3; ++k) p[i][k] = i >> k & 1 ? 1 : -1;
    }
    const uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (unsigned cuts = 0; cuts < 64; ++cuts) {
        uint32_t indices[36];
        for (uint32_t f = 0; f < 6; ++f) {
            const uint32_t *c = faces[f], turn = cuts >> f & 1;
            const uint32_t fan[6] = {c[turn], c[turn + 1], c[turn + 2],
                                     c[turn], c[turn + 2], c[(turn + 3) % 4]};
            memcpy(indices + 6 * f, fan, sizeof fan);
        }
        smooth((const float(*)[3])p, 8, indices, 12, n);
        for (int i = 0; i < 8; ++i) {
            for (int k = 0; k < 3; ++k) assert_near(n[i][k], (double)p[i][k] / sqrt(3), 1.5e-7);
        }
    }
}

/* The corner of a pyramid of random steep sides: the sum of unit normals times angles, from the C library. */
UNIT_TEST(corners_are_weighted_by_their_angle) {
    random_state random = {4};
    for (int round = 0; round < 1000; ++round) {
        float p[4][3] = {{0, 0, 0}};
        double size = random_log(&random, 1e-18, 1e18);
        for (int i = 1; i < 4; ++i) {
            for (int k = 0; k < 3; ++k) p[i][k] = (float)(size * random_in(&random, -1, 1));
        }
        const uint32_t indices[9] = {0, 1, 2, 0, 2, 3, 0, 3, 1};
        float n[4][3];
        vec3_f64 sum = {0, 0, 0};
        for (int t = 0; t < 3; ++t) {
            vec3_f64 a = normalize_f64(widen(load_f32(p[indices[3 * t + 1]])));
            vec3_f64 b = normalize_f64(widen(load_f32(p[indices[3 * t + 2]])));
            vec3_f64 c = cross_f64(a, b);
            sum = add_f64(sum, scale_f64(atan2(length_f64(c), dot_f64(a, b)), normalize_f64(c)));
        }
        smooth((const float(*)[3])p, 4, indices, 3, n);
        /* Where the sum nearly cancels, its errors weigh more: 3 corners of 2e-8 and 2^-29 each, and 2^-24.
         */
        double tolerance = 3 * 2.4e-8 / length_f64(sum) + 0x1p-23;
        vec3_f64 error = sub_f64(widen(load_f32(n[0])), normalize_f64(sum));
        if (length_f64(error) > tolerance) fail_msg("off by %g, expected %g", length_f64(error), tolerance);
    }
}

/* Slots keep groups apart: two faces of a fold that share vertices but not normals stay flat. */
UNIT_TEST(corners_add_to_their_slot) {
    const float p[4][3] = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
    const uint32_t indices[6] = {0, 2, 1, 0, 1, 3}, apart[6] = {0, 1, 2, 3, 4, 5};
    float n[6][3];
    const fathom_mesh mesh = {
        .positions = p[0], .position_stride = sizeof *p, .indices = indices, .triangle_count = 2};
    assert_ok(context, normals_smooth(context, &mesh, apart, 6, n[0]));
    for (int i = 0; i < 6; ++i) {
        assert_true(n[i][0] == (i < 3 ? 0 : 1) && n[i][1] == 0 && n[i][2] == (i < 3 ? 1 : 0));
    }
}

/* Nothing to sum, or a sum of zero: still unit normals. */
UNIT_TEST(cancelled_corners_get_a_triangles_normal) {
    const float p[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}, {5, 5, 5}};
    const uint32_t indices[9] = {0, 1, 2, 0, 2, 1, 3, 3, 4};
    float n[5][3];
    smooth(p, 5, indices, 3, n);
    assert_true(n[0][2] == -1 && n[1][2] == -1 && n[2][2] == -1);
    assert_true(n[3][2] == 1 && n[4][2] == 1);
}

UNIT_TEST(normals_do_not_depend_on_thread_count) {
    enum { vertices = 20000, triangles = 60000 };
    float(*p)[3] = malloc(vertices * sizeof *p), (*n[2])[3];
    uint32_t *indices = unit_memory(3 * triangles * sizeof *indices);
    random_state random = {9};
    for (uint32_t i = 0; i < vertices; ++i) {
        for (int k = 0; k < 3; ++k) p[i][k] = (float)random_in(&random, -1, 1);
    }
    for (uint32_t i = 0; i < 3 * triangles; ++i) indices[i] = (uint32_t)(random_bits(&random) % vertices);
    for (unsigned i = 0; i < 2; ++i) {
        n[i] = malloc(vertices * sizeof *n[i]);
        fathom_context_set_threads(context, i ? 7 : 1);
        smooth((const float(*)[3])p, vertices, indices, triangles, n[i]);
    }
    assert_memory_equal(n[0], n[1], vertices * sizeof **n);
    free(n[0]);
    free(n[1]);
    free(p);
}

int main(void) { return unit_main(open_context, NULL); }
