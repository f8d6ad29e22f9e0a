/* Polygons into triangles: as many as there should be, all turning the polygon's way, covering its area. */
#include "read/mesh/polygon.h"

#include "random.h"
#include "unit.h"

#define CORNERS 64

static void write_fan(uint32_t n, uint32_t *fan) {
    for (uint32_t i = 2; i < n; ++i) {
        fan[3 * (i - 2)] = 0;
        fan[3 * (i - 2) + 1] = i - 1;
        fan[3 * (i - 2) + 2] = i;
    }
}

/* Twice the area seen along +z. */
static double area(const float (*p)[3], uint32_t a, uint32_t b, uint32_t c) {
    return ((double)p[b][0] - (double)p[a][0]) * ((double)p[c][1] - (double)p[a][1]) -
           ((double)p[b][1] - (double)p[a][1]) * ((double)p[c][0] - (double)p[a][0]);
}

static void split(const float (*p)[3], uint32_t n, uint32_t *fan) {
    polygon_work work = {0};
    const polygon_vertices vertices = {&p[0][0], sizeof *p};
    write_fan(n, fan);
    assert_true(polygon_split(&work, &vertices, n, fan, NULL, NULL));
    polygon_work_free(&work);
}

/* The polygon goes counterclockwise seen from +z. Triangles that all turn its way and sum to its area neither
 * overlap nor leave it. Coordinates are multiples of 2^-12 below 2^4: areas are exact in double. */
static void expect_cover(const float (*p)[3], uint32_t n, const uint32_t *fan) {
    double whole = 0, sum = 0;
    for (uint32_t i = 2; i < n; ++i) whole += area(p, 0, i - 1, i);
    for (uint32_t t = 0; t < n - 2; ++t) {
        double part = area(p, fan[3 * t], fan[3 * t + 1], fan[3 * t + 2]);
        if (part < 0) fail_msg("triangle %u of %u corners turns the other way: %g", t, n, part);
        sum += part;
    }
    if (sum != whole) fail_msg("%u corners: area %.17g, expected %.17g", n, sum, whole);
}

/* Each edge of the outline is in one triangle, each inner one in two, once each way. */
static void expect_closed(uint32_t n, const uint32_t *fan) {
    static int uses[CORNERS][CORNERS];
    memset(uses, 0, sizeof uses);
    for (uint32_t t = 0; t < n - 2; ++t) {
        for (uint32_t k = 0; k < 3; ++k) ++uses[fan[3 * t + k]][fan[3 * t + (k + 1) % 3]];
    }
    for (uint32_t a = 0; a < n; ++a) {
        for (uint32_t b = 0; b < n; ++b) {
            bool outline = b == (a + 1) % n, back = a == (b + 1) % n;
            assert_int_equal(uses[a][b], outline ? 1 : back ? 0 : uses[b][a]);
        }
    }
}

static float grid(double x) { return (float)(round(x * 4096) / 4096); }

/* Star-shaped around the origin with random radii, in all planes and both ways round. */
UNIT_TEST(stars_are_covered_exactly) {
    random_state random = {1};
    for (int round = 0; round < 3000; ++round) {
        uint32_t n = 4 + (uint32_t)(random_bits(&random) % (CORNERS - 4)), fan[3 * CORNERS];
        float p[CORNERS][3], turned[CORNERS][3];
        for (uint32_t i = 0; i < n; ++i) {
            double angle = 6.283185307179586 * i / n, radius = random_in(&random, 0.5, 8);
            p[i][0] = grid(radius * cos(angle));
            p[i][1] = grid(radius * sin(angle));
            p[i][2] = 0;
        }
        int axis = round % 3;
        for (uint32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) turned[i][(k + axis) % 3] = p[i][k];
        }
        split(turned, n, fan);
        expect_cover(p, n, fan);
        expect_closed(n, fan);
    }
}

/* The same outline run the other way comes out turned the other way. */
UNIT_TEST(clockwise_polygons_keep_their_winding) {
    const float p[6][3] = {{0, 0, 0}, {0, 2, 0}, {1, 2, 0}, {1, 1, 0}, {2, 1, 0}, {2, 0, 0}};
    const float mirrored[6][3] = {{0, 0, 0}, {0, -2, 0}, {1, -2, 0}, {1, -1, 0}, {2, -1, 0}, {2, 0, 0}};
    uint32_t fan[12];
    split(p, 6, fan);
    expect_cover(mirrored, 6, fan);
    expect_closed(6, fan);
}

/* Where every corner is a place that a fan, or a careless ear, goes wrong. */
UNIT_TEST(hard_outlines_are_covered_exactly) {
    const struct {
        uint32_t n;
        float p[16][3];
    } outlines[] = {
        /* A comb. */
        {12,
         {{0, 0, 0},
          {7, 0, 0},
          {7, 4, 0},
          {6, 4, 0},
          {6, 1, 0},
          {4, 1, 0},
          {4, 4, 0},
          {3, 4, 0},
          {3, 1, 0},
          {1, 1, 0},
          {1, 4, 0},
          {0, 4, 0}}},
        /* A square with corners in the middle of its edges. */
        {8, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}}},
        /* A square with a square hole, joined by an edge that is run both ways. */
        {10,
         {{0, 0, 0},
          {3, 0, 0},
          {3, 3, 0},
          {0, 3, 0},
          {0, 0, 0},
          {1, 1, 0},
          {1, 2, 0},
          {2, 2, 0},
          {2, 1, 0},
          {1, 1, 0}}},
        /* A spiral corridor. */
        {16,
         {{0, 0, 0},
          {7, 0, 0},
          {7, 7, 0},
          {1, 7, 0},
          {1, 2, 0},
          {5, 2, 0},
          {5, 5, 0},
          {3, 5, 0},
          {3, 4, 0},
          {4, 4, 0},
          {4, 3, 0},
          {2, 3, 0},
          {2, 6, 0},
          {6, 6, 0},
          {6, 1, 0},
          {0, 1, 0}}},
        /* Corners one on top of the other. */
        {7, {{0, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5f, 0}, {0, 2, 0}, {0, 2, 0}}},
    };
    for (size_t i = 0; i < sizeof outlines / sizeof *outlines; ++i) {
        uint32_t fan[3 * 16];
        split(outlines[i].p, outlines[i].n, fan);
        expect_cover(outlines[i].p, outlines[i].n, fan);
        expect_closed(outlines[i].n, fan);
    }
}

/* An outline that crosses itself has no triangulation; what comes back has the right size and corners. */
UNIT_TEST(crossed_outlines_give_all_triangles) {
    random_state random = {5};
    for (int round = 0; round < 500; ++round) {
        uint32_t n = 4 + (uint32_t)(random_bits(&random) % 20), fan[3 * CORNERS];
        float p[CORNERS][3];
        for (uint32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) p[i][k] = grid(round % 5 ? random_in(&random, -1, 1) : 0);
        }
        split(p, n, fan);
        for (uint32_t i = 0; i < 3 * (n - 2); ++i) assert_true(fan[i] < n);
    }
}

/* A concave quad is cut at its reflex corner, wherever that is; a convex one along the diagonal that leaves
 * the larger smallest angle; a rectangle along 0-2, however its corners are rounded. */
UNIT_TEST(quads_split_along_the_better_diagonal) {
    const float dart[4][3] = {{0, 0, 0}, {2, -1, 0}, {0.5f, 0, 0}, {2, 1, 0}};
    const float kite[4][3] = {{-4, 0, 0}, {0, -1, 0}, {4, 0, 0}, {0, 1, 0}};
    for (uint32_t turn = 0; turn < 4; ++turn) {
        float p[4][3];
        uint32_t fan[6];
        for (uint32_t i = 0; i < 4; ++i) memcpy(p[i], dart[(i + turn) % 4], sizeof p[i]);
        /* The dart runs clockwise at its reflex corner only: seen from +z it goes 0, 3, 2, 1. */
        split(p, 4, fan);
        double first = area(p, fan[0], fan[1], fan[2]), second = area(p, fan[3], fan[4], fan[5]);
        assert_true(first * second > 0);
        for (uint32_t i = 0; i < 4; ++i) memcpy(p[i], kite[(i + turn) % 4], sizeof p[i]);
        split(p, 4, fan);
        expect_cover(p, 4, fan);
        /* The short diagonal joins kite corners 1 and 3. */
        uint32_t one = (1 + 4 - turn) % 4, three = (3 + 4 - turn) % 4;
        int ends = 0;
        for (int i = 0; i < 6; ++i) ends += fan[i] == one || fan[i] == three;
        assert_int_equal(ends, 4);
    }
    random_state random = {3};
    for (int round = 0; round < 1000; ++round) {
        float x = (float)random_in(&random, 1, 2), y = (float)random_in(&random, 1, 2), w = 0.001f;
        const float p[4][3] = {{x, y, 1}, {x + w, y, 1}, {x + w, y + w, 1}, {x, y + w, 1}};
        uint32_t fan[6];
        split(p, 4, fan);
        const uint32_t expected[6] = {0, 1, 2, 0, 2, 3};
        assert_memory_equal(fan, expected, sizeof fan);
    }
}

/* Other streams go along corner by corner. */
UNIT_TEST(other_streams_move_along) {
    const float p[6][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    const float quad[4][3] = {{0, 0, 0}, {2, -1, 0}, {0.5f, 0, 0}, {2, 1, 0}};
    uint32_t fan[12], second[12], third[12];
    polygon_work work = {0};
    for (uint32_t n = 4; n <= 6; n += 2) {
        const polygon_vertices vertices = {n == 4 ? quad[0] : p[0], sizeof p[0]};
        write_fan(n, fan);
        for (size_t i = 0; i < 3 * (n - 2); ++i) second[i] = fan[i] + 100, third[i] = fan[i] * 7;
        assert_true(polygon_split(&work, &vertices, n, fan, second, third));
        for (size_t i = 0; i < 3 * (n - 2); ++i) {
            assert_int_equal(second[i], fan[i] + 100);
            assert_int_equal(third[i], fan[i] * 7);
        }
    }
    polygon_work_free(&work);
}

/* A saw of 100,000 teeth, the handle far away: work that grew with the square of the corners would take
 * minutes. */
UNIT_TEST(many_corners_are_triangulated) {
    const uint32_t teeth = 100000, n = 2 * teeth + 1;
    float(*p)[3] = unit_memory(n * sizeof *p);
    uint32_t *fan = unit_memory(3 * (size_t)n * sizeof *fan);
    assert_true(p && fan);
    for (uint32_t i = 0; i + 1 < n; ++i) {
        p[i][0] = (float)i;
        p[i][1] = i % 2 ? 1 : 2;
    }
    p[n - 1][0] = (float)teeth, p[n - 1][1] = 0x1p18f;
    split((const float(*)[3])p, n, fan);
    expect_cover((const float(*)[3])p, n, fan);
}

/* Long ears that many corners could lie in, and outlines that cross themselves everywhere: the time does not
 * grow with the square of the corners, or this test would not end. */
UNIT_TEST(many_reflex_corners_are_triangulated) {
    const uint32_t n = 200000;
    float(*p)[3] = unit_memory(n * sizeof *p);
    uint32_t *fan = unit_memory(3 * (size_t)n * sizeof *fan);
    random_state random = {3};
    assert_true(p && fan);
    for (int star = 0; star < 2; ++star) {
        for (uint32_t i = 0; i < n; ++i) {
            double turn = 6.283185307179586 * i / n, radius = 1 + random_unit(&random);
            p[i][0] = (float)(star ? radius * cos(turn) : radius);
            p[i][1] = (float)(star ? radius * sin(turn) : random_unit(&random));
        }
        split((const float(*)[3])p, n, fan);
    }
    /* The star is simple: all its triangles turn as it does. */
    for (uint32_t t = 0; t < n - 2; ++t)
        assert_true(area((const float(*)[3])p, fan[3 * t], fan[3 * t + 1], fan[3 * t + 2]) >= 0);
}

int main(void) { return unit_main(NULL, NULL); }
