/* The grid of extreme cases: each gives its rows, nothing is wrong in them, and a tracer with a fault is
 * found. */
#include "verify/extremes/extremes.h"
#include "unit_context.h"

static unsigned group_of(const char *name) {
    for (unsigned g = 0; g < extremes_groups(); ++g) {
        if (strcmp(extremes_name(g), name) == 0) return g;
    }
    fail_msg("there is no group %s", name);
    return 0;
}

static extremes_options asked(const char *const *specs, size_t count, uint64_t rays) {
    return (extremes_options){.specs = specs, .spec_count = count, .rays = rays, .threads = 2};
}

static void run_group(unsigned g, const extremes_options *options, extremes_rows *rows) {
    for (unsigned i = 0; i < extremes_cases(g); ++i)
        assert_ok(context, extremes_run(context, g, i, options, rows));
}

static void check_row(const extremes_row *row) {
    uint64_t sum = 0;
    for (int v = 0; v < VERDICT_COUNT; ++v) sum += row->counts[v];
    assert_true(row->rays > 0 && sum == row->rays);
    assert_true(strlen(row->words) > 8 && strlen(row->words) + 1 < sizeof row->words);
    if (row->counts[VERDICT_WRONG] || row->any_counts[VERDICT_WRONG])
        fail_msg("%s %g, %s: %d wrong, %d of any hit", row->group, row->parameter, row->spec,
                 (int)row->counts[VERDICT_WRONG], (int)row->any_counts[VERDICT_WRONG]);
}

/* Every case, a row for each tracer. The tracers that fathom validates by default, and the one in quadruple
 * precision, have no wrong answer, here with far fewer rays. */
UNIT_TEST(every_case_gives_its_rows) {
    static const char *const specs[] = {"linear:f32", "linear:f64", "bvh",
                                        "bvh:f128",   "embree",     "embree:user"};
    extremes_options options = asked(specs, 6, SANITIZED ? 12 : 36);
    for (unsigned g = 0; g < extremes_groups(); ++g) {
        extremes_rows rows = {.items = NULL};
        run_group(g, &options, &rows);
        assert_int_equal(rows.count, extremes_cases(g) * 6);
        for (size_t i = 0; i < rows.count; ++i) {
            assert_string_equal(rows.items[i].group, extremes_name(g));
            check_row(&rows.items[i]);
        }
        array_free(&rows);
    }
}

/* Hits that lie closer than any normal float: intervals that would end there are none for the tracer, which
 * flushes denormals, and for the oracle alike. */
UNIT_TEST(intervals_below_the_least_float_are_empty_for_all) {
    static const char *const specs[] = {"linear:f64", "bvh"}, *const groups[] = {"size-spheres", "size-quads",
                                                                                 "size-triangles"};
    extremes_options options = asked(specs, 2, 1000);
    for (int k = 0; k < 3; ++k) {
        extremes_rows rows = {.items = NULL};
        unsigned g = group_of(groups[k]);
        assert_ok(context, extremes_run(context, g, 0, &options, &rows));
        assert_true(rows.items[0].parameter < 1e-30);
        for (size_t i = 0; i < rows.count; ++i) check_row(&rows.items[i]);
        array_free(&rows);
    }
}

/* The reference leaks nowhere, and of 10,000 copies the first answers, so there it agrees. */
UNIT_TEST(copies_are_ties) {
    static const char *const specs[] = {"linear:f32", "embree"};
    extremes_options options = asked(specs, 2, 100);
    static const char *const groups[] = {"copies-triangles", "copies-quads", "copies-spheres"};
    for (int k = 0; k < 3; ++k) {
        extremes_rows rows = {.items = NULL};
        unsigned g = group_of(groups[k]);
        assert_ok(context, extremes_run(context, g, extremes_cases(g) - 1, &options, &rows));
        assert_int_equal(rows.count, 2);
        assert_true(rows.items[0].parameter == 10000);
        assert_true(rows.items[0].counts[VERDICT_AGREE] > rows.items[0].rays / 4);
        assert_int_equal(rows.items[0].counts[VERDICT_LEAK], 0);
        array_free(&rows);
    }
}

/* A library with a fault: it takes triangles alone, and is caught where it answers. */
UNIT_TEST(a_faulty_library_is_caught) {
    static const char *const good[] = {PLUGIN_FOLDER "/correct.so"}, *const gap[] = {PLUGIN_FOLDER "/gap.so"},
                             *const culls[] = {PLUGIN_FOLDER "/culls.so"};
    unsigned g = group_of("scale-triangles");
    extremes_options options = asked(good, 1, 300);
    extremes_rows rows = {.items = NULL};
    run_group(g, &options, &rows);
    assert_int_equal(rows.count, extremes_cases(g));
    for (size_t i = 0; i < rows.count; ++i) assert_int_equal(rows.items[i].counts[VERDICT_WRONG], 0);
    rows.count = 0;
    options.specs = culls;
    run_group(g, &options, &rows);
    for (size_t i = 0; i < rows.count; ++i) assert_true(rows.items[i].counts[VERDICT_WRONG] > 20);
    rows.count = 0;
    options.specs = gap, options.rays = 3000;
    assert_ok(context, extremes_run(context, g, 8, &options, &rows));
    assert_true(rows.items[0].counts[VERDICT_WRONG] > 0);
    rows.count = 0;
    run_group(group_of("scale-spheres"), &options, &rows);
    assert_int_equal(rows.count, 0);
    array_free(&rows);
}

UNIT_TEST(no_number_depends_on_the_threads) {
    static const char *const specs[] = {"embree:user"};
    extremes_options options = asked(specs, 1, 2000);
    extremes_rows rows = {.items = NULL};
    unsigned g = group_of("tangent");
    options.threads = 1;
    run_group(g, &options, &rows);
    options.threads = 3;
    run_group(g, &options, &rows);
    for (unsigned i = 0; i < extremes_cases(g); ++i) {
        const extremes_row *a = &rows.items[i], *b = &rows.items[i + extremes_cases(g)];
        assert_memory_equal(a->counts, b->counts, sizeof a->counts);
        assert_true(a->constant == b->constant);
    }
    array_free(&rows);
}

static bool stop(void *user, uint64_t rays) {
    (void)user;
    (void)rays;
    return false;
}

UNIT_TEST(a_run_can_be_stopped) {
    static const char *const specs[] = {"linear:f32", "bvh"};
    extremes_options options = asked(specs, 2, 200);
    options.progress = stop;
    extremes_rows rows = {.items = NULL};
    assert_int_equal(extremes_run(context, 0, 0, &options, &rows), FATHOM_INTERRUPTED);
    assert_int_equal(rows.count, 1);
    array_free(&rows);
}

int main(void) { return unit_main(open_context, NULL); }
