/* Every way of rendering a moving scene gives the same bits, with all AOVs and the sums of fireflies. */
#include "film/film.h"

#include "moving.h"
#include "unit_folder.h"

#include <unistd.h>

static stage st;
static int ticks; /* of progress, after which the render stops */

static int set_up(void **state) {
    (void)state;
    ticks = 0;
    st = moving_stage(ALL, 0, 2);
    st.settings.width = 70, st.settings.height = 40, st.settings.spp = 16;
    st.settings.aovs = FATHOM_AOVS, st.settings.fireflies = FATHOM_FIREFLIES_REWEIGHT;
    return 0;
}

/* ---- comparing ---- */

/* The pixels that `a` shares with `part`, a crop of the same image, but for `rim` pixels at its edge. */
static void assert_same_channel(const fathom_film *a, const void *of_a, const fathom_film *part,
                                const void *of_part, uint32_t rim) {
    for (uint32_t y = rim; y + rim < part->height; ++y) {
        const size_t from = (size_t)(y + part->y - a->y) * a->width + part->x - a->x;
        assert_memory_equal((const uint32_t *)of_a + from + rim,
                            (const uint32_t *)of_part + (size_t)y * part->width + rim,
                            (part->width - 2 * rim) * sizeof(uint32_t));
    }
}

/* Errors take from their neighbours what the crop has of them, and so do second images. */
static bool takes_from_neighbours(const film_channel *c) {
    return c->name && strncmp(c->name, "error", 5) == 0;
}

static void assert_same(stage *s, const fathom_film *a, const fathom_film *part) {
    const bool crop = part->width < a->width;
    assert_int_equal(a->channel_count, part->channel_count);
    assert_string_equal(a->fireflies, part->fireflies);
    for (uint32_t i = 0; i < a->channel_count; ++i) {
        if (crop && takes_from_neighbours(&a->channels[i])) continue;
        assert_same_channel(a, a->channels[i].data, part, part->channels[i].data, 0);
    }
    fathom_film *x, *y;
    assert_ok(s->context, fathom_film_reweight(s->context, a, &x));
    assert_ok(s->context, fathom_film_reweight(s->context, part, &y));
    for (int c = 0; c < 3; ++c) assert_same_channel(x, x->rgb[c], y, y->rgb[c], crop);
    if (!crop) assert_string_equal(x->fireflies, y->fireflies);
    fathom_film_destroy(x);
    fathom_film_destroy(y);
}

/* ---- ways ---- */

static bool stop_after(void *user, const fathom_progress *now) {
    (void)user;
    return now->phase != FATHOM_PHASE_RENDER || ticks-- > 0;
}

/* Stopped again and again, each time on another number of threads; returns how often. */
static int render_with_stops(fathom_film **out) {
    fathom_checkpoint saving = default_checkpoint();
    saving.path = in_folder("c");
    fathom_session_options options = default_session_options();
    options.checkpoint = &saving, options.progress = stop_after;
    for (int stops = 0;; ++stops) {
        ticks = stops;
        fathom_context_set_threads(st.context, 1 + (unsigned)stops % 2);
        fathom_status status = fathom_session_run(st.context, st.scene, &st.settings, &options, NULL, out);
        if (status == FATHOM_OK) return stops;
        assert_int_equal(status, FATHOM_INTERRUPTED);
        fathom_film_destroy(*out);
        saving.resume = true;
    }
}

/* More samples until it lasts long enough to be stopped. */
static void assert_stops_change_nothing(void) {
    for (int stops = 0; !stops; st.settings.spp *= 2, st.settings.target_error /= 2) {
        fathom_film *whole = stage_render(&st), *resumed;
        stops = render_with_stops(&resumed);
        assert_same(&st, whole, resumed);
        fathom_film_destroy(resumed);
        unlink(in_folder("c"));
    }
}

static void assert_parts_change_nothing(fathom_split split) {
    const char *const paths[] = {in_folder("0"), in_folder("1"), in_folder("2")};
    enum { PARTS = sizeof paths / sizeof *paths };
    fathom_film *whole = stage_render(&st), *merged;
    for (uint32_t i = 0; i < PARTS; ++i) {
        fathom_part part = default_part();
        part.path = paths[i], part.index = i + 1, part.count = PARTS, part.split = split;
        fathom_session_options options = default_session_options();
        options.part = &part;
        assert_ok(st.context,
                  fathom_session_run(st.context, st.scene, &st.settings, &options, NULL, &merged));
        fathom_film_destroy(merged);
    }
    assert_ok(st.context, fathom_parts_merge(st.context, paths, PARTS, NULL, &merged));
    assert_same(&st, whole, merged);
    fathom_film_destroy(merged);
}

static void to_an_error(void) { st.settings.target_error = 0.05, st.settings.spp = 64; }

/* ---- the laws ---- */

UNIT_TEST(stops_change_no_bit_of_even_samples) { assert_stops_change_nothing(); }

UNIT_TEST(stops_change_no_bit_of_samples_to_an_error) {
    to_an_error();
    assert_stops_change_nothing();
}

UNIT_TEST(parts_by_samples_change_no_bit) { assert_parts_change_nothing(FATHOM_SPLIT_SAMPLES); }

UNIT_TEST(parts_by_tiles_change_no_bit) { assert_parts_change_nothing(FATHOM_SPLIT_TILES); }

UNIT_TEST(parts_change_no_bit_of_samples_to_an_error) {
    to_an_error();
    assert_parts_change_nothing(FATHOM_SPLIT_TILES);
}

static void assert_threads_change_nothing(void) {
    fathom_context_set_threads(st.context, 1);
    fathom_film *one = stage_render(&st);
    fathom_context_set_threads(st.context, 3);
    fathom_film *three = stage_render(&st);
    assert_same(&st, one, three);
}

UNIT_TEST(threads_change_no_bit) {
    assert_threads_change_nothing();
    to_an_error();
    assert_threads_change_nothing();
}

static void assert_crop_changes_nothing(void) {
    static const uint32_t crop[4] = {5, 3, 66, 37}, none[4] = {0};
    memcpy(st.settings.crop, none, sizeof none);
    fathom_film *whole = stage_render(&st);
    memcpy(st.settings.crop, crop, sizeof crop);
    fathom_film *part = stage_render(&st);
    assert_same(&st, whole, part);
}

UNIT_TEST(a_crop_changes_no_bit) {
    assert_crop_changes_nothing();
    to_an_error();
    assert_crop_changes_nothing();
}

int main(void) {
    unit_each(set_up, NULL);
    return unit_main(open_folder, remove_folder);
}
