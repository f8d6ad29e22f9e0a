/* Spheres against quadruple precision, for the same float or double input. */
#include "random.h"
#include "textbook.h"
#include "trace/trace.h"
#include "unit.h"

#include <float.h>

/* What there is to know about the line and the sphere, all but exact. */
typedef struct sphere_truth {
    real_f128 f, l, d;       /* lengths of E-C, its rejection on d, d */
    real_f128 D;             /* R² - l² */
    real_f128 s, q[2], t[2]; /* √(a D); b ∓ s; the roots */
} sphere_truth;

static sphere_truth truth_of(vec3_f64 center, double radius, vec3_f64 org, vec3_f64 dir) {
    sphere_truth truth = {0};
    vec3_f128 d = quadruple_f64(dir), f = sub_f128(quadruple_f64(org), quadruple_f64(center));
    real_f128 a = dot_f128(d, d), b = -dot_f128(f, d), r = radius;
    vec3_f128 l = madd_f128(f, b / a, d);
    truth.f = length_f128(f), truth.l = length_f128(l), truth.d = length_f128(d);
    truth.D = (r - truth.l) * (r + truth.l);
    if (truth.D < 0) return truth;
    truth.s = sqrt_f128(a * truth.D);
    truth.q[0] = b - truth.s, truth.q[1] = b + truth.s;
    bool sure;
    sphere_plain_f128(quadruple_f64(center), r, quadruple_f64(org), d, truth.t, &sure);
    return truth;
}

/* How far the root may be off where the unit roundoff is u: with sphere_text.h, b by 5 u |f||d|, D by
 * 20 u |f| l + 5 u (R² + l²), s by half D's relative error and 3 u, c by 54 u of itself; and a quotient. The
 * root is q/a or c/q', so |δt/t| ≤ |δq/q| + 60 u, with the q of larger size. First-order: doubled. */
static double root_tolerance(const sphere_truth *truth, int root, double radius, double u) {
    double f = (double)truth->f, l = (double)truth->l, D = (double)truth->D, s = (double)truth->s;
    double dD = 20 * u * f * l + 5 * u * (radius * radius + l * l);
    double ds = D > 0 ? s * (dD / (2 * D) + 3 * u) : (double)INFINITY;
    double big = fmax(fabs((double)truth->q[0]), fabs((double)truth->q[1]));
    return 2 * fabs((double)truth->t[root]) * ((5 * u * f * (double)truth->d + ds) / big + 60 * u);
}

typedef struct sphere_case {
    vec3_f32 center, org, dir;
    float radius;
} sphere_case;

/* A ray that passes the centre at `aim` radii, from `distance` away. */
static sphere_case aimed(random_state *r, double radius, double distance, double aim, double length) {
    vec3_f64 away = scale_f64(distance, random_direction(r)), side = cross_f64(away, random_direction(r));
    vec3_f64 target = scale_f64(aim * radius / length_f64(side), side);
    vec3_f64 center = scale_f64(random_in(r, 0, 1) * fmax(radius, distance), random_direction(r));
    vec3_f64 dir = sub_f64(target, away);
    sphere_case c = {narrow(center), narrow(add_f64(center, away)),
                     narrow(scale_f64(length / length_f64(dir), dir)), (float)radius};
    return c;
}

static sphere_truth truth_of_case(const sphere_case *c) {
    return truth_of(widen(c->center), (double)c->radius, widen(c->org), widen(c->dir));
}

/* Where the wider precision (unit roundoff u) cannot tell hit from miss: 36 u |f| √(R² + l²) from
 * sphere_text.h. */
static bool in_band(const sphere_truth *truth, double radius, double u) {
    double f = (double)truth->f, l = (double)truth->l;
    return fabs((double)truth->D) <= 36 * u * f * hypot(radius, l);
}

static void check_f32(const sphere_case *c, const sphere_truth *truth) {
    float t = NAN;
    bool hit = sphere_robust_f32(c->center, c->radius, c->org, c->dir, 0, INFINITY, &t);
    if (in_band(truth, (double)c->radius, 0x1p-53)) return;
    bool meets = truth->D >= 0 && truth->t[1] > 0;
    assert_int_equal(hit, meets);
    if (!hit) return;
    int root = truth->t[0] > 0 ? 0 : 1;
    assert_near(t, truth->t[root], root_tolerance(truth, root, (double)c->radius, 0x1p-24));
}

static void check_f64(const sphere_case *c, const sphere_truth *truth) {
    double t = (double)NAN;
    bool hit =
        sphere_robust_f64(widen(c->center), (double)c->radius, widen(c->org), widen(c->dir), 0, INFINITY, &t);
    bool meets = truth->D >= 0 && truth->t[1] > 0;
    assert_int_equal(hit, meets);
    if (!hit) return;
    int root = truth->t[0] > 0 ? 0 : 1;
    assert_near(t, truth->t[root], root_tolerance(truth, root, (double)c->radius, 0x1p-53));
}

UNIT_TEST(robust_is_right_at_any_ratio) {
    random_state r = {1};
    for (int i = 0; i < 60000; ++i) {
        double radius = random_log(&r, 1e-3, 1e3), distance = radius * random_log(&r, 1e-5, 1e5);
        double aim = i % 2 ? random_in(&r, 0, 2) : 1 + random_in(&r, -1, 1) * random_log(&r, 1e-7, 1e-1);
        sphere_case c = aimed(&r, radius, distance, aim, random_log(&r, 1e-3, 1e3));
        sphere_truth truth = truth_of_case(&c);
        check_f32(&c, &truth);
        check_f64(&c, &truth);
    }
}

UNIT_TEST(robust_is_right_at_any_size) {
    random_state r = {2};
    for (int i = 0; i < 20000; ++i) {
        /* t = distance / length stays within float's range. */
        double radius = random_log(&r, 1e-18, 1e18), distance = random_log(&r, 1e-18, 1e18);
        sphere_case c = aimed(&r, radius, distance, random_in(&r, 0, 1.5), random_log(&r, 1e-18, 1e18));
        sphere_truth truth = truth_of_case(&c);
        if (truth.D >= 0 && fabs((double)truth.t[0]) < 1e-36) continue;
        check_f32(&c, &truth);
        check_f64(&c, &truth);
    }
}

/* Fractions of wrong answers among rays that pass within a tenth of a radius of the silhouette. */
UNIT_TEST(textbook_loses_what_robust_keeps) {
    random_state r = {3};
    const int rays = 100000;
    int textbook = 0, plain = 0, robust = 0;
    for (int i = 0; i < rays; ++i) {
        sphere_case c = aimed(&r, 1, 1e3, random_in(&r, 0.9, 1.1), 1);
        sphere_truth truth = truth_of_case(&c);
        bool meets = truth.D >= 0, sure;
        float t = NAN, roots[2];
        textbook += meets != sphere_textbook_f32(c.center, c.radius, c.org, c.dir, 0, INFINITY, &t);
        plain += meets != sphere_plain_f32(c.center, c.radius, c.org, c.dir, roots, &sure);
        robust += meets != sphere_robust_f32(c.center, c.radius, c.org, c.dir, 0, INFINITY, &t);
    }
    print_message("wrong at distance/radius 1e3, of %d: textbook %d, without cancellation %d, robust %d\n",
                  rays, textbook, plain, robust);
    assert_true(textbook > rays / 100);
    assert_true(plain < rays / 1000);
    assert_int_equal(robust, 0);
}

UNIT_TEST(interval_is_open_and_chooses_the_root) {
    /* From -3 along x: roots 2 and 4, exact in float. */
    vec3_f32 c = {0, 0, 0}, e = {-3, 0, 0}, d = {1, 0, 0}, twice = {2, 0, 0};
    float t = NAN;
    assert_true(sphere_robust_f32(c, 1, e, d, 0, INFINITY, &t));
    assert_true(t == 2);
    assert_true(sphere_robust_f32(c, 1, e, d, 2, INFINITY, &t)); /* t_min on the near root: the far one */
    assert_true(t == 4);
    assert_true(sphere_robust_f32(c, 1, e, d, 3, INFINITY, &t)); /* t_min inside */
    assert_true(t == 4);
    assert_false(sphere_robust_f32(c, 1, e, d, 0, 2, &t));
    assert_false(sphere_robust_f32(c, 1, e, d, 2, 4, &t));
    assert_false(sphere_robust_f32(c, 1, e, d, 4, INFINITY, &t));
    assert_false(sphere_robust_f32(c, 1, e, d, 5, INFINITY, &t));
    assert_true(sphere_robust_f32(c, 1, e, twice, 0, INFINITY, &t)); /* t counts in lengths of d */
    assert_true(t == 1);
    assert_true(sphere_robust_f32(c, 1, c, twice, 0, INFINITY, &t)); /* from the centre */
    assert_true(t == 0.5f);
    assert_false(sphere_robust_f32(c, 1, e, vec_f32(-1, 0, 0), 0, INFINITY, &t)); /* behind */
}

/* From a float point beside or on the surface, whether the ray enters or leaves is decided by the exact sign
 * of |E-C|² - R²: outside and away is no hit, inside is one. */
UNIT_TEST(starts_at_the_surface) {
    random_state r = {5};
    for (int i = 0; i < 20000; ++i) {
        sphere_case c = aimed(&r, 1, 1, 0, 1);
        vec3_f64 n = sub_f64(widen(c.org), widen(c.center));
        vec3_f128 f = sub_f128(quadruple_f32(c.org), quadruple_f32(c.center));
        real_f128 outside = dot_f128(f, f) - 1;
        if (outside == 0) continue;
        c.dir = narrow(random_direction(&r));
        float t = NAN;
        bool hit = sphere_robust_f32(c.center, c.radius, c.org, c.dir, 0, INFINITY, &t);
        if (outside < 0)
            assert_true(hit);
        else if (dot_f64(widen(c.dir), n) >= 0)
            assert_false(hit);
    }
}

/* However the rejection is rounded, a line from inside always leaves. */
UNIT_TEST(from_inside_there_is_a_way_out) {
    random_state r = {9};
    int inside = 0;
    for (int i = 0; i < 200000; ++i) {
        vec3_f32 org = narrow(scale_f64(random_in(&r, 1 - 4e-7, 1 + 1e-7), random_direction(&r)));
        vec3_f32 tangent = narrow(cross_f64(widen(org), random_direction(&r)));
        if (!(dot_f32(org, org) - 1 < 0)) continue;
        float roots[2];
        bool sure;
        assert_true(sphere_plain_f32(vec_f32(0, 0, 0), 1, org, tangent, roots, &sure));
        ++inside;
    }
    assert_true(inside > 1000);
}

UNIT_TEST(odd_input_is_a_miss) {
    const float odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0f, -1, 1, FLT_MAX, -FLT_MAX, FLT_MIN, 0x1p-149f};
    const unsigned n = sizeof odd / sizeof *odd;
    random_state r = {6};
    for (int i = 0; i < 200000; ++i) {
        float v[10], t = NAN;
        bool finite = true;
        for (int k = 0; k < 10; ++k) {
            v[k] = odd[random_bits(&r) % n];
            finite = finite && isfinite(v[k]);
        }
        bool hit = sphere_robust_f32(load_f32(v), v[9], load_f32(v + 3), load_f32(v + 6), 0, INFINITY, &t);
        bool zero = v[6] == 0 && v[7] == 0 && v[8] == 0;
        if (hit) assert_true(finite && !zero && v[9] > 0 && t > 0 && t < INFINITY);
    }
}

UNIT_TEST(square_root_to_one_unit) {
    random_state r = {8};
    for (int i = 0; i < 20000; ++i) {
        real_f128 x = random_in(&r, 1, 4);
        x += (real_f128)random_unit(&r) * (real_f128)0x1p-53;
        int exponent = (int)random_in(&r, -8000, 8000);
        for (int k = 0; k < abs(exponent); ++k) x *= exponent > 0 ? (real_f128)4 : (real_f128)0.25;
        real_f128 s = sqrt_f128(x), off = (s * s - x) / x;
        /* One unit is at most 2^-112 of s, twice that of s²; and the square is rounded. */
        assert_true(abs_f128(off) <= (real_f128)0x1p-111 + (real_f128)0x1p-113);
    }
    assert_true(sqrt_f128(0) == 0 && sqrt_f128((real_f128)INFINITY) == (real_f128)INFINITY);
    assert_true(sqrt_f128(-1) != sqrt_f128(-1));
}

int main(void) {
    int failed = unit_run("denormals as they are", unit_tests, unit_test_count, NULL, NULL);
    unsigned state = trace_thread_begin();
    failed += unit_run("denormals flushed", unit_tests, unit_test_count, NULL, NULL);
    trace_thread_end(state);
    return failed;
}
