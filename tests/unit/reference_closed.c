/* Closed surfaces do not leak, quads are their two triangles, planes keep their sign. */
#include "random.h"
#include "textbook.h"
#include "unit.h"

#define MAX_TRIANGLES 320

typedef struct closed_mesh {
    vec3_f32 v[MAX_TRIANGLES][3];
    int count;
} closed_mesh;

/* The same midpoint for either order of its ends: every step is symmetric in them. Bumps follow from the
 * place. */
static vec3_f32 midpoint(vec3_f32 a, vec3_f32 b, double bump) {
    vec3_f64 m = normalize_f64(add_f64(widen(a), widen(b)));
    double radius = 1 + bump * sin(7 * m.x + 5 * m.y + 3 * m.z);
    return narrow(scale_f64(radius, m));
}

static void subdivide(closed_mesh *mesh, double bump) {
    int count = mesh->count;
    for (int i = 0; i < count; ++i) {
        vec3_f32 a = mesh->v[i][0], b = mesh->v[i][1], c = mesh->v[i][2];
        vec3_f32 ab = midpoint(a, b, bump), bc = midpoint(b, c, bump), ca = midpoint(c, a, bump);
        vec3_f32(*more)[3] = &mesh->v[mesh->count];
        more[0][0] = a, more[0][1] = ab, more[0][2] = ca;
        more[1][0] = b, more[1][1] = bc, more[1][2] = ab;
        more[2][0] = c, more[2][1] = ca, more[2][2] = bc;
        mesh->v[i][0] = ab, mesh->v[i][1] = bc, mesh->v[i][2] = ca;
        mesh->count += 3;
    }
}

/* An octahedron, `steps` times subdivided, then scaled and moved: star-shaped around `at`. */
static closed_mesh make_closed(int steps, double bump, double scale, vec3_f64 at) {
    closed_mesh mesh = {.count = 8};
    for (int i = 0; i < 8; ++i) {
        float x = i & 1 ? -1.0f : 1.0f, y = i & 2 ? -1.0f : 1.0f, z = i & 4 ? -1.0f : 1.0f;
        mesh.v[i][0] = vec_f32(x, 0, 0), mesh.v[i][1] = vec_f32(0, y, 0), mesh.v[i][2] = vec_f32(0, 0, z);
    }
    for (int s = 0; s < steps; ++s) subdivide(&mesh, bump);
    for (int i = 0; i < mesh.count; ++i) {
        for (int k = 0; k < 3; ++k) mesh.v[i][k] = narrow(madd_f64(at, scale, widen(mesh.v[i][k])));
    }
    return mesh;
}

/* On an edge, or at a vertex, as well as double can aim. */
static vec3_f64 target_on(const closed_mesh *mesh, random_state *r, bool vertex) {
    const vec3_f32 *v = mesh->v[random_bits(r) % (unsigned)mesh->count];
    if (vertex) return widen(v[0]);
    return madd_f64(widen(v[0]), random_unit(r), sub_f64(widen(v[1]), widen(v[0])));
}

typedef struct leak_count {
    int rays, f32, f64, textbook;
} leak_count;

static void count_leaks(const closed_mesh *mesh, random_state *r, vec3_f64 at, double inside, int rays,
                        leak_count *leaks) {
    for (int i = 0; i < rays; ++i) {
        vec3_f64 from = {random_in(r, -inside, inside), random_in(r, -inside, inside),
                         random_in(r, -inside, inside)};
        vec3_f32 org = narrow(add_f64(at, from));
        vec3_f32 dir = narrow(sub_f64(target_on(mesh, r, i % 2), widen(org)));
        bool f32 = false, f64 = i % 10 != 0, textbook = false;
        triangle_ray_f32 ray = triangle_ray_make_f32(org, dir);
        triangle_ray_f64 ray64 = triangle_ray_make_f64(widen(org), widen(dir));
        for (int k = 0; k < mesh->count; ++k) {
            const vec3_f32 *v = mesh->v[k];
            reference_hit_f32 hit;
            reference_hit_f64 hit64;
            if (!f32) f32 = triangle_robust_ray_f32(v[0], v[1], v[2], &ray, 0, INFINITY, &hit);
            if (!textbook) textbook = triangle_textbook_f32(v[0], v[1], v[2], org, dir, 0, INFINITY, &hit);
            if (!f64) {
                f64 = triangle_robust_ray_f64(widen(v[0]), widen(v[1]), widen(v[2]), &ray64, 0,
                                              (double)INFINITY, &hit64);
            }
        }
        leaks->f32 += !f32, leaks->f64 += !f64, leaks->textbook += !textbook;
    }
    leaks->rays += rays;
}

/* A million rays from inside, aimed at edges and vertices: every miss is wrong. */
UNIT_TEST(closed_meshes_do_not_leak) {
    random_state r = {1};
    leak_count leaks = {0};
    const struct {
        int steps, rays;
        double bump, scale;
        vec3_f64 at;
    } cases[] = {{0, 400000, 0, 1, {0, 0, 0}},      {1, 300000, 0.1, 1, {0.3, 0.1, -0.2}},
                 {2, 150000, 0.2, 1, {0, 0, 0}},    {1, 50000, 0.1, 0.03, {2e5, -1e5, 3e4}},
                 {1, 50000, 0.1, 1e-17, {0, 0, 0}}, {1, 50000, 0.1, 1e17, {1e17, 0, 3e17}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        closed_mesh mesh = make_closed(cases[i].steps, cases[i].bump, cases[i].scale, cases[i].at);
        /* Within a fifth of the radius every point sees the whole surface from inside. Far away the grid of
         * floats is as coarse as a fifth of the mesh: from its centre only. */
        double inside = cases[i].at.x > 1e5 && cases[i].scale < 1 ? 0 : 0.2 * cases[i].scale;
        count_leaks(&mesh, &r, cases[i].at, inside, cases[i].rays, &leaks);
    }
    print_message("missed, of %d rays: float %d, double %d (of a tenth), textbook float %d\n", leaks.rays,
                  leaks.f32, leaks.f64, leaks.textbook);
    assert_int_equal(leaks.rays, 1000000);
    assert_int_equal(leaks.f32, 0);
    assert_int_equal(leaks.f64, 0);
    assert_true(leaks.textbook > 1000); /* these rays do find leaks where there are any */
}

static vec3_f32 corner(int k) {
    return vec_f32(k & 1 ? 1.0f : -1.0f, k & 2 ? 1.0f : -1.0f, k & 4 ? 1.0f : -1.0f);
}

/* A turned box of six quads: rays at diagonals, edges and corners. */
UNIT_TEST(closed_boxes_do_not_leak) {
    static const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                    {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    random_state r = {2};
    int leaks = 0;
    for (int i = 0; i < 300000; ++i) {
        vec3_f32 v[8];
        for (int k = 0; k < 8; ++k) {
            vec3_f32 c = corner(k);
            v[k] = vec_f32(0.8f * c.x - 0.3f * c.y, 0.4f * c.x + 0.7f * c.y + 0.1f * c.z,
                           0.9f * c.z - 0.2f * c.x);
        }
        const int *face = faces[random_bits(&r) % 6];
        int from = (int)(random_bits(&r) % 4), to = (from + 1 + (int)(random_bits(&r) % 2)) % 4;
        double s = i % 5 ? random_unit(&r) : 0;
        vec3_f64 target =
            madd_f64(widen(v[face[from]]), s, sub_f64(widen(v[face[to]]), widen(v[face[from]])));
        vec3_f32 org =
            narrow(vec_f64(random_in(&r, -0.1, 0.1), random_in(&r, -0.1, 0.1), random_in(&r, -0.1, 0.1)));
        vec3_f32 dir = narrow(sub_f64(target, widen(org)));
        bool met = false;
        for (int k = 0; k < 6; ++k) {
            reference_hit_f32 hit;
            const int *f = faces[k];
            met = met || quad_robust_f32(v[f[0]], v[f[1]], v[f[2]], v[f[3]], org, dir, 0, INFINITY, &hit);
        }
        leaks += !met;
    }
    assert_int_equal(leaks, 0);
}

/* Any four corners, planar or not: the nearer of the two triangles' hits, to the last bit. */
UNIT_TEST(quad_is_its_two_triangles) {
    random_state r = {3};
    int met = 0;
    for (int i = 0; i < 100000; ++i) {
        vec3_f32 v[4];
        for (int k = 0; k < 4; ++k) v[k] = random_point(&r, 1);
        vec3_f32 org = random_point(&r, 3), dir = sub_f32(random_point(&r, 0.5), org);
        reference_hit_f32 quad = {0}, a = {0}, b = {0};
        bool hit = quad_robust_f32(v[0], v[1], v[2], v[3], org, dir, 0, INFINITY, &quad);
        bool first = triangle_robust_f32(v[0], v[1], v[3], org, dir, 0, INFINITY, &a);
        bool second = triangle_robust_f32(v[2], v[3], v[1], org, dir, 0, INFINITY, &b);
        assert_int_equal(hit, first || second);
        if (!hit) continue;
        ++met;
        if (first && (!second || a.t <= b.t)) {
            assert_true(quad.t == a.t && quad.u == a.u && quad.v == a.v);
        } else {
            assert_true(quad.t == b.t && quad.u == 1 - b.u && quad.v == 1 - b.v);
        }
    }
    assert_true(met > 10000);
}

/* Parallelograms: the bounds in u and v, the split, and the point itself agree. */
UNIT_TEST(quad_coordinates) {
    random_state r = {4};
    for (int i = 0; i < 20000; ++i) {
        vec3_f64 v0 = {random_in(&r, -1, 1), random_in(&r, -1, 1), 0};
        vec3_f64 e = {1, random_in(&r, -0.3, 0.3), random_in(&r, -0.3, 0.3)},
                 g = {random_in(&r, -0.3, 0.3), 1, random_in(&r, -0.3, 0.3)};
        vec3_f64 v1 = add_f64(v0, e), v3 = add_f64(v0, g), v2 = add_f64(v1, g);
        double u = random_in(&r, -0.2, 1.2), v = random_in(&r, -0.2, 1.2), edge = 1e-3;
        vec3_f64 p = add_f64(v0, add_f64(scale_f64(u, e), scale_f64(v, g)));
        vec3_f64 org = {random_in(&r, -1, 1), random_in(&r, -1, 1), 5}, dir = sub_f64(p, org);
        if (fabs(u) < edge || fabs(v) < edge || fabs(1 - u) < edge || fabs(1 - v) < edge) continue;
        bool inside = u > 0 && v > 0 && u < 1 && v < 1;
        reference_hit_f64 robust = {0};
        assert_int_equal(quad_robust_f64(v0, v1, v2, v3, org, dir, 0, (double)INFINITY, &robust), inside);
        if (!inside) continue;
        /* Sides of 1 to 1.1, seen from 5 away within 45 degrees: coordinates of at most 8 carry some 20
         * roundings, and neither the sine of the corner (over 0.7) nor that of the ray multiplies them by
         * more than 2 each. */
        const double tolerance = 8 * 20 * 4 * 0x1p-53;
        assert_near(robust.t, 1, tolerance);
        assert_near(robust.u, u, tolerance);
        assert_near(robust.v, v, tolerance);
    }
}

/* Planar corners that are no parallelogram: inside is inside, also beyond the diagonal. */
UNIT_TEST(quad_of_any_planar_corners) {
    random_state r = {5};
    const vec3_f32 v[4] = {{0, 0, 1}, {4, 0, 1}, {3, 3, 1}, {-1, 2, 1}};
    for (int i = 0; i < 20000; ++i) {
        /* Multiples of 2^-9: the edge functions are exact. */
        float x = (float)((int)random_in(&r, -1024, 2560)) / 512,
              y = (float)((int)random_in(&r, -512, 2048)) / 512;
        double least = INFINITY;
        for (int k = 0; k < 4; ++k) {
            vec3_f32 a = v[k], b = v[(k + 1) % 4];
            least = fmin(least, (double)((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)));
        }
        reference_hit_f32 hit;
        const vec3_f32 org = {x, y, 0}, dir = {0, 0, 1};
        assert_int_equal(quad_robust_f32(v[0], v[1], v[2], v[3], org, dir, 0, INFINITY, &hit), least >= 0);
    }
}

UNIT_TEST(plane_keeps_its_sign) {
    random_state r = {6};
    int close = 0;
    for (int i = 0; i < 50000; ++i) {
        vec3_f32 point = random_point(&r, 10), normal = random_point(&r, 1), dir = random_point(&r, 1);
        vec3_f32 along = cross_f32(normal, random_point(&r, 1)); /* on the plane but for rounding */
        vec3_f32 org = i % 2 ? madd_f32(point, (float)random_in(&r, -9, 9), along) : random_point(&r, 10);
        vec3_f128 n = quadruple_f32(normal), f = sub_f128(quadruple_f32(point), quadruple_f32(org));
        real_f128 above = dot_f128(f, n), slope = dot_f128(quadruple_f32(dir), n), exact = above / slope;
        float t;
        bool met = plane_robust_f32(point, normal, org, dir, 0, INFINITY, &t);
        assert_int_equal(met, exact > 0);
        /* Of either sum 12 u of the largest sides' product, if float decided: at most a fifth of it. */
        double above_error = 12 * 0x1p-24 * (double)largest_f128(n) * (double)largest_f128(f);
        double slope_error = 12 * 0x1p-24 * (double)largest_f128(n) * (double)largest_f32(dir);
        double error = above_error / fabs((double)above) + slope_error / fabs((double)slope);
        assert_near(t, exact, fabs((double)exact) * (1.5 * error + 0x1p-23));
        close += fabs((double)above) < above_error;
    }
    assert_true(close > 1000);
    float t;
    assert_false(plane_robust_f32(vec_f32(0, 0, 0), vec_f32(0, 0, 1), vec_f32(0, 0, 1), vec_f32(1, 0, 0), 0,
                                  INFINITY, &t));
}

int main(void) { return unit_main(NULL, NULL); }
