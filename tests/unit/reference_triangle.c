/* Triangles, quads and planes against quadruple precision, for the same float or double input. */
#include "random.h"
#include "textbook.h"
#include "trace/trace.h"
#include "unit.h"

#include <float.h>

typedef struct triangle_case {
    vec3_f32 v[3], org, dir;
} triangle_case;

/* A ray at a random triangle of this size from this distance, everything `offset` away from the origin. */
static triangle_case random_case(random_state *r, double size, double distance, double offset) {
    triangle_case c;
    vec3_f32 shift = random_point(r, offset);
    for (int k = 0; k < 3; ++k) c.v[k] = add_f32(random_point(r, size), shift);
    c.org = add_f32(random_point(r, distance), shift);
    double u = random_in(r, -0.2, 1.2), v = random_in(r, -0.2, 1.2 - u), w = 1 - u - v;
    vec3_f64 target = add_f64(scale_f64(u, widen(c.v[0])), scale_f64(v, widen(c.v[1])));
    target = madd_f64(target, w, widen(c.v[2]));
    c.dir = narrow(scale_f64(random_log(r, 1e-6, 1e6), sub_f64(target, widen(c.org))));
    return c;
}

/* The sheared triangle in quadruple precision, and how far rounding with unit roundoff u can be off. */
typedef struct triangle_truth {
    vec3_f128 v[3]; /* sheared */
    real_f128 edge[3], sum, weight[3], t, dz;
    double edge_error[3], sum_error, weight_error[3], t_error;
} triangle_truth;

static double size2(vec3_f128 a) { return fabs((double)a.x) + fabs((double)a.y); }

/* With M the largest component of a vertex minus the origin: the difference, the quotient, the product and
 * the sum leave a sheared coordinate within δ = 6 u M. An edge function of two such points is then off by δ
 * (|p| + |q|) + 2 δ², and by 3 u |p||q| where its value, not its sign, counts. */
static void bound_errors(triangle_truth *truth, double m, double u) {
    double delta = 6 * u * m, sum = fabs((double)truth->sum);
    truth->sum_error = 0;
    for (int k = 0; k < 3; ++k) {
        double p = size2(truth->v[(k + 1) % 3]), q = size2(truth->v[(k + 2) % 3]);
        truth->edge_error[k] = delta * (p + q) + 2 * delta * delta;
        truth->sum_error += truth->edge_error[k] + 3 * u * p * q + 3 * u * fabs((double)truth->edge[k]);
    }
    double left = sum - truth->sum_error; /* of the sum, at the worst */
    double depth_error = 6 * u * m;
    for (int k = 0; k < 3; ++k) {
        double p = size2(truth->v[(k + 1) % 3]), q = size2(truth->v[(k + 2) % 3]);
        double value = truth->edge_error[k] + 3 * u * p * q, w = fabs((double)truth->weight[k]);
        truth->weight_error[k] = left > 0 ? (value + w * truth->sum_error) / left + 2 * u : (double)INFINITY;
        if (k == 0) continue;
        double side = fabs((double)(truth->v[k].z - truth->v[0].z));
        /* The side itself, its product with the weight, the sum. */
        depth_error += truth->weight_error[k] * (side + 4 * u * m) + w * 6 * u * m;
    }
    double t = fabs((double)truth->t);
    truth->t_error =
        depth_error / fabs((double)truth->dz) + 2 * u * (t + depth_error / fabs((double)truth->dz));
}

static triangle_truth truth_of(const vec3_f64 v[3], vec3_f64 org, vec3_f64 dir, double u) {
    triangle_truth truth;
    triangle_ray_f128 ray = triangle_ray_make_f128(quadruple_f64(org), quadruple_f64(dir));
    double m = 0;
    for (int k = 0; k < 3; ++k) {
        truth.v[k] = sheared_f128(&ray, quadruple_f64(v[k]));
        m = fmax(m, (double)largest_f128(sub_f128(quadruple_f64(v[k]), quadruple_f64(org))));
    }
    truth.dz = ray.dz, truth.sum = 0;
    for (int k = 0; k < 3; ++k) {
        vec3_f128 p = truth.v[(k + 1) % 3], q = truth.v[(k + 2) % 3];
        truth.edge[k] = q.x * p.y - q.y * p.x;
        truth.sum += truth.edge[k];
    }
    real_f128 depth = 0;
    for (int k = 0; k < 3; ++k) {
        truth.weight[k] = truth.edge[k] / truth.sum;
        depth += truth.weight[k] * truth.v[k].z;
    }
    truth.t = depth / truth.dz;
    bound_errors(&truth, m, u);
    return truth;
}

/* 1 a hit, 0 a miss, -1 too near an edge or the end of the interval to tell. */
static int verdict(const triangle_truth *truth) {
    int sign = truth->sum < 0 ? -1 : 1;
    bool doubt = false;
    for (int k = 0; k < 3; ++k) {
        double e = sign * (double)truth->edge[k];
        if (e < -truth->edge_error[k]) {
            /* A miss, unless another edge could turn the whole triangle over. */
            if (fabs((double)truth->sum) > truth->sum_error) return 0;
            doubt = true;
        }
        doubt = doubt || e < truth->edge_error[k];
    }
    if (doubt || !(fabs((double)truth->t) > truth->t_error)) return -1;
    return truth->t > 0;
}

static int check_f32(const triangle_case *c) {
    const vec3_f64 v[3] = {widen(c->v[0]), widen(c->v[1]), widen(c->v[2])};
    triangle_truth truth = truth_of(v, widen(c->org), widen(c->dir), 0x1p-24);
    reference_hit_f32 hit = {0};
    int expected = verdict(&truth);
    bool met = triangle_robust_f32(c->v[0], c->v[1], c->v[2], c->org, c->dir, 0, INFINITY, &hit);
    if (expected < 0) return 0;
    assert_int_equal(met, expected);
    if (!met) return 1;
    assert_near(hit.t, truth.t, truth.t_error);
    assert_near(hit.u, truth.weight[1], truth.weight_error[1]);
    assert_near(hit.v, truth.weight[2], truth.weight_error[2]);
    return 1;
}

static int check_f64(const triangle_case *c) {
    const vec3_f64 v[3] = {widen(c->v[0]), widen(c->v[1]), widen(c->v[2])}, org = widen(c->org),
                   dir = widen(c->dir);
    triangle_truth truth = truth_of(v, org, dir, 0x1p-53);
    reference_hit_f64 hit = {0};
    int expected = verdict(&truth);
    bool met = triangle_robust_f64(v[0], v[1], v[2], org, dir, 0, (double)INFINITY, &hit);
    if (expected < 0) return 0;
    assert_int_equal(met, expected);
    if (!met) return 1;
    assert_near(hit.t, truth.t, truth.t_error);
    assert_near(hit.u, truth.weight[1], truth.weight_error[1]);
    assert_near(hit.v, truth.weight[2], truth.weight_error[2]);
    return 1;
}

UNIT_TEST(robust_is_right) {
    random_state r = {1};
    const int cases = 40000;
    int clear32 = 0, clear64 = 0;
    for (int i = 0; i < cases; ++i) {
        double size = random_log(&r, 1e-3, 1e3);
        triangle_case c = random_case(&r, size, size * random_log(&r, 0.1, 1e3), i % 2 ? 0 : size * 100);
        clear32 += check_f32(&c);
        clear64 += check_f64(&c);
    }
    /* The bounds would be worth nothing if they excused much. */
    print_message("beyond doubt, of %d: float %d, double %d\n", cases, clear32, clear64);
    assert_true(clear32 > cases * 9 / 10);
    assert_true(clear64 > cases - 10);
}

UNIT_TEST(robust_is_right_at_any_size) {
    random_state r = {2};
    int clear = 0;
    const int cases = 20000;
    for (int i = 0; i < cases; ++i) {
        double size = random_log(&r, 1e-24, 1e24);
        triangle_case c = random_case(&r, size, 3 * size, 0);
        float longest = largest_f32(c.dir);
        if (!(longest > 0x1p-120f && longest < INFINITY)) continue;
        clear += check_f32(&c);
    }
    assert_true(clear > cases * 8 / 10);
}

UNIT_TEST(forms_agree_in_quadruple) {
    random_state r = {4};
    for (int i = 0; i < 5000; ++i) {
        triangle_case c = random_case(&r, 1, 5, 0);
        vec3_f128 v[3] = {quadruple_f32(c.v[0]), quadruple_f32(c.v[1]), quadruple_f32(c.v[2])};
        vec3_f128 org = quadruple_f32(c.org), dir = quadruple_f32(c.dir);
        reference_hit_f128 a = {0}, b = {0};
        bool robust = triangle_robust_f128(v[0], v[1], v[2], org, dir, 0, (real_f128)INFINITY, &a);
        bool textbook = triangle_textbook_f128(v[0], v[1], v[2], org, dir, 0, (real_f128)INFINITY, &b);
        assert_int_equal(robust, textbook);
        if (!robust) continue;
        /* 113 bits: slivers and grazing rays that these 5000 hold leave far more than 60 of them. */
        assert_near(a.t, b.t, 0x1p-60 * fabs((double)a.t));
        assert_near(a.u - b.u, 0, 0x1p-60);
        assert_near(a.v - b.v, 0, 0x1p-60);
    }
}

/* A ray from the origin along an axis shears nothing: what is left is the sign of the edge functions, and
 * that is exact, however close to an edge the ray runs. */
UNIT_TEST(sides_are_exact) {
    random_state r = {7};
    int zero = 0;
    for (int i = 0; i < 200000; ++i) {
        double x = random_in(&r, -1, 1), y = random_in(&r, -1, 1), s = random_in(&r, -2, 0);
        vec3_f32 a = {(float)random_in(&r, -1, 1), (float)random_in(&r, -1, 1), 1};
        vec3_f32 b = {(float)x, (float)y, 1}, c = {(float)(s * x), (float)(s * y), 1};
        real_f128 u = (real_f128)c.x * b.y - (real_f128)c.y * b.x,
                  v = (real_f128)a.x * c.y - (real_f128)a.y * c.x,
                  w = (real_f128)b.x * a.y - (real_f128)b.y * a.x;
        bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
        float cb = c.x * b.y, bc = c.y * b.x;
        zero += u != 0 && cb == bc;
        reference_hit_f32 hit;
        reference_hit_f64 hit64;
        const vec3_f32 o = {0, 0, 0}, d = {0, 0, 1};
        assert_int_equal(triangle_robust_f32(a, b, c, o, d, 0, 2, &hit), inside);
        assert_int_equal(triangle_robust_f64(widen(a), widen(b), widen(c), widen(o), widen(d), 0, 2, &hit64),
                         inside);
    }
    assert_true(zero > 1000); /* float alone could not tell these */
}

UNIT_TEST(interval_is_open) {
    vec3_f32 a = {0, 0, 2}, b = {1, 0, 2}, c = {0, 1, 2}, o = {0.25f, 0.5f, 0}, d = {0, 0, 2};
    reference_hit_f32 hit;
    assert_true(triangle_robust_f32(a, b, c, o, d, 0, INFINITY, &hit));
    assert_true(hit.t == 1 && hit.u == 0.25f && hit.v == 0.5f);
    assert_false(triangle_robust_f32(a, b, c, o, d, 1, INFINITY, &hit));
    assert_false(triangle_robust_f32(a, b, c, o, d, 0, 1, &hit));
    assert_true(triangle_robust_f32(b, a, c, o, d, 0, 2, &hit)); /* from the other side */
    assert_true(hit.t == 1 && hit.u == 0.25f && hit.v == 0.5f);
    assert_true(triangle_robust_f32(c, a, b, o, d, 0, 2, &hit));
    assert_true(hit.u == 0.25f && hit.v == 0.25f);
    assert_false(triangle_robust_f32(a, b, c, o, neg_f32(d), 0, INFINITY, &hit));
    assert_false(
        triangle_robust_f32(a, b, c, vec_f32(0, 0, 2), vec_f32(1, 0, 0), 0, INFINITY, &hit)); /* along it */
}

UNIT_TEST(without_area_never_met) {
    random_state r = {5};
    reference_hit_f32 hit;
    reference_hit_f64 hit64;
    for (int i = 0; i < 20000; ++i) {
        /* Integers: the points are exactly in line, or the same. */
        vec3_f32 a = {(float)(int)random_in(&r, -999, 999), (float)(int)random_in(&r, -999, 999),
                      (float)(int)random_in(&r, -999, 999)};
        vec3_f32 step = {(float)(int)random_in(&r, -99, 99), (float)(int)random_in(&r, -99, 99),
                         (float)(int)random_in(&r, -99, 99)};
        vec3_f32 b = madd_f32(a, (float)(i % 5), step), c = madd_f32(a, (float)(i % 7 - 3), step);
        vec3_f32 org = random_point(&r, 2000), target = madd_f32(a, (float)random_in(&r, -3, 4), step);
        vec3_f32 dir = sub_f32(target, org);
        assert_false(triangle_robust_f32(a, b, c, org, dir, 0, INFINITY, &hit));
        assert_false(triangle_robust_f64(widen(a), widen(b), widen(c), widen(org), widen(dir), 0,
                                         (double)INFINITY, &hit64));
    }
}

UNIT_TEST(odd_input_is_a_miss) {
    const float odd[] = {NAN, INFINITY, -INFINITY, 0,       -0.0f,     -1,
                         1,   FLT_MAX,  -FLT_MAX,  FLT_MIN, 0x1p-149f, 0.25f};
    const unsigned n = sizeof odd / sizeof *odd;
    random_state r = {6};
    int met = 0;
    for (int i = 0; i < 300000; ++i) {
        float v[18];
        bool finite = true;
        unsigned from = random_bits(&r) % 2 ? 3 : 0; /* half of them without NaN and infinity */
        for (int k = 0; k < 18; ++k) {
            v[k] = odd[from + random_bits(&r) % (n - from)];
            finite = finite && isfinite(v[k]);
        }
        vec3_f32 a = load_f32(v), b = load_f32(v + 3), c = load_f32(v + 6), d = load_f32(v + 9);
        vec3_f32 org = load_f32(v + 12), dir = load_f32(v + 15);
        bool zero = dir.x == 0 && dir.y == 0 && dir.z == 0;
        reference_hit_f32 hit;
        if (triangle_robust_f32(a, b, c, org, dir, 0, INFINITY, &hit)) {
            assert_true(!zero && hit.t > 0 && hit.t < INFINITY && hit.u >= 0 && hit.v >= 0);
            assert_true(finite_f32(a) && finite_f32(b) && finite_f32(c) && finite_f32(org) &&
                        finite_f32(dir));
            ++met;
        }
        if (quad_robust_f32(a, b, c, d, org, dir, 0, INFINITY, &hit)) {
            assert_true(!zero && hit.t > 0 && hit.t < INFINITY);
        }
        float t;
        if (plane_robust_f32(a, b, org, dir, 0, INFINITY, &t)) assert_true(!zero && t > 0 && t < INFINITY);
    }
    assert_true(met > 0);
}

int main(void) {
    int failed = unit_run("denormals as they are", unit_tests, unit_test_count, NULL, NULL);
    unsigned state = trace_thread_begin();
    failed += unit_run("denormals flushed", unit_tests, unit_test_count, NULL, NULL);
    trace_thread_end(state);
    return failed;
}
