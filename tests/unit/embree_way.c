/* Which of Embree's kernels a block gets, and that no answer depends on it. */
#include "stage.h"

#include "trace/embree/embree.h"

/* Directions that are off from the first one's, (0, 0, 1), by up to `off` along x. */
static void lean(trace_rays *rays, float off) {
    memset(rays, 0, sizeof *rays);
    for (unsigned i = 0; i < LANES; ++i) {
        rays->dir_x[i] = off * (float)i / (LANES - 1), rays->dir_z[i] = 1;
        rays->t_far[i] = INFINITY;
    }
}

static unsigned width_of(const trace_tracer *tracer) { return ((const embree_tracer *)tracer)->width; }

static bool together(const trace_tracer *tracer, const trace_rays *rays, trace_coherence coherence) {
    embree_way way = embree_way_closest((const embree_tracer *)tracer, rays, LANES, coherence);
    assert_int_equal(way.width, width_of(tracer));
    return way.coherent;
}

UNIT_TEST(by_spread) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 8, 0.1, 1, 0, 0);
    trace_tracer *tracer = stage_embree(&s, 16);
    trace_rays rays;
    lean(&rays, 0.99f * EMBREE_ALIKE);
    assert_true(together(tracer, &rays, TRACE_NEIGHBOURS));
    assert_true(together(tracer, &rays, TRACE_INCOHERENT));
    lean(&rays, 1.01f * EMBREE_ALIKE);
    assert_true(together(tracer, &rays, TRACE_NEIGHBOURS));
    assert_false(together(tracer, &rays, TRACE_INCOHERENT));
    lean(&rays, 0.99f * EMBREE_SIMILAR);
    assert_true(together(tracer, &rays, TRACE_NEIGHBOURS));
    lean(&rays, 1.01f * EMBREE_SIMILAR);
    assert_false(together(tracer, &rays, TRACE_NEIGHBOURS));
    /* Lanes that are not asked do not count; nor how long directions are. */
    assert_true(embree_way_closest((const embree_tracer *)tracer, &rays, 15, TRACE_NEIGHBOURS).coherent);
    for (unsigned i = 0; i < LANES; ++i) rays.dir_x[i] *= 1e-3f, rays.dir_z[i] *= 1e-3f;
    assert_false(together(tracer, &rays, TRACE_NEIGHBOURS));
    /* Who knows that rays run alike is believed. */
    assert_true(together(tracer, &rays, TRACE_COHERENT));
    lean(&rays, 0);
    rays.dir_y[3] = NAN;
    assert_false(together(tracer, &rays, TRACE_NEIGHBOURS));
}

/* Every coordinate counts, and every lane. */
UNIT_TEST(any_direction) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 8, 0.1, 1, 0, 0);
    trace_tracer *tracer = stage_embree(&s, 16);
    for (unsigned c = 0; c < 3; ++c) {
        for (unsigned i = 1; i < LANES; ++i) {
            trace_rays rays;
            lean(&rays, 0);
            float *to[3] = {&rays.dir_x[i], &rays.dir_y[i], &rays.dir_z[i]};
            *to[c] -= 0.9f * EMBREE_SIMILAR;
            assert_true(together(tracer, &rays, TRACE_NEIGHBOURS));
            *to[c] -= 0.2f * EMBREE_SIMILAR;
            assert_false(together(tracer, &rays, TRACE_NEIGHBOURS));
        }
    }
}

static void assert_way(embree_way way, unsigned width, bool coherent) {
    assert_int_equal(way.width, width);
    assert_int_equal(way.coherent, coherent);
}

/* Kernels that were named are kept where the processor has them, and instances have none for rays together.
 */
UNIT_TEST(never_together) {
    trace_rays rays;
    lean(&rays, 0);
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 8, 0.1, 1, 0, 0);
    trace_tracer *named = stage_spec(&s, "embree:16");
    const embree_tracer *embree = (const embree_tracer *)named;
    unsigned widest = embree_call_width(embree, 16);
    assert_way(embree_way_closest(embree, &rays, 16, TRACE_INCOHERENT), widest, false);
    assert_way(embree_way_closest(embree, &rays, 16, TRACE_NEIGHBOURS), widest, false);
    assert_way(embree_way_closest(embree, &rays, 16, TRACE_COHERENT), widest, true);
    assert_way(embree_way_any(embree, &rays, 16, TRACE_INCOHERENT), widest, false);
    s = stage_open();
    add_everything(&s);
    trace_tracer *instanced = stage_embree(&s, 16);
    embree = (const embree_tracer *)instanced;
    const unsigned width = embree->width, narrow = width < 8 ? width : 8;
    assert_way(embree_way_closest(embree, &rays, 16, TRACE_INCOHERENT), width, false);
    assert_way(embree_way_any(embree, &rays, 16, TRACE_INCOHERENT), width, false);
    /* Where sixteen may hang they are never asked together. */
    assert_way(embree_way_any(embree, &rays, 16, TRACE_COHERENT), embree_may_hang(embree) ? narrow : width,
               true);
    lean(&rays, 4 * EMBREE_SIMILAR);
    assert_way(embree_way_closest(embree, &rays, 16, TRACE_COHERENT), width, false);
    assert_way(embree_way_any(embree, &rays, 16, TRACE_COHERENT), width, false);
}

/* ---- the same answers ---- */

/* Blocks of rays from one point, of every spread in turn. */
static ray_set cones(size_t blocks) {
    static const double spread[] = {0, 0.02, 0.1, 0.3, 1, 6};
    ray_set set = rays_new(blocks * LANES - 5);
    for (size_t b = 0; b < blocks; ++b) {
        double org[3] = {between(-2, 2), between(-2, 2), between(-2, 2)}, at[3];
        for (int c = 0; c < 3; ++c) at[c] = between(-0.7, 0.7);
        for (size_t i = b * LANES; i < (b + 1) * LANES && i < set.count; ++i) {
            double off = spread[b % 6], target[3];
            for (int c = 0; c < 3; ++c) target[c] = at[c] + off * between(-0.5, 0.5);
            ray_towards(&set, i, org, target);
        }
    }
    return set;
}

static void answers_alike(stage *s, trace_coherence hint) {
    ray_set set = cones(600);
    trace_tracer *single = stage_spec(s, "embree:1");
    ray_set expected = traced(single, &set, TRACE_INCOHERENT);
    unsigned char *shaded = occluded(single, &set, TRACE_INCOHERENT);
    for (unsigned width = 4; width <= 16; width *= 2) {
        trace_tracer *tracer = stage_embree(s, width);
        ray_set got = traced(tracer, &set, hint);
        unsigned char *dark = occluded(tracer, &set, hint);
        for (size_t i = 0; i < set.count; ++i) {
            assert_true(same_hit(&got, &expected, i));
            assert_true(hit_t(&got, i) == hit_t(&expected, i));
            assert_int_equal(dark[i], shaded[i]);
        }
    }
}

UNIT_TEST(same_answers) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 40, 0.1, 1, 0, 0);
    add_grid(&s, 10, -1.2);
    for (int hint = TRACE_INCOHERENT; hint <= TRACE_COHERENT; ++hint)
        answers_alike(&s, (trace_coherence)hint);
    s = stage_open();
    add_everything(&s);
    for (int hint = TRACE_INCOHERENT; hint <= TRACE_COHERENT; ++hint)
        answers_alike(&s, (trace_coherence)hint);
}

/* Lanes past the count stay as they are, rays and hits, however the block is taken apart. */
UNIT_TEST(others_untouched) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 12, 0.1, 1, 0, 0);
    for (unsigned width = 1; width <= 16; width *= 2) {
        if (width == 2) continue;
        trace_tracer *tracer = stage_embree(&s, width);
        trace_block block, before;
        memset(&block, 0x2b, sizeof block);
        lean(&block.rays, 3);
        for (unsigned i = 0; i < LANES; ++i) block.rays.org_z[i] = -3;
        before = block;
        trace_closest(tracer, &block, 11, TRACE_INCOHERENT);
        assert_true(block.hits.geometry[0] == 0);
        for (unsigned i = 11; i < LANES; ++i) {
            assert_true(block.rays.t_far[i] == before.rays.t_far[i]);
            assert_int_equal(block.hits.geometry[i], before.hits.geometry[i]);
            assert_int_equal(block.hits.primitive[i], before.hits.primitive[i]);
            assert_int_equal(block.hits.instance[i], before.hits.instance[i]);
            assert_memory_equal(&block.hits.u[i], &before.hits.u[i], sizeof(float));
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
