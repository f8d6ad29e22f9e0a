/* Shading where it is stiff: each case within its bound, and each case able to fail. */
#include "unit_context.h"
#include "verify/light/shading_studio.h"

static shading_rows run(const char *spec, double twist) {
    const shading_options options = {.spec = spec, .twist = twist};
    shading_rows rows = {.items = NULL};
    assert_ok(context, shading_run(context, &options, &rows));
    return rows;
}

UNIT_TEST(all_within_bounds) {
    static const char *const specs[] = {"embree", "reference", "bvh:f64"};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        shading_rows rows = run(specs[k], 0);
        assert_true(rows.count > 150);
        for (size_t i = 0; i < rows.count; ++i) {
            const shading_row *r = &rows.items[i];
            if (!r->ok)
                fail_msg("%s: %s, by %s: %.9g, expected %.9g within %g", r->group, r->what, r->spec,
                         r->measured, r->expected, r->bound);
            assert_true(r->error <= r->bound);
            assert_string_equal(r->spec, specs[k]);
        }
        array_free(&rows);
    }
}

/* Cases whose answer does not depend on the parameter that is twisted, or only by less than float can tell.
 */
static bool indifferent(const shading_row *r) {
    const char *group = r->group;
    double p = r->parameter;
    /* One bounce or two are made whatever the gap. */
    if (strcmp(group, "mirror depth") == 0) return p <= 1;
    /* All is mirrored below, next to all above, and what goes in goes straight. */
    if (strcmp(group, "fresnel") == 0) return p < 0.01 || p > 1e6;
    if (strcmp(group, "ior extreme") == 0) return p < 1e-5 || p > 1e3;
    /* One pixel of the wide view is the peak, the others are black. */
    if (strcmp(group, "phong") == 0 || strcmp(group, "blinn") == 0)
        return p >= 1e6 && strstr(r->what, "over 1 rad");
    /* Black from any angle. */
    if (strcmp(group, "light on surface") == 0) return p <= 0;
    /* At the limit. */
    if (strcmp(group, "light intensity") == 0 || strcmp(group, "mirror gain") == 0) return p > 1e37;
    /* Lit up to the horizon; and an axis that float cannot aim. */
    if (strcmp(group, "spot") == 0)
        return (p > 1.5 && strstr(r->what, "hard")) || (p < 1e-5 && strstr(r->what, "tilted"));
    return false;
}

/* A mutant of each law: the formula's parameter off by a twentieth either way, or by a third. */
UNIT_TEST(each_case_can_fail) {
    static const double twists[] = {0.05, -0.05, 0.3};
    shading_rows rows[3];
    for (int k = 0; k < 3; ++k) rows[k] = run("embree", twists[k]);
    for (size_t i = 0; i < rows[0].count; ++i) {
        const shading_row *r = &rows[0].items[i];
        bool seen = !r->ok || !rows[1].items[i].ok || !rows[2].items[i].ok;
        if (!seen && !indifferent(r)) fail_msg("%s: %s does not tell laws apart", r->group, r->what);
    }
    for (int k = 0; k < 3; ++k) array_free(&rows[k]);
}

/* The same figures each time. */
UNIT_TEST(same_twice) {
    shading_rows a = run("embree", 0), b = run("embree", 0);
    assert_int_equal(a.count, b.count);
    for (size_t i = 0; i < a.count; ++i) {
        assert_string_equal(a.items[i].what, b.items[i].what);
        assert_true(a.items[i].measured == b.items[i].measured);
    }
    array_free(&a);
    array_free(&b);
}

/* What is not a number, what is in nobody's bound, and what nobody judged are wrong. */
UNIT_TEST(what_is_wrong) {
    const struct {
        double measured, expected, bound;
        uint64_t broken;
        bool ok;
    } cases[] = {{1, 1, 0, 0, true},           {1.5, 1, 0.5, 0, true},        {1.5, 1, 0.4, 0, false},
                 {1.5, 1, 0, 0, false},        {(double)NAN, 1, 1, 0, false}, {1, 1, 0, 1, false},
                 {1, 1, (double)NAN, 0, false}};
    const shading_options options = {.spec = "embree"};
    shading_rows rows = {.items = NULL};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        studio s = {.b = {.context = context}, .options = &options, .rows = &rows, .broken = cases[i].broken};
        studio_judge(&s, 0, 2, 2, 0.5);
        studio_judge(&s, 0, cases[i].measured, cases[i].expected, cases[i].bound);
        studio_judge(&s, 0, 2, 2, 0.5);
        studio_row(&s, 0, "group", 1, "case %zu", i);
        assert_int_equal(rows.items[i].ok, cases[i].ok);
    }
    studio s = {.b = {.context = context}, .options = &options, .rows = &rows};
    studio_row(&s, 0, "group", 1, "nothing judged");
    assert_false(rows.items[rows.count - 1].ok);
    array_free(&rows);
}

int main(void) { return unit_main(open_context, NULL); }
