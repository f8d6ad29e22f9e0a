/* Rays that leave surfaces neither meet them again nor pass by what touches them: see tests/offset.h. The
 * long run is bench/offset.sh. */
#include "offset.h"

#include "unit_scene.h"

static offset_counts run(offset_shape shape, bool instance, uint64_t rays) {
    offset_counts counts = {0};
    random_state r = {(uint64_t)shape * 2 + instance};
    while (counts.rays < rays) {
        offset_case c = offset_case_of(&r, shape, instance, 4, 1);
        assert_ok(context, offset_run(context, scene, &c, &r, stderr, &counts));
    }
    return counts;
}

static void check(offset_shape shape, bool instance) {
    offset_counts c = run(shape, instance, 100000);
    for (int k = 0; k < OFFSET_TRACERS; ++k) {
        assert_int_equal(c.self[k], 0);
        assert_int_equal(c.lost[k], 0);
        assert_int_equal(c.phantom[k], 0);
    }
    assert_int_equal(c.wrong_side, 0);
    assert_true(c.contacts > 4000); /* or nothing was tested */
    /* The promise; in instances Embree's inversion of the map adds to it (surface_point.c). */
    if (!instance) assert_true(c.most <= 32);
}

UNIT_TEST(in_the_world) {
    for (int shape = 0; shape < OFFSET_SHAPES; ++shape) check((offset_shape)shape, false);
}

UNIT_TEST(in_instances) {
    for (int shape = 0; shape < OFFSET_SHAPES; ++shape) {
        if (shape != OFFSET_PLANE) check((offset_shape)shape, true);
    }
}

int main(void) { return unit_main(open_scene, NULL); }
