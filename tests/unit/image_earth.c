/* A scene at the Earth's radius looks as at the origin. */
#include "unit.h"
#include "verify/light/shading.h"

UNIT_TEST(moved_scene) {
    fathom_context *context;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    const shading_options options = {.spec = "embree"};
    shading_rows rows = {.items = NULL};
    assert_ok(context, shading_earth(context, &options, &rows));
    assert_int_equal(rows.count, 4);
    for (size_t i = 0; i < rows.count; ++i) {
        if (!rows.items[i].ok) fail_msg("%s: %g", rows.items[i].what, rows.items[i].error);
        assert_near(rows.items[i].bound, 1e-3, 0);
    }
    array_free(&rows);
    fathom_context_destroy(context);
}

/* Another field of view by a ten-thousandth is another image. */
UNIT_TEST(another_view) {
    fathom_context *context;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    const shading_options options = {.spec = "embree", .twist = 1e-4};
    shading_rows rows = {.items = NULL};
    assert_ok(context, shading_earth(context, &options, &rows));
    assert_int_equal(rows.count, 4);
    for (size_t i = 0; i < rows.count; ++i) assert_false(rows.items[i].ok);
    array_free(&rows);
    fathom_context_destroy(context);
}

int main(void) { return unit_main(NULL, NULL); }
