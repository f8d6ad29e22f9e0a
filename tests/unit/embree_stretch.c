/* The length of a direction changes the unit of t and nothing else. */
#include "specs.h"
#include "stage.h"
#include "trace/stretch.h"

#include <float.h>

/* Lengths of 1e-20 to 1e20, lengths around 1 in the same blocks. */
static int exponent_of(size_t i) {
    static const int exponents[] = {0, -66, 66, 0, -31, 31, 0, -50, 0, 44, 1};
    return exponents[i % (sizeof exponents / sizeof *exponents)];
}

static ray_set stretched(const ray_set *set) {
    ray_set out = rays_copy(set);
    for (size_t i = 0; i < set->count; ++i) {
        trace_rays *r = &out.blocks[i / 16].rays;
        size_t k = i % 16;
        int e = exponent_of(i);
        r->dir_x[k] = ldexpf(r->dir_x[k], e), r->dir_y[k] = ldexpf(r->dir_y[k], e);
        r->dir_z[k] = ldexpf(r->dir_z[k], e);
        r->t_near[k] = ldexpf(r->t_near[k], -e), r->t_far[k] = ldexpf(r->t_far[k], -e);
    }
    return out;
}

typedef struct visit {
    stage *s;
    const ray_set *rays, *scaled;
    size_t tracers;
} visit;

static void scales(void *user, const char *text) {
    visit *v = user;
    if (!strstr(text, ":medium:")) return;
    trace_tracer *tracer = stage_spec(v->s, text);
    ray_set plain = traced(tracer, v->rays, TRACE_INCOHERENT);
    ray_set got = traced(tracer, v->scaled, TRACE_INCOHERENT);
    unsigned char *any = occluded(tracer, v->rays, TRACE_INCOHERENT);
    unsigned char *any_got = occluded(tracer, v->scaled, TRACE_INCOHERENT);
    for (size_t i = 0; i < v->rays->count; ++i) {
        if (!same_hit(&plain, &got, i) || hit_t(&got, i) != ldexpf(hit_t(&plain, i), -exponent_of(i)) ||
            any[i] != any_got[i])
            fail_msg("%s: ray %zu: t %g by 2^%d, %g, any %d %d", text, i, (double)hit_t(&plain, i),
                     exponent_of(i), (double)hit_t(&got, i), any[i], any_got[i]);
        const trace_rays *a = &v->scaled->blocks[i / 16].rays, *b = &got.blocks[i / 16].rays;
        assert_true(a->dir_x[i % 16] == b->dir_x[i % 16] && a->t_near[i % 16] == b->t_near[i % 16]);
    }
    ++v->tracers;
}

UNIT_TEST(test_embree) {
    stage s = stage_open();
    add_everything(&s);
    stage_world(&s);
    ray_set rays = random_rays(403);
    for (size_t i = 0; i < rays.count; i += 3) rays.blocks[i / 16].rays.t_far[i % 16] = 0.75f;
    for (size_t i = 0; i < rays.count; i += 5) rays.blocks[i / 16].rays.t_near[i % 16] = 0.5f;
    ray_set scaled = stretched(&rays);
    visit v = {&s, &rays, &scaled, 0};
    specs_each(scales, &v);
    assert_true(v.tracers > 10);
}

/* In a group that an instance shrinks to 2^-32, rays longer than 2^27 would leave Embree's range. */
UNIT_TEST(long_directions_reach_into_small_instances) {
    static const double small[12] = {0x1p-32, 0, 0, 0, 0, 0x1p-32, 0, 0, 0, 0, 0x1p-32, 0};
    stage s = stage_open();
    const fathom_id group = new_group(s.scene, NULL);
    add_sphere(&s, group, 0, 0, 0, 0x1p32, 0);
    add_instance(&s, group, small);
    trace_tracer *tracer = stage_embree(&s, 16);
    for (int e = -60; e <= 60; ++e) {
        trace_block block = {.rays = {.org_z[0] = 4, .dir_z[0] = -ldexpf(1, e), .t_far[0] = INFINITY}};
        trace_rays any = block.rays;
        trace_closest(tracer, &block, 1, TRACE_INCOHERENT);
        trace_any(tracer, &any, 1, TRACE_INCOHERENT);
        assert_int_equal(block.hits.instance[0], 0);
        assert_near(ldexp((double)block.rays.t_far[0], e), 3, 1e-6);
        assert_true(any.t_far[0] < 0);
    }
}

/* t leaves float's range only to its nearest number in the interval. */
UNIT_TEST(test_back) {
    const stretch s = {{100, -100}};
    assert_true(stretch_back(&s, 0, 0x1p50f, 0, INFINITY) == 0x1p-50f);
    assert_true(stretch_back(&s, 0, 0x1p-100f, 0, INFINITY) == FLT_MIN);
    assert_true(stretch_back(&s, 0, 0x1p-100f, 0x1p-90f, INFINITY) == nextafterf(0x1p-90f, 1));
    assert_true(stretch_back(&s, 1, 0x1p50f, 0, INFINITY) == FLT_MAX);
    assert_true(stretch_back(&s, 1, 0x1p50f, 0, 3e38f) == nextafterf(3e38f, 0));
}

UNIT_TEST(test_needed) {
    ray_set set = random_rays(16);
    trace_rays *r = &set.blocks[0].rays;
    assert_false(stretch_needed(r, 16, STRETCH_HIGH));
    assert_true(stretch_needed(r, 16, 0x1p-20f));
    const float odd[] = {0x1p31f, 0x1p-31f, NAN, INFINITY, 0};
    for (size_t k = 0; k < sizeof odd / sizeof *odd; ++k) {
        r->dir_x[9] = r->dir_y[9] = r->dir_z[9] = odd[k];
        assert_true(stretch_needed(r, 16, STRETCH_HIGH));
        assert_false(stretch_needed(r, 9, STRETCH_HIGH));
    }
}

int main(void) { return unit_main(NULL, NULL); }
