/* Tracers by name: what is understood, what is refused, and what there is. */
#include "trace/spec.h"
#include "unit.h"

static fathom_context *context;

static int open_context(void **state) {
    (void)state;
    return fathom_context_create(&context) == FATHOM_OK ? 0 : -1;
}
static int close_context(void **state) {
    (void)state;
    fathom_context_destroy(context);
    return 0;
}

static void prints(const char *text, const char *expected) {
    trace_spec spec;
    char out[TRACE_SPEC_LENGTH];
    assert_ok(context, trace_spec_parse(context, text, &spec));
    trace_spec_print(&spec, out);
    assert_string_equal(out, expected);
}

static void options_in_any_order(void **state) {
    (void)state;
    prints("linear", "linear:robust:f32");
    prints("reference", "linear:robust:f32");
    prints("linear:textbook:f64", "linear:textbook:f64");
    prints("linear:f128:robust", "linear:robust:f128");
    prints("bvh", "bvh:robust:f32");
    prints("bvh:f64", "bvh:robust:f64");
    prints("embree", "embree:triangles:robust:auto:settled");
    prints("embree:16:high:user:default:raw", "embree:user:default:high:16:raw");
    prints("embree:quad:compact:avx2", "embree:quad:compact:auto:settled:avx2");
    prints("embree:sphere:1", "embree:sphere:robust:auto:1:settled");
    prints("./mine.so", "./mine.so");
}

static void refuses(const char *text, const char *message) {
    trace_spec spec;
    assert_fails(context, trace_spec_parse(context, text, &spec), FATHOM_BAD_USAGE, message);
}

static void wrong_words_are_told(void **state) {
    (void)state;
    refuses("optix",
            "no tracer is called \"optix\"; expected reference, a shared library FILE.so, linear (options "
            "robust, textbook; f32, f64, f128), bvh (robust; f32, f64, f128) or embree (triangles, ");
    refuses("optix", ", such as embree:user:high, found \"optix\"");
    refuses("", "is called \"\"");
    refuses("lin", "is called \"lin\"");
    refuses("lin:f32", "is called \"lin\"");
    refuses("linear:", "have no option \"\"");
    refuses("linear:f16",
            "have no option \"f16\"; expected robust, textbook; f32, f64, f128, found \"linear:f16\"");
    refuses("linear:f32:f64", "\"f32\" and \"f64\" exclude each other, found \"linear:f32:f64\"");
    refuses("linear:f32:f32", "\"f32\" and \"f32\" exclude each other");
    refuses("bvh:textbook", "have no option \"textbook\"");
    refuses("embree:f64", "have no option \"f64\"");
    refuses("embree:compact:robust", "never return");
    refuses("embree:16:8", "exclude each other");
    refuses("embree:32", "have no option \"32\"");
}

typedef struct counted {
    size_t all, kinds[4];
    size_t stop_at;
} counted;

/* What is listed can be said and is understood as what it is. */
static bool count(void *user, const trace_spec *spec) {
    counted *c = user;
    char text[TRACE_SPEC_LENGTH], again[TRACE_SPEC_LENGTH];
    trace_spec read;
    trace_spec_print(spec, text);
    assert_ok(context, trace_spec_parse(context, text, &read));
    trace_spec_print(&read, again);
    assert_string_equal(text, again);
    ++c->kinds[spec->kind];
    return ++c->all != c->stop_at;
}

static void all_are_listed(void **state) {
    (void)state;
    counted all = {0}, some = {.stop_at = 5};
    trace_spec_list(count, &all);
    assert_int_equal(all.kinds[TRACE_LINEAR], 2 * 3);
    assert_int_equal(all.kinds[TRACE_BVH], 3);
    /* Shapes, flags, qualities, widths, ties. */
    assert_int_equal(all.kinds[TRACE_EMBREE], 4 * 3 * 3 * 4 * 2);
    trace_spec_list(count, &some);
    assert_int_equal(some.all, 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_in_any_order),
        cmocka_unit_test(wrong_words_are_told),
        cmocka_unit_test(all_are_listed),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
