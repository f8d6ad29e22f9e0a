/* A few spheres next to Embree's scene: the answers are the reference's, whatever the block. */
#include "stage.h"
#include "trace/embree/embree_spheres.h"

static const char *const ways[] = {"embree:1", "embree:4:low", "embree:8", "embree:16:high"};
#define WAYS (sizeof ways / sizeof *ways)

/* Spheres of all sizes, some through the mesh and through each other; so many are tested there. */
static void add_spheres(stage *s, unsigned count) {
    add_ball(s, FATHOM_ROOT, 20, 0.05, 0.7, 0, 0);
    for (unsigned i = 0; i < count; ++i) {
        double r = pow(10, between(-3, 0));
        add_sphere(s, FATHOM_ROOT, between(-2, 2), between(-2, 2), between(-2, 2), r,
                   i % 4 ? 0 : FATHOM_CASTS_NO_SHADOW);
    }
}

/* Blocks of narrow beams at the spheres, past them, and from inside. */
static ray_set beams(size_t count) {
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count; i += 16) {
        double org[3], at[3], spread = pow(10, between(-6, 0)), apart = pow(10, between(-6, 0)), reach = 3;
        for (int c = 0; c < 3; ++c) org[c] = between(-reach, reach), at[c] = between(-2, 2);
        float t_far = i % 48 ? INFINITY : (float)between(0, 1.5);
        for (size_t k = i; k < i + 16 && k < count; ++k) {
            double from[3], dir[3];
            for (int c = 0; c < 3; ++c) {
                from[c] = org[c] + apart * between(-1, 1);
                dir[c] = at[c] + spread * between(-1, 1) - from[c];
            }
            ray_set_to(&set, k, from, dir, t_far);
        }
    }
    return set;
}

/* A ray may differ where Embree's triangles come within reach of an edge: two in 40 thousand. */
static void check(const stage *s, const ray_set *set, const trace_tracer *linear) {
    ray_set expected = traced(linear, set, TRACE_COHERENT);
    unsigned char *any = occluded(linear, set, TRACE_COHERENT);
    for (size_t way = 0; way < WAYS; ++way) {
        trace_tracer *tracer = stage_spec((stage *)(uintptr_t)s, ways[way]);
        ray_set got = traced(tracer, set, TRACE_COHERENT);
        unsigned char *got_any = occluded(tracer, set, TRACE_COHERENT);
        size_t differ = 0;
        for (size_t i = 0; i < set->count; ++i) {
            const trace_hits *h = &expected.blocks[i / 16].hits;
            uint32_t geometry = h->geometry[i % 16];
            bool sphere =
                geometry != FATHOM_NONE && s->world->geometries.items[geometry].kind == WORLD_SPHERES;
            bool same = same_hit(&got, &expected, i) && any[i] == got_any[i];
            differ += !same;
            if (same && sphere) assert_true(hit_t(&got, i) == hit_t(&expected, i));
        }
        assert_true(differ <= 2);
    }
}

UNIT_TEST(few_spheres_are_met_as_by_linear_search) {
    for (unsigned count = 1; count <= FEW_SPHERES_MOST + 1; count += 5) {
        stage s = stage_open();
        add_spheres(&s, count);
        trace_tracer *linear = stage_spec(&s, "linear");
        ray_set sets[] = {random_rays(fewer(10003)), beams(fewer(20005)), camera_rays(60)};
        for (size_t k = 0; k < 3; ++k) check(&s, &sets[k], linear);
    }
}

/* Where hit or miss is decided by double, and no triangle is near. */
UNIT_TEST(silhouettes_are_those_of_linear_search) {
    stage s = stage_open();
    ray_set set = silhouette_rays(&s, FEW_SPHERES_MOST, -4, 30000, 0.2, 4);
    trace_tracer *linear = stage_spec(&s, "linear"), *embree = stage_spec(&s, "embree");
    ray_set a = traced(linear, &set, TRACE_INCOHERENT), b = traced(embree, &set, TRACE_INCOHERENT);
    for (size_t i = 0; i < set.count; ++i) assert_true(same_hit(&a, &b, i) && hit_t(&a, i) == hit_t(&b, i));
}

/* What is left out as too far from a block's beam is met by none of its rays. */
UNIT_TEST(nothing_close_is_left_out) {
    const few_kernels *kernels = few_kernels_best();
    stage s = stage_open();
    add_spheres(&s, FEW_SPHERES_MOST);
    trace_tracer *linear = stage_spec(&s, "linear");
    few_spheres spheres;
    assert_true(few_gather(s.world, &spheres));
    assert_int_equal(spheres.count, FEW_SPHERES_MOST);
    ray_set set = beams(160000), got = traced(linear, &set, TRACE_INCOHERENT);
    unsigned left_out = 0;
    for (size_t b = 0; b < set.count / 16; ++b) {
        uint32_t close = kernels->close(&spheres, &set.blocks[b].rays);
        left_out += FEW_SPHERES_MOST - (unsigned)__builtin_popcount(close);
        for (unsigned i = 0; i < 16; ++i) {
            const trace_hits *h = &got.blocks[b].hits;
            for (unsigned k = 0; k < spheres.count; ++k) {
                bool met = h->geometry[i] == spheres.geometry[k] && h->primitive[i] == spheres.primitive[k];
                assert_true(!met || close >> k & 1);
            }
        }
    }
    assert_true(left_out > set.count / 16); /* and something is, or it would prove nothing */
}

int main(void) { return unit_main(NULL, NULL); }
