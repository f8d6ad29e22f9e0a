/* Labels of plots: none on another, nor on a mark. */
#include "random.h"
#include "report/place.h"
#include "unit.h"

static const box area = {60, 10, 460, 330};

static bool inside(const box *b) {
    return b->left >= area.left && b->right <= area.right && b->top >= area.top && b->bottom <= area.bottom;
}

/* Returns how many were placed. */
static size_t check(const label *labels, size_t count, const box *taken, size_t taken_count) {
    size_t placed = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!labels[i].placed) continue;
        ++placed;
        assert_true(inside(&labels[i].at));
        for (size_t k = 0; k < taken_count; ++k) assert_false(box_overlap(&labels[i].at, &taken[k]));
        for (size_t k = 0; k < i; ++k)
            assert_false(labels[k].placed && box_overlap(&labels[i].at, &labels[k].at));
    }
    return placed;
}

/* Pairs of a label's line and another label that it runs through. */
static size_t count_crossed(const label *labels, size_t count) {
    size_t crossed = 0;
    for (size_t i = 0; i < count; ++i) {
        double x, y;
        label_leader(&labels[i], &x, &y);
        for (size_t k = 0; k < count && labels[i].far; ++k)
            crossed += k != i && box_meets_line(&labels[k].at, labels[i].x, labels[i].y, x, y);
    }
    return crossed;
}

static void set(label *l, box *taken, double x, double y) {
    *l = (label){.x = x, .y = y, .width = 90, .height = 15};
    *taken = (box){x - 6, y - 6, x + 6, y + 6};
}

#define LABELS 16 /* as many tracers as a command takes */

static void test_labels_of_spread_points(void **state) {
    (void)state;
    random_state r = {3};
    size_t crossed = 0;
    for (int round = 0; round < 50; ++round) {
        label labels[LABELS];
        box taken[LABELS];
        for (size_t i = 0; i < LABELS; ++i)
            set(&labels[i], &taken[i], 70 + 380 * random_unit(&r), 20 + 300 * random_unit(&r));
        place_labels(labels, LABELS, taken, LABELS, &area);
        assert_int_equal(check(labels, LABELS, taken, LABELS), LABELS);
        crossed += count_crossed(labels, LABELS);
    }
    /* Rare, though these are more labels than a plot of this size holds well; without regard to lines six are
     * crossed. */
    assert_true(crossed < 4);
}

/* All in one corner: every label is away from its point, and still each has a place. */
static void test_labels_of_a_heap(void **state) {
    (void)state;
    label labels[LABELS];
    box taken[LABELS];
    for (size_t i = 0; i < LABELS; ++i)
        set(&labels[i], &taken[i], 80 + 2.0 * (double)(i % 4), 30 + (double)i);
    place_labels(labels, LABELS, taken, LABELS, &area);
    assert_int_equal(check(labels, LABELS, taken, LABELS), LABELS);
}

/* One point's label stands to its right; more labels than there is room for are left out, not put on others.
 */
static void test_one_and_too_many(void **state) {
    (void)state;
    label labels[PLACE_LABELS + 1];
    box taken[PLACE_LABELS + 1];
    set(&labels[0], &taken[0], 200, 100);
    place_labels(labels, 1, taken, 1, &area);
    assert_true(labels[0].placed && !labels[0].far && labels[0].at.left > 206);
    for (size_t i = 0; i <= PLACE_LABELS; ++i) {
        set(&labels[i], &taken[i], 100, 100);
        labels[i].width = 190, labels[i].height = 40;
    }
    place_labels(labels, PLACE_LABELS + 1, taken, PLACE_LABELS + 1, &area);
    size_t placed = check(labels, PLACE_LABELS + 1, taken, PLACE_LABELS + 1);
    assert_true(placed > 2 && placed < 17); /* two beside each other, eight on top of each other */
}

static void test_lines(void **state) {
    (void)state;
    box b = {10, 10, 20, 20};
    assert_true(box_meets_line(&b, 0, 15, 30, 15));
    assert_true(box_meets_line(&b, 15, 0, 15, 30));
    assert_true(box_meets_line(&b, 0, 0, 30, 30));
    assert_true(box_meets_line(&b, 15, 15, 15.5, 15));
    assert_false(box_meets_line(&b, 0, 15, 9, 15));
    assert_false(box_meets_line(&b, 0, 9, 30, 9));
    assert_false(box_meets_line(&b, 0, 15, 15, 40));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_labels_of_spread_points),
        cmocka_unit_test(test_labels_of_a_heap),
        cmocka_unit_test(test_one_and_too_many),
        cmocka_unit_test(test_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
