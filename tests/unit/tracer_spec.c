/* Tracers by name: what is understood, what is refused, and what there is. */
#include "trace/spec.h"
#include "unit_context.h"

/* Another spelling of the same tracer. */
static void is_alike(const char *text, const char *full) {
    trace_spec a, b;
    assert_ok(context, trace_spec_parse(context, text, &a));
    assert_ok(context, trace_spec_parse(context, full, &b));
    assert_int_equal(a.kind, b.kind);
    assert_int_equal(a.precision, b.precision);
    assert_int_equal(a.shapes, b.shapes);
    assert_int_equal(a.flags, b.flags);
    assert_int_equal(a.quality, b.quality);
    assert_int_equal(a.calls, b.calls);
    assert_int_equal(a.ties, b.ties);
    assert_int_equal(a.isa, b.isa);
}

UNIT_TEST(options_in_any_order) {
    is_alike("linear", "linear:f32");
    is_alike("reference", "linear:f32");
    is_alike("bvh", "bvh:f32");
    is_alike("embree", "embree:triangles:robust:auto:settled");
    is_alike("embree:16:high:user:default:raw", "embree:user:default:high:16:raw");
    is_alike("embree:compact:avx2", "embree:triangles:compact:auto:settled:avx2");
    trace_spec spec;
    assert_ok(context, trace_spec_parse(context, "embree:16:user:raw", &spec));
    assert_int_equal(spec.kind, TRACE_EMBREE);
    assert_int_equal(spec.calls, TRACE_CALLS_16);
    assert_int_equal(spec.shapes, TRACE_SHAPES_USER);
    assert_int_equal(spec.ties, TRACE_RAW);
    assert_ok(context, trace_spec_parse(context, "./mine.so", &spec));
    assert_int_equal(spec.kind, TRACE_PLUGIN);
    assert_string_equal(spec.path, "./mine.so");
}

static void refuses(const char *text, const char *message) {
    trace_spec spec;
    assert_fails(context, trace_spec_parse(context, text, &spec), FATHOM_BAD_USAGE, message);
}

UNIT_TEST(wrong_words_are_told) {
    refuses("optix",
            "no tracer is called \"optix\"; expected reference, a shared library FILE.so, linear (options "
            "f32, f64, f128), bvh (f32, f64, f128) or embree (triangles, ");
    refuses("", "is called \"\"");
    refuses("lin", "is called \"lin\"");
    refuses("lin:f32", "is called \"lin\"");
    refuses("linear:", "have no option \"\"");
    refuses("linear:f16", "have no option \"f16\"; expected f32, f64, f128, found \"linear:f16\"");
    refuses("linear:f32:f64", "\"f32\" and \"f64\" exclude each other, found \"linear:f32:f64\"");
    refuses("linear:f32:f32", "\"f32\" and \"f32\" exclude each other");
    refuses("bvh:robust", "have no option \"robust\"");
    refuses("embree:f64", "have no option \"f64\"");
    refuses("embree:compact:robust", "never return");
    refuses("embree:16:8", "exclude each other");
    refuses("embree:32", "have no option \"32\"");
}

int main(void) { return unit_main(open_context, NULL); }
