/* Images of what moves: the mean of still images, path tracing against the reference, and which changes
 * change no bit. */
#include "moving.h"
#include "pairs.h"
#include "stills.h"

/* ---- against the reference ---- */

UNIT_TEST(both_integrators_blur_alike) {
    const laws_pair options = pair_of(4, 1 << 16);
    for (unsigned moves = TURN; moves <= ALL; moves = moves == NEST  ? ALL
                                                      : moves == ALL ? ALL + 1
                                                                     : 2 * moves) {
        stage s = moving_stage(moves, 0, 2);
        laws_difference d;
        assert_ok(s.context, laws_pair_run(s.context, s.scene, &options, &d));
        if (d.p < 1e-5)
            fail_msg("motion %u: p %g, path less reference %g +- %g", moves, d.p, d.relative,
                     d.relative_error);
    }
}

/* ---- the mean of still images ---- */

static stage all_moving(double open, double close) { return moving_stage(ALL, open, close); }

UNIT_TEST(a_blurred_image_is_the_mean_of_still_ones) { assert_mean_of_stills(all_moving, 0, 2); }

/* ---- to the last bit ---- */

static void assert_same_images(stage *a, stage *b, bool same) {
    fathom_film *x = stage_render(a), *y = stage_render(b);
    int differ = 0;
    static const char *const names[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c)
        differ += memcmp(fathom_film_channel(x, names[c]), fathom_film_channel(y, names[c]),
                         PIXELS * sizeof(float)) != 0;
    if (same)
        assert_int_equal(differ, 0);
    else
        assert_true(differ > 0);
}

UNIT_TEST(keys_that_are_alike_change_no_bit) {
    stage keyed = moving_stage(0, 0, 2), unmoved = moving_stage(0, 0, 0);
    assert_same_images(&keyed, &unmoved, true);
}

UNIT_TEST(threads_change_no_bit) {
    stage one = moving_stage(ALL, 0, 2), three = moving_stage(ALL, 0, 2);
    fathom_context_set_threads(one.context, 1);
    fathom_context_set_threads(three.context, 3);
    assert_same_images(&one, &three, true);
}

/* A crop traces other rays together, as parts, restarts and adaptive renders do. */
UNIT_TEST(a_crop_changes_no_bit) {
    stage whole = moving_stage(ALL, 0, 2), part = moving_stage(ALL, 0, 2);
    const uint32_t crop[4] = {5, 3, 30, 22};
    memcpy(part.settings.crop, crop, sizeof crop);
    fathom_film *x = stage_render(&whole), *y = stage_render(&part);
    const float *all = fathom_film_channel(x, "G"), *some = fathom_film_channel(y, "G");
    for (uint32_t i = 0; i < 19 * 25; ++i) assert_true(some[i] == all[(3 + i / 25) * 32 + 5 + i % 25]);
}

UNIT_TEST(other_shutters_show_something_else) {
    stage a = moving_stage(FLY, 0, 2), b = moving_stage(FLY, 0, 1);
    assert_same_images(&a, &b, false);
}

int main(void) { return unit_main(NULL, NULL); }
