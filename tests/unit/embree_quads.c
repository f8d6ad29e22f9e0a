/* Quads among Embree's triangles: the answers are the quads', and nothing slips through where halves meet. */
#include "stage.h"

#include "reference/reference.h"

static const char *const in_halves[] = {"embree:1", "embree:4:low", "embree:8:medium", "embree:16:high"};
#define WAYS (sizeof in_halves / sizeof *in_halves)

static void random_axes(double u[3], double v[3]) {
    vec3_f64 a = normalize_f64(vec_f64(between(-1, 1), between(-1, 1), between(-1, 1)));
    vec3_f64 b = normalize_f64(cross_f64(a, vec_f64(between(-1, 1), between(-1, 1), between(-1, 1))));
    store_f64(u, scale_f64(between(0.05, 1), a));
    store_f64(v, madd_f64(scale_f64(between(0.05, 1), b), between(-0.5, 0.5), a));
}

/* Around the origin, some of them in a group that a turned and scaled frame places. */
static void add_quads(stage *s, unsigned count) {
    const double map[12] = {0.6, -0.8, 0, 0.3, 0.8, 0.6, 0.1, -0.2, 0, 0.2, 0.7, 0.1};
    const fathom_id group = new_group(s->scene, "things");
    for (unsigned i = 0; i < count; ++i) {
        const double center[3] = {between(-1, 1), between(-1, 1), between(-1, 1)};
        double u[3], v[3];
        random_axes(u, v);
        add_quad(s, i % 3 ? FATHOM_ROOT : group, center, u, v, i % 5 ? 0 : FATHOM_CASTS_NO_SHADOW);
    }
    add_instance(s, group, map);
}

/* ---- parity ---- */

static double length_of(vec3_f32 v) { return length_f64(widen(v)); }

/* verify/verdict/verdict_bound.c: 32 u L S |d| / |d·n| for the weights of a triangle, 32 u L² S / |d·n| for
 * t. */
static void check_against_reference(const world *w, const ray_set *got, size_t i) {
    const trace_block *b = &got->blocks[i / 16];
    size_t k = i % 16;
    if (b->hits.geometry[k] == FATHOM_NONE || b->hits.instance[k] != FATHOM_NONE) return;
    const world_quad *q =
        &w->quads.items[w->geometries.items[b->hits.geometry[k]].first + b->hits.primitive[k]];
    vec3_f32 org = {b->rays.org_x[k], b->rays.org_y[k], b->rays.org_z[k]};
    vec3_f32 dir = {b->rays.dir_x[k], b->rays.dir_y[k], b->rays.dir_z[k]};
    vec3_f64 c[4], normal = {(double)b->hits.ng_x[k], (double)b->hits.ng_y[k], (double)b->hits.ng_z[k]};
    for (int v = 0; v < 4; ++v) c[v] = widen(q->corner[v]);
    vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    double side = fmax(length_f64(sub_f64(c[1], c[3])),
                       fmax(length_f64(sub_f64(c[1], c[0])), length_f64(sub_f64(c[3], c[0]))));
    double along = fabs(dot_f64(widen(dir), n)), t = (double)b->rays.t_far[k];
    double size = length_of(org) + t * length_of(dir) + 3;
    double weights = 32 * 0x1p-24 * side * size * length_of(dir) / along;
    if (weights > 0.01) return; /* grazes */
    reference_hit_f64 exact;
    if (!quad_robust_f64(c[0], c[1], c[2], c[3], widen(org), widen(dir), 0, INFINITY, &exact)) return;
    assert_true(fabs(exact.t - t) <= 32 * 0x1p-24 * side * side * size / along);
    assert_true(fabs(exact.u - (double)b->hits.u[k]) <= weights);
    assert_true(fabs(exact.v - (double)b->hits.v[k]) <= weights);
    assert_true(dot_f64(normalize_f64(normal), normalize_f64(n)) > 1 - 1e-3);
}

/* A ray may differ where it passes within float's reach of a side: two in 40 thousand. */
UNIT_TEST(hits_are_those_of_the_quads) {
    stage s = stage_open();
    add_quads(&s, 60);
    trace_tracer *linear = stage_spec(&s, "linear");
    ray_set set = random_rays(40003), expected = traced(linear, &set, TRACE_COHERENT);
    unsigned char *any = occluded(linear, &set, TRACE_COHERENT);
    for (size_t way = 0; way < WAYS; ++way) {
        trace_tracer *tracer = stage_spec(&s, in_halves[way]);
        ray_set got = traced(tracer, &set, TRACE_COHERENT);
        unsigned char *got_any = occluded(tracer, &set, TRACE_COHERENT);
        size_t differ = 0;
        for (size_t i = 0; i < set.count; ++i) {
            differ += !same_hit(&got, &expected, i) || any[i] != got_any[i];
            if (same_hit(&got, &expected, i)) check_against_reference(s.world, &got, i);
        }
        assert_true(differ <= 2);
    }
}

/* ---- the diagonal ---- */

/* At the middle half of the diagonal, which lies well inside, from anywhere that does not graze. With |d·n|
 * at least 0.1 |d| |n| and up to 520 away, the rounding of origin and direction moves t by less than 2^-14.
 */
static ray_set diagonal_rays(const world *w, size_t count) {
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count;) {
        const world_quad *q = &w->quads.items[(size_t)(uniform() * (double)w->quads.count)];
        double s = between(0.25, 0.75), reach = i % 2 ? 3 : 300, org[3], target[3];
        vec3_f64 a = widen(q->corner[1]), b = widen(q->corner[3]), c = widen(q->corner[0]);
        vec3_f64 n = normalize_f64(cross_f64(sub_f64(a, c), sub_f64(b, c)));
        store_f64(target, madd_f64(a, s, sub_f64(b, a)));
        for (int k = 0; k < 3; ++k) org[k] = between(-reach, reach);
        vec3_f64 dir = sub_f64(load_f64(target), load_f64(org));
        if (fabs(dot_f64(dir, n)) > 0.1 * length_f64(dir)) ray_towards(&set, i++, org, target);
    }
    return set;
}

UNIT_TEST(nothing_leaks_along_the_diagonal) {
    stage s = stage_open();
    for (int i = 0; i < 20; ++i) {
        const double center[3] = {between(-1, 1), between(-1, 1), between(-1, 1)};
        double u[3], v[3];
        random_axes(u, v);
        add_quad(&s, FATHOM_ROOT, center, u, v, 0);
    }
    stage_spec(&s, "embree");
    ray_set set = diagonal_rays(s.world, 40000);
    for (size_t way = 0; way < WAYS; ++way) {
        trace_tracer *tracer = stage_spec(&s, in_halves[way]);
        ray_set got = traced(tracer, &set, TRACE_COHERENT);
        unsigned char *any = occluded(tracer, &set, TRACE_COHERENT);
        for (size_t i = 0; i < set.count; ++i) {
            assert_true(got.blocks[i / 16].hits.geometry[i % 16] != FATHOM_NONE && any[i]);
            assert_true(hit_t(&got, i) < 1 + 0x1p-14f);
        }
    }
}

/* Two quads in one place: the first counts, and its u and v do not depend on the packets. */
UNIT_TEST(equal_quads_have_one_answer) {
    stage s = stage_open();
    const double center[3] = {0, 0, 0}, u[3] = {0.9, 0.1, 0.2}, v[3] = {-0.1, 0.8, 0};
    add_quad(&s, FATHOM_ROOT, center, u, v, 0);
    add_quad(&s, FATHOM_ROOT, center, u, v, 0);
    trace_tracer *first = stage_spec(&s, in_halves[0]);
    ray_set set = diagonal_rays(s.world, 5000), expected = traced(first, &set, TRACE_COHERENT);
    for (size_t way = 1; way < WAYS; ++way) {
        trace_tracer *tracer = stage_spec(&s, in_halves[way]);
        ray_set got = traced(tracer, &set, TRACE_INCOHERENT);
        for (size_t i = 0; i < set.count; ++i) {
            const trace_hits *a = &got.blocks[i / 16].hits, *b = &expected.blocks[i / 16].hits;
            size_t k = i % 16;
            assert_true(same_hit(&got, &expected, i) && a->primitive[k] == 0);
            assert_true(hit_t(&got, i) == hit_t(&expected, i));
            assert_true(a->u[k] == b->u[k] && a->v[k] == b->v[k]);
        }
    }
}

/* ---- what is not a whole quad ---- */

static ray_set ray_at(double x, double y) {
    ray_set set = rays_new(1);
    const double org[3] = {x, y, 5}, down[3] = {0, 0, -1};
    ray_set_to(&set, 0, org, down, INFINITY);
    return set;
}

static bool meets(stage *s, const char *spec, double x, double y) {
    trace_tracer *tracer = stage_spec(s, spec);
    ray_set set = ray_at(x, y), got = traced(tracer, &set, TRACE_COHERENT);
    unsigned char *any = occluded(tracer, &set, TRACE_COHERENT);
    bool met = got.blocks[0].hits.geometry[0] != FATHOM_NONE;
    assert_int_equal(met, any[0]);
    return met;
}

/* As rounding may leave it: quad 0 has one corner in the other's place, quad 1 one that is not finite, quad 2
 * one beyond Embree's range. */
UNIT_TEST(halves_without_area_are_not_met) {
    static const char *const specs[] = {"linear", "embree:user", "embree"};
    stage s = stage_open();
    const double u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
    for (int i = 0; i < 3; ++i) {
        const double center[3] = {4 * i, 0, 0};
        add_quad(&s, FATHOM_ROOT, center, u, v, 0);
    }
    stage_world(&s);
    vec3_f32(*corner)[4] = (vec3_f32(*)[4])s.world->quads.items;
    double x = (double)corner[0][0].x + 1, y = (double)corner[0][0].y + 1; /* the middle of the first */
    corner[0][0] = corner[0][1];
    corner[1][2].x = NAN;
    corner[2][2].z = 3e18f;
    assert_ok(s.context, world_survey(s.world));
    for (size_t k = 0; k < sizeof specs / sizeof *specs; ++k) {
        assert_true(meets(&s, specs[k], x + 0.3, y + 0.3));
        assert_false(meets(&s, specs[k], x - 0.3, y - 0.3));
        assert_false(meets(&s, specs[k], x + 3.7, y - 0.3));
        assert_false(k > 0 && meets(&s, specs[k], x + 7.7, y - 0.3)); /* linear search has a wider range */
    }
}

/* A square of 1e-13 next to one of 1: products of its sides leave float's range. */
UNIT_TEST(tiny_quads_next_to_large_ones_are_met) {
    stage s = stage_open();
    const double center[3] = {0, 0, 0}, far[3] = {3, 0, 0}, u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
    const double tiny_u[3] = {1e-13, 0, 0}, tiny_v[3] = {0, 1e-13, 0};
    add_quad(&s, FATHOM_ROOT, far, u, v, 0);
    add_quad(&s, FATHOM_ROOT, center, tiny_u, tiny_v, 0);
    const vec3_f64 origin = {0, 0, 0};
    assert_ok(s.context, world_create_from(s.scene, &origin, &s.world));
    own_world(s.world);
    trace_tracer *tracer = stage_spec(&s, "embree");
    ray_set set = rays_new(1);
    const double org[3] = {3e-14, -2e-14, 1e-12}, down[3] = {0, 0, -1};
    ray_set_to(&set, 0, org, down, INFINITY);
    ray_set got = traced(tracer, &set, TRACE_COHERENT);
    assert_int_equal(got.blocks[0].hits.primitive[0], 1);
    assert_true(fabsf(hit_t(&got, 0) - 1e-12f) < 1e-18f);
}

int main(void) { return unit_main(NULL, NULL); }
