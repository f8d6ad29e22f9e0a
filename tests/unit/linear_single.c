/* Linear search in every precision: what they agree on, and what a block is promised by all of them. */
#include "stage.h"

static const char *const forms[] = {"linear:f32", "linear:f64", "linear:f128"};
enum { FORMS = 3, TRUTH = 2 };

typedef struct answers {
    ray_set rays;
    trace_fine *fine;
} answers;

static answers answer(const trace_tracer *tracer, const ray_set *set) {
    answers a = {rays_copy(set), unit_memory((set->count + 15) / 16 * sizeof *a.fine)};
    unsigned state = trace_thread_begin();
    trace_closest_fine(tracer, a.rays.blocks, a.fine, set->count, TRACE_INCOHERENT);
    trace_thread_end(state);
    return a;
}

/* The t of a flat shape is off by some 8 units over the cosine to its normal; a random ray meets a surface at
 * a cosine below c with probability c^2, so 2^12 units are exceeded once in (2^9)^2 rays. Rays come
 * within float's reach of an edge or a silhouette once in some 10^4. */
UNIT_TEST(agree_but_for_precision) {
    stage s = stage_open();
    add_everything(&s);
    stage_spec(&s, forms[0]);
    ray_set set = random_rays(800);
    trace_tracer *truth = stage_spec(&s, forms[TRUTH]);
    answers exact = answer(truth, &set);
    size_t met = 0;
    for (size_t f = 0; f < FORMS; ++f) {
        trace_tracer *tracer = stage_spec(&s, forms[f]);
        answers got = answer(tracer, &set);
        size_t differ = 0, far = 0;
        for (size_t i = 0; i < set.count; ++i) {
            if (!same_hit(&got.rays, &exact.rays, i)) {
                ++differ;
                continue;
            }
            if (exact.rays.blocks[i / 16].hits.geometry[i % 16] == FATHOM_NONE) continue;
            ++met;
            double t = got.fine[i / 16].t[i % 16], low = got.fine[i / 16].t_low[i % 16];
            double right = exact.fine[i / 16].t[i % 16], right_low = exact.fine[i / 16].t_low[i % 16];
            double error = fabs((t - right) + (low - right_low));
            far += error > 0x1p12 * trace_unit(tracer) * right;
            assert_true(hit_t(&got.rays, i) == (float)t);
            if (f < TRUTH) assert_true(low == 0);
        }
        assert_in_range(differ, 0, f == 0 ? 2 : 0);
        assert_int_equal(far, 0);
    }
    assert_true(met > FORMS * 200);
}

/* Past a sphere 4096 radii away, by a hundredth of its radius inside or outside: beyond a plain quadratic
 * in float. */
UNIT_TEST(far_spheres_are_met) {
    stage s = stage_open();
    add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 1, 0);
    stage_spec(&s, forms[0]);
    enum { rays = 1000 };
    ray_set set = rays_new(rays);
    for (size_t i = 0; i < rays; ++i) {
        vec3_f64 to = normalize_f64(vec_f64(between(-1, 1), between(-1, 1), between(-1, 1)));
        vec3_f64 side = normalize_f64(cross_f64(to, vec_f64(between(-1, 1), between(-1, 1), between(-1, 1))));
        double org[3], target[3];
        store_f64(org, scale_f64(-4096, to));
        store_f64(target, scale_f64(i % 2 ? 0.99 : 1.01, side));
        ray_towards(&set, i, org, target);
    }
    for (size_t f = 0; f < FORMS; ++f) {
        trace_tracer *tracer = stage_spec(&s, forms[f]);
        ray_set got = traced(tracer, &set, TRACE_COHERENT);
        size_t wrong = 0;
        for (size_t i = 0; i < rays; ++i) wrong += (got.blocks[i / 16].hits.geometry[i % 16] == 0) != i % 2;
        assert_int_equal(wrong, 0);
    }
}

/* Two triangles whose t differ by less than float can tell: double finds the nearer one, the second; float
 * ties, and the first stays. */
UNIT_TEST(the_nearer_by_own_precision) {
    static const float p[] = {-1,       -1, 0,  1,        -1, 0, 0,        1, 0, -1, -1,
                              0x1p-30f, 1,  -1, 0x1p-30f, 0,  1, 0x1p-30f, 0, 0, 0,  0};
    static const uint32_t t[] = {0, 1, 2, 3, 4, 5};
    stage s = stage_open();
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 6, mesh.indices = t, mesh.triangle_count = 2;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    const double org[3] = {0, 0, 1}, dir[3] = {0, 0, -1};
    for (size_t f = 0; f < FORMS; ++f) {
        trace_tracer *tracer = stage_spec(&s, forms[f]);
        ray_set set = rays_new(1);
        ray_set_to(&set, 0, org, dir, INFINITY);
        answers got = answer(tracer, &set);
        assert_int_equal(got.rays.blocks[0].hits.primitive[0], f == 0 ? 0 : 1);
        assert_true(got.fine[0].t[0] == (f == 0 ? 1 : 1 - 0x1p-30));
    }
}

/* Shadows pass what casts none, planes are seen, lanes past the count and empty intervals stay, and any hit
 * says what closest hit says. */
UNIT_TEST(blocks_are_kept_to) {
    stage s = stage_open();
    add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 1, FATHOM_CASTS_NO_SHADOW);
    add_sphere(&s, FATHOM_ROOT, 10, 0, 0, 1, 0);
    add_plane(&s, -5, FATHOM_CASTS_NO_SHADOW);
    for (size_t f = 0; f < FORMS; ++f) {
        trace_tracer *tracer = stage_spec(&s, forms[f]);
        ray_set set = rays_new(16);
        memset(set.blocks, 0x5a, sizeof *set.blocks);
        for (size_t i = 0; i < 6; ++i) {
            const double org[3] = {i < 3 ? 5 * (double)i : 0, 0, 3}, dir[3] = {0, 0, -1};
            ray_set_to(&set, i, org, dir, INFINITY);
        }
        trace_rays *r = &set.blocks->rays;
        r->t_far[3] = -INFINITY;                                 /* done before */
        r->t_near[4] = 2, r->t_far[4] = 4;                       /* both ends are excluded */
        r->t_near[5] = nextafterf(2, 1), r->t_far[5] = INFINITY; /* the sphere is just inside */
        trace_rays shadows = *r;
        trace_closest(tracer, set.blocks, 6, TRACE_COHERENT);
        trace_any(tracer, &shadows, 6, TRACE_COHERENT);
        const uint32_t *geometry = set.blocks->hits.geometry;
        assert_true(r->t_far[0] == 2 && r->t_far[1] == 8 && r->t_far[2] == 2 && r->t_far[5] == 2);
        assert_true(geometry[1] == TRACE_PLANE && geometry[3] == FATHOM_NONE && geometry[4] == FATHOM_NONE);
        assert_true(r->t_far[3] == -INFINITY && r->t_far[4] == 4);
        assert_true(set.blocks->hits.ng_z[0] == 1);
        assert_true(shadows.t_far[0] == INFINITY && shadows.t_far[1] == INFINITY);
        assert_true(shadows.t_far[2] == -INFINITY && shadows.t_far[4] == 4);
        for (size_t i = 6; i < 16; ++i) assert_int_equal(geometry[i], 0x5a5a5a5a);
    }
}

UNIT_TEST(any_is_closest) {
    stage s = stage_open();
    add_everything(&s);
    stage_spec(&s, forms[0]);
    ray_set set = random_rays(160);
    for (size_t f = 0; f < FORMS; ++f) {
        trace_tracer *tracer = stage_spec(&s, forms[f]);
        ray_set got = traced(tracer, &set, TRACE_INCOHERENT);
        unsigned char *any = occluded(tracer, &set, TRACE_INCOHERENT);
        for (size_t i = 0; i < set.count; ++i) {
            assert_int_equal(any[i], got.blocks[i / 16].hits.geometry[i % 16] != FATHOM_NONE);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
