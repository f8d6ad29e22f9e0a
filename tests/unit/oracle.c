/* The oracle against cases computed by hand. */
#include "verify/exact/oracle.h"
#include "trace/trace.h"
#include "unit.h"
#include "verify/exact/exact.h"

static oracle_ray ray_of(vec3_f32 org, vec3_f32 dir, float t_near, float t_far) {
    return (oracle_ray){org, dir, t_near, t_far};
}
static oracle_primitive triangle_of(vec3_f32 a, vec3_f32 b, vec3_f32 c) {
    return (oracle_primitive){.shape = ORACLE_TRIANGLE, .v = {a, b, c}};
}
static oracle_primitive sphere_of(vec3_f32 center, float radius) {
    return (oracle_primitive){.shape = ORACLE_SPHERE, .v = {center}, .radius = radius};
}

static oracle_answer ask(oracle_ray ray, oracle_primitive primitive) {
    oracle_answer answer;
    oracle_ask(&ray, &primitive, &answer);
    return answer;
}

static bool is_exactly(real_f128 x, double y) { return x == (real_f128)y; }

/* The unit right triangle in z = 0, seen from above. */
static const vec3_f32 A = {0, 0, 0}, B = {1, 0, 0}, C = {0, 1, 0};

static oracle_answer drop(float x, float y, float t_far) {
    return ask(ray_of(vec_f32(x, y, 2), vec_f32(0, 0, -1), 0, t_far), triangle_of(A, B, C));
}

UNIT_TEST(edges_and_vertices_belong_to_the_triangle) {
    oracle_answer inner = drop(0.25f, 0.25f, INFINITY);
    assert_true(inner.hit && is_exactly(inner.t, 2) && is_exactly(inner.edge, 0.25));
    assert_true(is_exactly(inner.weight[0], 0.5));
    assert_true(isinf((double)inner.below_far) && is_exactly(inner.above_near, 2));
    oracle_answer side = drop(0.5f, 0, INFINITY);
    assert_true(side.hit && is_exactly(side.edge, 0) && is_exactly(side.weight[1], 0.5));
    oracle_answer slope = drop(0.625f, 0.375f, INFINITY);
    assert_true(slope.hit && is_exactly(slope.weight[0], 0));
    oracle_answer corner = drop(1, 0, INFINITY);
    assert_true(corner.hit && is_exactly(corner.weight[1], 1) && is_exactly(corner.edge, 0));
    /* The next float below 0: outside by exactly that. */
    oracle_answer out = drop(0.5f, -0x1p-149f, INFINITY);
    assert_true(!out.hit && !out.line && is_exactly(out.edge, -0x1p-149));
    oracle_answer past = drop(0.625f, 0x1.8p-2f + 0x1p-25f, INFINITY);
    assert_true(!past.hit && is_exactly(past.weight[0], -0x1p-25));
}

UNIT_TEST(the_interval_is_open) {
    assert_false(drop(0.25f, 0.25f, 2).hit);
    assert_true(is_exactly(drop(0.25f, 0.25f, 2).below_far, 0));
    assert_true(drop(0.25f, 0.25f, nextafterf(2, 3)).hit);
    oracle_primitive triangle = triangle_of(A, B, C);
    vec3_f32 org = {0.25f, 0.25f, 2}, down = {0, 0, -1};
    assert_false(ask(ray_of(org, down, 2, 3), triangle).hit);
    assert_true(ask(ray_of(org, down, nextafterf(2, 0), 3), triangle).hit);
    assert_false(ask(ray_of(org, down, 3, 1), triangle).hit);
    /* t = 1/3 lies between two floats; the nearest is 0x1.555556p-2, above it. */
    vec3_f32 thrice = {0, 0, -6};
    assert_true(ask(ray_of(org, thrice, 0, 0x1.555556p-2f), triangle).hit);
    assert_false(ask(ray_of(org, thrice, 0, 0x1.555554p-2f), triangle).hit);
    assert_false(ask(ray_of(org, thrice, NAN, 3), triangle).hit);
    assert_false(ask(ray_of(org, thrice, 0, NAN), triangle).hit);
    assert_true(ask(ray_of(org, thrice, -INFINITY, INFINITY), triangle).hit);
    assert_false(ask(ray_of(org, thrice, INFINITY, INFINITY), triangle).hit);
}

UNIT_TEST(nothing_meets_what_has_no_area_or_is_not_finite) {
    oracle_ray ray = ray_of(vec_f32(0.25f, 0.25f, 2), vec_f32(0, 0, -1), 0, INFINITY);
    assert_true(ask(ray, triangle_of(A, B, B)).parallel);
    assert_true(ask(ray, triangle_of(A, A, A)).parallel);
    /* On a line in space, by floats whose products round in double. */
    vec3_f32 p = {0x1.fffffep0f, 0x1.000002p0f, 3}, two = {2 * p.x, 2 * p.y, 2 * p.z};
    assert_true(ask(ray, triangle_of(A, p, two)).parallel);
    assert_true(ask(ray_of(vec_f32(-1, 0, 0), vec_f32(1, 0, 0), 0, INFINITY), triangle_of(A, B, C)).parallel);
    assert_false(ask(ray, triangle_of(A, B, vec_f32(0, INFINITY, 0))).hit);
    assert_false(ask(ray, triangle_of(A, B, vec_f32(0, NAN, 0))).hit);
    assert_false(ask(ray_of(ray.org, vec_f32(0, 0, 0), 0, 9), triangle_of(A, B, C)).hit);
    assert_false(ask(ray_of(ray.org, vec_f32(0, 0, 0), 0, 9), sphere_of(A, 9)).hit);
    assert_false(ask(ray, sphere_of(A, 0)).hit);
    assert_false(ask(ray, sphere_of(A, -1)).hit);
    assert_false(ask(ray, sphere_of(A, INFINITY)).hit);
}

UNIT_TEST(a_tangent_meets_the_sphere_once) {
    oracle_primitive sphere = sphere_of(vec_f32(0, 0, 0), 5);
    oracle_ray ray = ray_of(vec_f32(-7, 5, 0), vec_f32(2, 0, 0), 0, INFINITY);
    oracle_answer touch = ask(ray, sphere);
    assert_true(touch.hit && is_exactly(touch.edge, 0) && is_exactly(touch.t, 3.5));
    assert_true(isinf(oracle_condition(&ray, &sphere, &touch, false)));
    /* The tangent at (3, 4, 0), along (4, -3, 0). */
    touch = ask(ray_of(vec_f32(3 - 8, 4 + 6, 0), vec_f32(4, -3, 0), 0, INFINITY), sphere);
    assert_true(touch.hit && is_exactly(touch.edge, 0) && is_exactly(touch.t, 2));
    float above = nextafterf(5, 6), below = nextafterf(5, 4);
    assert_false(ask(ray_of(vec_f32(-7, above, 0), vec_f32(2, 0, 0), 0, INFINITY), sphere).line);
    oracle_answer chord = ask(ray_of(vec_f32(-7, below, 0), vec_f32(2, 0, 0), 0, INFINITY), sphere);
    /* Half of it: √(25 - (5 - 2^-21)²) = √(10·2^-21 - 2^-42). */
    double half = sqrt(10 * 0x1p-21 - 0x1p-42);
    assert_true(chord.hit && chord.part == 0);
    assert_near((double)(chord.t - (real_f128)3.5), -half / 2, 1e-17); /* the double square root's error */
    /* From inside, from the surface, and the root of two that is not representable against both its
     * neighbours. */
    oracle_answer inside = ask(ray_of(vec_f32(0, 0, 3), vec_f32(0, 0, 1), 0, INFINITY), sphere);
    assert_true(inside.hit && inside.part == 1 && is_exactly(inside.t, 2) && is_exactly(inside.other, -8));
    oracle_answer on = ask(ray_of(vec_f32(3, 4, 0), vec_f32(-3, -4, 0), 0, INFINITY), sphere);
    assert_true(on.hit && on.part == 1 && is_exactly(on.t, 2) && is_exactly(on.other, 0));
    oracle_primitive round = sphere_of(vec_f32(0, 0, 0), 1);
    oracle_ray diagonal = ray_of(vec_f32(0, 0, 0), vec_f32(1, 1, 0), 0, 0x1.6a09e6p-1f);
    assert_false(ask(diagonal, round).hit); /* √½ = 0x1.6a09e667…p-1 */
    diagonal.t_far = 0x1.6a09e8p-1f;
    assert_true(ask(diagonal, round).hit);
}

UNIT_TEST(quads_are_their_two_triangles) {
    oracle_primitive quad = {.shape = ORACLE_QUAD, .v = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
    vec3_f32 down = {0, 0, -1};
    oracle_answer a = ask(ray_of(vec_f32(0.25f, 0.5f, 1), down, 0, 9), quad);
    assert_true(a.hit && a.part == 0 && is_exactly(a.edge, 0.25));
    oracle_answer diagonal = ask(ray_of(vec_f32(0.5f, 0.5f, 1), down, 0, 9), quad);
    assert_true(diagonal.hit && diagonal.part == 0 && is_exactly(diagonal.edge, 0.5));
    oracle_answer b = ask(ray_of(vec_f32(0.75f, 0.5f, 1), down, 0, 9), quad);
    assert_true(b.hit && b.part == 1 && is_exactly(b.edge, 0.25));
    oracle_answer miss = ask(ray_of(vec_f32(1.5f, 0.75f, 1), down, 0, 9), quad);
    assert_true(!miss.hit && is_exactly(miss.edge, -0.5));
    /* Folded along the diagonal: both halves in the way, the nearer counts. */
    /* The first half lies in the ray's plane, so the diagonal is the rim of the second. */
    quad.v[2].z = 0x1p-20f;
    oracle_answer rim = ask(ray_of(vec_f32(0, 0, 0), vec_f32(0.5f, 0.5f, 0), 0, 9), quad);
    assert_true(rim.hit && rim.t == 1 && rim.part == 1 && rim.edge == 0);
    quad.v[2] = vec_f32(0, 0, 0.5f);
    oracle_answer fold = ask(ray_of(vec_f32(0.25f, 0.25f, 1), down, 0, 9), quad);
    assert_true(fold.hit && fold.part == 1 && is_exactly(fold.t, 0.75));
}

UNIT_TEST(planes_end_at_parallel_rays) {
    oracle_primitive plane = {.shape = ORACLE_PLANE, .v = {{0, 3, 0}, {0, 2, 0}}};
    oracle_answer a = ask(ray_of(vec_f32(5, 7, 5), vec_f32(0, -1, 0), 0, 9), plane);
    assert_true(a.hit && is_exactly(a.t, 4));
    assert_true(ask(ray_of(vec_f32(5, 3, 5), vec_f32(1, 0, 1), 0, 9), plane).parallel);
    oracle_answer far = ask(ray_of(vec_f32(0, 7, 0), vec_f32(1, -0x1p-149f, 0), 0, INFINITY), plane);
    assert_true(far.hit && is_exactly(far.t, 0x1p151));
    assert_false(ask(ray_of(vec_f32(0, 7, 0), vec_f32(0, 1, 0), 0, INFINITY), plane).hit);
}

static int order_of(oracle_ray ray, oracle_primitive p, oracle_primitive q) {
    oracle_pair a = {p, ask(ray, p)}, b = {q, ask(ray, q)};
    int order = oracle_compare(&ray, &a, &b);
    assert_int_equal(order, -oracle_compare(&ray, &b, &a));
    return order;
}

UNIT_TEST(distances_are_compared_exactly) {
    oracle_ray ray = ray_of(vec_f32(0.25f, 0.25f, 2), vec_f32(0, 0, -3), 0, INFINITY);
    oracle_primitive flat = triangle_of(A, B, C),
                     wide = triangle_of(vec_f32(-4, -4, 0), vec_f32(9, -4, 0), vec_f32(-4, 9, 0));
    assert_int_equal(order_of(ray, flat, wide), 0);
    wide.v[0].z = 0x1p-149f;
    assert_int_equal(order_of(ray, flat, wide), 1); /* nearer by less than binary128 can tell */
    /* Spheres that touch at the origin, and a triangle there: 2/3 each. */
    oracle_ray axis = ray_of(vec_f32(0, 0, 2), vec_f32(0, 0, -3), 0, INFINITY);
    oracle_primitive small = sphere_of(vec_f32(0, 0, -1), 1), large = sphere_of(vec_f32(0, 0, -7), 7);
    assert_int_equal(order_of(axis, small, large), 0);
    assert_int_equal(order_of(axis, small, flat), 0);
    /* √2 and √2 from different quadratics; √2 and √(2 + 2^-70). */
    oracle_ray along = ray_of(vec_f32(0, 0, 0), vec_f32(1, 0, 0), 0, INFINITY);
    oracle_primitive one = sphere_of(vec_f32(0, 1, 0), 0x1.bb67aep0f);
    oracle_primitive same = one, other = sphere_of(vec_f32(0, 0, 1), one.radius);
    assert_int_equal(order_of(along, one, same), 0);
    assert_int_equal(order_of(along, one, other), 0);
    other.v[0].y = 0x1p-149f;
    assert_int_equal(order_of(along, one, other), 1);
    /* A smaller and a larger root at the same place: 3 - 1 and 1 + 1; then 3 - 1 and 1 - 1. */
    oracle_ray beyond = along;
    beyond.t_near = 1;
    assert_int_equal(order_of(beyond, sphere_of(vec_f32(3, 0, 0), 1), sphere_of(vec_f32(1, 0, 0), 1)), 0);
    beyond.t_near = -1;
    assert_int_equal(order_of(beyond, sphere_of(vec_f32(3, 0, 0), 1), sphere_of(vec_f32(1, 0, 0), 1)), 1);
}

static world_instance placed(float scale, vec3_f32 offset) {
    world_instance instance = {.group = 0};
    const float o[3] = {offset.x, offset.y, offset.z};
    for (int i = 0; i < 3; ++i) {
        instance.to_object[i][i] = 1 / scale, instance.to_object[i][3] = -o[i] / scale;
        instance.to_world[i][i] = scale, instance.to_world[i][3] = o[i];
    }
    return instance;
}

UNIT_TEST(instances_carry_the_ray_exactly) {
    world_instance instance = placed(0x1p20f, vec_f32(0x1p23f, 1, 0));
    oracle_primitive triangle = triangle_of(A, B, C);
    triangle.instance = &instance;
    oracle_ray ray = ray_of(vec_f32(0x1p23f + 1, 1, 8), vec_f32(0, 0, -2), 0, INFINITY);
    oracle_answer on = ask(ray, triangle);
    assert_true(on.hit && is_exactly(on.t, 4) && is_exactly(on.weight[1], 0x1p-20) && is_exactly(on.edge, 0));
    /* The inverse's condition is never better than the map's own. */
    assert_true(oracle_condition(&ray, &triangle, &on, true) >=
                oracle_condition(&ray, &triangle, &on, false));
    /* Off the edge by 2^-149 in world space, 2^-169 in the object's. */
    ray.org.y = 1, instance.to_object[1][3] = -0x1p-20f - 0x1p-43f;
    assert_true(is_exactly(ask(ray, triangle).edge, -0x1p-43));
    instance.to_object[0][0] = instance.to_object[1][1] = instance.to_object[2][2] = 0;
    assert_true(ask(ray, triangle).parallel);
}

/* The condition number is what a small change of each input by its own worst sign does, added up. */
static double moved_by(oracle_ray ray, oracle_primitive p, double base, double u, int count) {
    double sum = 0;
    for (int i = 0; i < 6 + 3 * count; ++i) {
        oracle_ray r = ray;
        oracle_primitive q = p;
        float *x = i < 3 ? &r.org.x + i : i < 6 ? &r.dir.x + (i - 3) : &q.v[(i - 6) / 3].x + (i - 6) % 3;
        *x = (float)((double)*x * (1 + u));
        sum += fabs((double)ask(r, q).t - base);
    }
    return sum / u;
}

UNIT_TEST(condition_numbers_are_sensitivities) {
    oracle_ray ray = ray_of(vec_f32(3, 4, 5), vec_f32(-2.75f, -3.5f, -6), 0, INFINITY);
    oracle_primitive triangle = triangle_of(vec_f32(-1, -2, 0.5f), vec_f32(3, 1, -1), vec_f32(-2, 5, 0.25f));
    oracle_answer a = ask(ray, triangle);
    double slope = moved_by(ray, triangle, (double)a.t, 0x1p-12, 3);
    /* Off by the change's own 2^-12, times the second derivative. */
    assert_near(oracle_condition(&ray, &triangle, &a, false) / slope, 1, 0.01);
    oracle_primitive sphere = sphere_of(vec_f32(0.5f, 1, -2), 3);
    oracle_answer s = ask(ray, sphere);
    slope = moved_by(ray, sphere, (double)s.t, 0x1p-12, 1);
    oracle_primitive larger = sphere;
    larger.radius *= 1 + 0x1p-12f;
    slope += fabs((double)(ask(ray, larger).t - s.t)) * 0x1p12;
    assert_near(oracle_condition(&ray, &sphere, &s, false) / slope, 1, 0.01);
}

int main(void) { return unit_main(NULL, NULL); }
