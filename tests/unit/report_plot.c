/* Plots as SVG: where lines and marks come to lie. */
#include "report/plot.h"
#include "unit.h"

static size_t count_of(const char *text, const char *part) {
    size_t count = 0;
    for (; (text = strstr(text, part)); text += strlen(part)) ++count;
    return count;
}

static plot plot_of(const plot_point *points, size_t count, const plot_line *lines, size_t line_count) {
    return (plot){.title = "t",
                  .summary = "s",
                  .caption = "",
                  .width = 500,
                  .height = 300,
                  .x_name = "x",
                  .y_name = "y",
                  .x_log = true,
                  .y_log = true,
                  .y_low = (double)NAN,
                  .y_high = (double)NAN,
                  .points = points,
                  .count = count,
                  .lines = lines,
                  .line_count = line_count};
}

/* The axes hold the line alone, 1 to 100 each way: it goes from corner to corner, 10 pixels from the frame.
 */
static void line(void **state) {
    (void)state;
    const plot_line lines[] = {{1, 100, 100, 1, 1, true}, {1, 0, 100, 1, 2, false}, {1, NAN, 2, 1, 2, false}};
    plot t = plot_of(NULL, 0, lines, 3);
    page p = {.count = 0};
    plot_put(&p, &t);
    assert_false(p.lost);
    page_put(&p, "%c", 0);
    box area = frame_area(t.width, t.height);
    char expected[200];
    snprintf(expected, sizeof expected,
             "<line class=\"interval k1 dashed\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>",
             area.left + 10, area.top + 10, area.right - 10, area.bottom - 10);
    assert_non_null(strstr(p.items, expected));
    assert_int_equal(count_of(p.items, "class=\"interval"), 1); /* no axis has 0 or NaN as an end of a line */
    page_free(&p);
}

static void hollow_points(void **state) {
    (void)state;
    const plot_point points[] = {{.x = 1, .y = 1, .high = NAN, .title = "a", .kind = 0},
                                 {.x = 2, .y = 2, .high = NAN, .title = "b", .kind = 0, .hollow = true},
                                 {.x = NAN, .y = 2, .high = NAN, .title = "c", .kind = 0}};
    plot t = plot_of(points, 3, NULL, 0);
    page p = {.count = 0};
    plot_put(&p, &t);
    assert_false(p.lost);
    page_put(&p, "%c", 0);
    assert_int_equal(count_of(p.items, "class=\"solid k0\""), 1);
    assert_int_equal(count_of(p.items, "class=\"hollow k0\""), 1);
    assert_int_equal(count_of(p.items, "class=\"mark\""), 2);
    assert_non_null(strstr(p.items, "data-marks=\"2\""));
    page_free(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(line), cmocka_unit_test(hollow_points)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
