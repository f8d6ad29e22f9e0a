/* Each verdict by a constructed case, and faults that a comparison must find. */
#include "verify/verdict/verdict.h"
#include "stage.h"
#include "trace/tracer.h"
#include "verify/compare.h"
#include "verify/error.h"
#include "verify/statistics.h"

#include <float.h>

static const verdict_tracer plain = {.unit = 0x1p-24}, embree = {.unit = 0x1p-24, .leaks = true};

UNIT_OWNS(search, search, search_destroy)
UNIT_OWNS(room, search_result, search_result_free)
UNIT_OWNS(source, rays_source, rays_destroy)

typedef struct court {
    stage stage;
    search *search;
    search_result *room;
} court;

static court court_open(void) { return (court){.stage = stage_open()}; }

static void court_begin(court *c) {
    stage_world(&c->stage);
    assert_ok(c->stage.context, search_create(c->stage.context, c->stage.world, &c->search));
    own_search(c->search);
    c->room = own_room(unit_memory(sizeof *c->room));
}

static verdict judged(court *c, const verdict_tracer *tracer, oracle_ray ray, verdict_answer answer) {
    verdict_report report;
    assert_true(verdict_closest(c->search, c->stage.world, tracer, &ray, &answer, c->room, &report));
    return report.verdict;
}

static const verdict_answer miss = {FATHOM_NONE, 0, FATHOM_NONE, 0, 0};

/* Two triangles that make the square [-1,1]² at z = 0 (grid of one cell), and another square at z = -1. */
static court squares(void) {
    court c = court_open();
    add_grid(&c.stage, 1, 0);
    add_grid(&c.stage, 1, -1);
    court_begin(&c);
    return c;
}

static oracle_ray down(float x, float y) { return (oracle_ray){{x, y, 1}, {0, 0, -1}, 0, INFINITY}; }

static verdict_answer at(uint32_t geometry, uint32_t primitive, double t) {
    return (verdict_answer){geometry, primitive, FATHOM_NONE, t, 0};
}

UNIT_TEST(test_agree) {
    court c = squares();
    assert_int_equal(judged(&c, &plain, down(-0.5f, -0.5f), at(0, 0, 1)), VERDICT_AGREE);
    assert_int_equal(judged(&c, &plain, down(-0.5f, -0.5f), at(0, 0, 1 + 0x1p-23)), VERDICT_AGREE);
    assert_int_equal(judged(&c, &plain, down(3, 0), miss), VERDICT_AGREE);
}

/* On the diagonal both triangles are met at the same t. */
UNIT_TEST(test_tie) {
    court c = squares();
    verdict a = judged(&c, &plain, down(0.25f, -0.25f), at(0, 0, 1));
    verdict b = judged(&c, &plain, down(0.25f, -0.25f), at(0, 1, 1));
    assert_int_equal(a, VERDICT_AGREE);
    assert_int_equal(b, VERDICT_TIE);
}

/* Beside an open edge by less than u times the numbers at hand, a hit is as good as a miss; inside the mesh a
 * miss at the diagonal is not. Further out nothing excuses either. */
UNIT_TEST(test_edge_and_leak) {
    court c = squares();
    float in = nextafterf(1, 0), out = nextafterf(1, 2);
    assert_int_equal(judged(&c, &plain, down(in, 0.5f), miss), VERDICT_EDGE);
    assert_int_equal(judged(&c, &plain, down(out, 0.5f), at(0, 1, 1)), VERDICT_EDGE);
    assert_int_equal(judged(&c, &plain, down(1.001f, 0.5f), at(0, 1, 1)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &plain, down(0.999f, 0.5f), miss), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(0.25f, -0.25f), miss), VERDICT_LEAK);
    assert_int_equal(judged(&c, &embree, down(0.25f, -0.25f), at(1, 0, 2)), VERDICT_LEAK);
    assert_int_equal(judged(&c, &plain, down(0.25f, -0.25f), miss), VERDICT_WRONG);
}

/* Next to a slit that is narrower than what the precision can tell, a ray may pass: on all sides at that
 * distance is surface. */
UNIT_TEST(test_slit) {
    const float e = 2e-6f, x[4] = {-1, -e, e, 1};
    float *positions = unit_memory(24 * sizeof *positions);
    static const uint32_t indices[12] = {0, 1, 4, 1, 5, 4, 2, 3, 6, 3, 7, 6};
    court c = court_open();
    for (int k = 0; k < 8; ++k) positions[3 * k] = x[k % 4], positions[3 * k + 1] = k < 4 ? -1 : 1;
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = 8, mesh.indices = indices, mesh.triangle_count = 4;
    assert_ok(c.stage.context, fathom_scene_add_mesh(c.stage.scene, FATHOM_ROOT, &mesh, NULL));
    court_begin(&c);
    assert_int_equal(judged(&c, &plain, down(-2.1e-6f, 0.1f), miss), VERDICT_EDGE);
    assert_int_equal(judged(&c, &plain, down(-1e-4f, 0.1f), miss), VERDICT_WRONG);
}

/* The surface behind is right only where the interval or an edge hides the one in front. */
UNIT_TEST(test_range) {
    court c = squares();
    oracle_ray ray = down(-0.5f, -0.5f);
    ray.t_near = nextafterf(1, 0);
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 1)), VERDICT_AGREE);
    assert_int_equal(judged(&c, &plain, ray, at(1, 0, 2)), VERDICT_RANGE);
    ray.t_near = 1;
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 1 + 0x1p-23)), VERDICT_RANGE);
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 1.001)), VERDICT_WRONG);
    ray.t_near = 0.9f;
    assert_int_equal(judged(&c, &plain, ray, at(1, 0, 2)), VERDICT_WRONG);
    ray.t_far = nextafterf(1, 2);
    assert_int_equal(judged(&c, &plain, ray, miss), VERDICT_RANGE);
    ray.t_far = 1.1f;
    assert_int_equal(judged(&c, &plain, ray, miss), VERDICT_WRONG);
}

/* Where a line leaves a sphere is no hit while the way in counts. */
UNIT_TEST(test_far_root) {
    court c = court_open();
    add_sphere(&c.stage, FATHOM_ROOT, 0, 0, -3, 1, 0);
    court_begin(&c);
    oracle_ray ray = down(0, 0);
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 3)), VERDICT_AGREE);
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 5)), VERDICT_WRONG);
    ray.t_near = 3.5f;
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 5)), VERDICT_AGREE);
}

/* Two roots with no float between them, 1 and 1 ± 2^-38: what was reported is held against the one it means.
 */
UNIT_TEST(test_close_roots) {
    const verdict_tracer quadruple = {.unit = 0x1p-113};
    court c = court_open();
    add_sphere(&c.stage, FATHOM_ROOT, 0, (double)0.001f, 0, (double)0.001f, 0);
    court_begin(&c);
    vec3_f32 d = {0x1.0343aep+24f, 0x1.a1d92ap+19f, 0x1.b246ecp+22f};
    oracle_ray in = {neg_f32(d), d, 1, INFINITY}; /* through the origin, which lies on the sphere, at t = 1 */
    assert_int_equal(judged(&c, &quadruple, in, at(0, 0, 1)), VERDICT_RANGE);
    /* The larger one is the farther: past the nearer, but without an error of its own. */
    d.y = -d.y;
    oracle_ray out = {neg_f32(d), d, 0, 2};
    verdict_answer far = at(0, 0, 1);
    verdict_report report;
    assert_true(verdict_closest(c.search, c.stage.world, &quadruple, &out, &far, c.room, &report));
    assert_int_equal(report.verdict, VERDICT_WRONG);
    assert_true(report.measured && report.exact_t == 1 && report.t_error == 0);
}

/* At 1e-4 radians off the surface an error of 1e-5 is what rounding does; head on it is a fault. */
UNIT_TEST(test_conditioned) {
    court c = squares();
    const double tilt = 1e-4;
    oracle_ray ray = {{-1, -0.3f, (float)(0.4 * tilt)}, {1, 0, -(float)tilt}, 0, INFINITY};
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 0.4 + 1e-3)), VERDICT_CONDITIONED);
    assert_int_equal(judged(&c, &plain, ray, at(0, 0, 0.4 + 0.3)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &plain, down(-0.5f, -0.5f), at(0, 0, 1 + 1e-3)), VERDICT_WRONG);
}

UNIT_TEST(test_wrong) {
    court c = squares();
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), miss), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(1, 0, 2)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(0, 1, 1)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(7, 0, 1)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(0, 9, 1)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(0, 0, -1)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(-0.5f, -0.5f), at(0, 0, (double)NAN)), VERDICT_WRONG);
    assert_int_equal(judged(&c, &embree, down(3, 0), at(0, 0, 1)), VERDICT_WRONG);
}

/* Numbers beyond what a tracer takes, or that its t cannot hold. */
UNIT_TEST(test_beyond) {
    court c = squares();
    const verdict_tracer limited = {.unit = 0x1p-24, .leaks = true, .largest = 1e18},
                         fine = {.unit = 0x1p-53};
    oracle_ray far = {{-0.5f, -0.5f, 1e19f}, {0, 0, -1}, 0, INFINITY};
    assert_int_equal(judged(&c, &limited, far, miss), VERDICT_BEYOND);
    assert_int_equal(judged(&c, &plain, far, miss), VERDICT_EDGE); /* which float may pass from there */
    assert_int_equal(judged(&c, &fine, far, miss), VERDICT_EDGE);
    /* t = 1e39. */
    oracle_ray slow = {{-0.5f, -0.5f, 1e9f}, {0, 0, -1e-30f}, 0, INFINITY};
    assert_int_equal(judged(&c, &plain, slow, miss), VERDICT_BEYOND);
    assert_int_equal(judged(&c, &fine, slow, miss), VERDICT_WRONG);
    assert_int_equal(judged(&c, &plain, slow, at(0, 0, (double)FLT_MAX)), VERDICT_BEYOND);
}

static verdict judged_any(court *c, const verdict_tracer *tracer, oracle_ray ray, bool met) {
    verdict out;
    assert_true(verdict_any(c->search, c->stage.world, tracer, &ray, met, NULL, c->room, &out));
    return out;
}

/* Each class of any hit: the squares one behind the other, so that an edge of one alone excuses nothing. */
UNIT_TEST(test_any) {
    court c = squares();
    float in = nextafterf(1, 0), out = nextafterf(1, 2);
    assert_int_equal(judged_any(&c, &plain, down(0.5f, 0.3f), true), VERDICT_AGREE);
    assert_int_equal(judged_any(&c, &plain, down(3, 0), false), VERDICT_AGREE);
    assert_int_equal(judged_any(&c, &plain, down(0.5f, 0.3f), false), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &plain, down(3, 0), true), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &plain, down(1.001f, 0.5f), true), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &plain, down(in, 0.5f), false), VERDICT_EDGE);
    assert_int_equal(judged_any(&c, &plain, down(out, 0.5f), true), VERDICT_EDGE);
    assert_int_equal(judged_any(&c, &plain, down(0.25f, -0.25f), false), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &embree, down(0.25f, -0.25f), false), VERDICT_LEAK);
    oracle_ray slanted = {{0.5f, 0.3f, 1}, {0.25f, 0, -1}, 0, INFINITY}; /* on the second's edge */
    assert_int_equal(judged_any(&c, &plain, slanted, false), VERDICT_WRONG);
    /* Between the squares, from the one to just before the other: at neither end can float tell. */
    oracle_ray ray = down(0.5f, 0.3f);
    ray.t_near = 1, ray.t_far = 2;
    assert_int_equal(judged_any(&c, &plain, ray, false), VERDICT_AGREE);
    assert_int_equal(judged_any(&c, &plain, ray, true), VERDICT_RANGE);
    ray.t_near = nextafterf(1, 0), ray.t_far = nextafterf(2, 3);
    assert_int_equal(judged_any(&c, &plain, ray, false), VERDICT_RANGE);
    ray.t_near = 1.001f, ray.t_far = 1.999f;
    assert_int_equal(judged_any(&c, &plain, ray, true), VERDICT_WRONG);
}

/* What casts no shadow is not there for any hit. */
UNIT_TEST(test_any_shadows) {
    court c = court_open();
    add_sphere(&c.stage, FATHOM_ROOT, 0, 0, 0, 0.5, FATHOM_CASTS_NO_SHADOW);
    court_begin(&c);
    assert_int_equal(judged_any(&c, &plain, down(0, 0), false), VERDICT_AGREE);
    assert_int_equal(judged_any(&c, &plain, down(0, 0), true), VERDICT_WRONG);
    assert_int_equal(judged(&c, &plain, down(0, 0), miss), VERDICT_WRONG);
}

/* ---- exact ends ---- */

static const verdict_tracer strict = {.unit = 0x1p-24, .strict = true},
                            strict_embree = {.unit = 0x1p-24, .strict = true, .seen = 1u << ORACLE_TRIANGLE};

/* The closed squares are met at t = 1 and 2 without rounding: neither end of the interval is in doubt. */
UNIT_TEST(test_open_ends) {
    court c = squares();
    oracle_ray near = down(-0.5f, -0.25f), far = near;
    near.t_near = 1, near.t_far = 1.5f;
    far.t_far = 1;
    assert_int_equal(judged_any(&c, &strict, near, true), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &strict, far, true), VERDICT_WRONG);
    assert_int_equal(judged_any(&c, &strict, far, false), VERDICT_AGREE);
    assert_int_equal(judged(&c, &strict, far, at(0, 0, 1)), VERDICT_WRONG);
    far.t_far = nextafterf(1, 2);
    assert_int_equal(judged_any(&c, &strict, far, false), VERDICT_WRONG);
    far.t_far = 1;
    /* Embree's own triangles may take an end for inside, and so may any tracer where something is rounded. */
    assert_int_equal(judged_any(&c, &strict_embree, far, true), VERDICT_RANGE);
    oracle_ray odd = down(-0.3f, -0.25f);
    odd.t_far = 1;
    assert_int_equal(judged_any(&c, &strict, odd, true), VERDICT_RANGE);
    assert_int_equal(judged(&c, &strict, odd, at(0, 0, 1)), VERDICT_WRONG); /* but not report it */
}

/* u, v and the normal are judged with the hit. */
UNIT_TEST(test_details) {
    court c = squares();
    rays_source *source;
    assert_ok(c.stage.context, rays_create(c.stage.context, c.stage.world, &source));
    own_source(source);
    const compare_subject subject = {c.stage.world, c.search, source, NULL, plain};
    oracle_ray ray = down(-0.5f, -0.25f);
    oracle_primitive p = search_primitive(c.stage.world, 0, 0, FATHOM_NONE);
    oracle_answer exact;
    oracle_ask(&ray, &p, &exact);
    const ask_answer right = {
        .hit = at(0, 0, 1), .u = (double)exact.weight[1], .v = (double)exact.weight[2], .normal = {0, 0, 4}};
    ask_answer wrong[5] = {right, right, right, right, right};
    wrong[0].u += 1e-3;
    wrong[1].v = (double)NAN;
    wrong[2].u = right.v, wrong[2].v = right.u;
    wrong[3].normal = (vec3_f32){0, 0, -4};
    wrong[4].normal = (vec3_f32){0, NAN, 4};
    verdict_report report;
    error_report errors;
    assert_true(compare_judge(&subject, &ray, &right, false, c.room, &report, &errors));
    assert_int_equal(report.verdict, VERDICT_AGREE);
    for (int i = 0; i < 5; ++i) {
        assert_true(compare_judge(&subject, &ray, &wrong[i], false, c.room, &report, &errors));
        assert_int_equal(report.verdict, VERDICT_WRONG);
    }
}

/* ---- statistics ---- */

static const trace_spec library = {.kind = TRACE_PLUGIN},
                        robust = {.kind = TRACE_EMBREE, .flags = TRACE_SCENE_ROBUST};

static unsigned found_of(const compare_family *family, rays_family at_family) {
    static compare_family families[RAYS_FAMILIES];
    statistics_findings found = {.count = 0};
    memset(families, 0, sizeof families);
    families[at_family] = *family;
    assert_true(statistics_run(&robust, families, &found));
    array_free(&found);
    return (unsigned)found.count;
}

/* A hit whose bound is 256 times its condition, and one whose bound is more, as of a sliver. */
UNIT_TEST(the_constant_is_of_hits_that_the_statistics_count) {
    compare_family f;
    memset(&f, 0, sizeof f);
    const oracle_ray ray = {.dir = {1, 0, 0}};
    const error_report errors = {.uv = -1};
    for (int i = 0; i < 2; ++i) {
        const verdict_report report = {
            .exact_t = 1, .condition = 1, .t_error = i ? 1e6 : 3, .bound = i ? 1e7 : 256};
        compare_family_measure(&f, &ray, 0, &report, &errors, 1, 1);
    }
    assert_true(f.constant.value == 3);
    assert_int_equal(f.constants.total, 1);
}

UNIT_TEST(test_statistics) {
    compare_family f;
    memset(&f, 0, sizeof f);
    for (int i = 0; i < 1000; ++i) histogram_add(&f.constants, i < 995 ? 0.3 : 3);
    assert_int_equal(found_of(&f, RAYS_UNIFORM), 0);
    for (int i = 0; i < 10; ++i) histogram_add(&f.constants, 100);
    assert_int_equal(found_of(&f, RAYS_UNIFORM), 1); /* the 99.9th percentile */
    memset(&f, 0, sizeof f);
    /* A mean of 3 units with a standard error of 0.03, then of 3 with one of 3. */
    f.bias = (compare_bias){.sum = 3 * 1024 * 1000, .squares = 9ull * 1024 * 1024 * 1000, .count = 1000};
    assert_int_equal(found_of(&f, RAYS_UNIFORM), 1);
    f.bias.squares *= 1000;
    assert_int_equal(found_of(&f, RAYS_UNIFORM), 0);
    memset(&f, 0, sizeof f);
    f.rays = 3000, f.counts[VERDICT_LEAK] = 60; /* the known 2 % at vertices */
    assert_int_equal(found_of(&f, RAYS_VERTEX), 0);
    assert_int_equal(found_of(&f, RAYS_EDGE), 1);
    f.counts[VERDICT_LEAK] = 300;
    assert_int_equal(found_of(&f, RAYS_VERTEX), 1);
}

/* A library may declare up to 64 times the unit that its errors show; without hits, no more than float's. */
UNIT_TEST(test_declared_unit) {
    static const struct {
        double unit, constant;
        unsigned hits, found;
    } cases[] = {{0x1p-24, 1, 1000, 0},
                 {0x1p-24, 0.02, 1000, 0},
                 {0x1p-16, 0x1p-8, 1000, 1},
                 {0.5, 0, 0, 1},
                 {0x1p-24, 0, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        static compare_family sum;
        statistics_findings found = {.count = 0};
        memset(&sum, 0, sizeof sum);
        for (unsigned k = 0; k < cases[i].hits; ++k) histogram_add(&sum.constants, cases[i].constant);
        assert_true(statistics_tracer(&library, cases[i].unit, &sum, &found));
        assert_int_equal(found.count, cases[i].found);
        array_free(&found);
    }
}

/* No error in n rays: (1 - p)^n is 5 % at the rate that is named. */
UNIT_TEST(test_power) {
    static const uint64_t rays[] = {1, 3, 100000};
    for (int i = 0; i < 3; ++i) {
        const double p = statistics_power(rays[i]);
        assert_true(fabs(exp((double)rays[i] * log1p(-p)) - 0.05) < 1e-9); /* p is rounded to 2^-53 of 1 */
    }
    assert_true(statistics_power(0) == 1);
}

/* ---- errors ---- */

/* By hand: a ray from (-0.5,-0.5,1) straight down onto the corner's half of the square. */
UNIT_TEST(test_errors) {
    court c = squares();
    oracle_ray ray = down(-0.5f, -0.5f);
    oracle_primitive p = search_primitive(c.stage.world, 0, 0, FATHOM_NONE);
    oracle_answer exact;
    oracle_ask(&ray, &p, &exact);
    assert_true(exact.hit);
    double u = (double)exact.weight[1], v = (double)exact.weight[2];
    error_said said = {1 + 0x1p-23, {0, 0, 7}, u, v};
    error_report e;
    error_measure(&ray, &p, &exact, &said, &e);
    assert_true(e.position == 2); /* 2^-23 at a largest coordinate of 1/2, whose ulp is 2^-24 in [1/2, 1) */
    assert_true(e.normal == 0 && e.uv == 0);
    said = (error_said){1, {0x1p-20f, 0, 1}, u + 0x1p-22, v - 0x1p-24};
    error_measure(&ray, &p, &exact, &said, &e);
    assert_true(e.position == 0);
    assert_true(fabs(e.normal - 16) < 1e-9);
    assert_true(e.uv == 4);
    said.normal = (vec3_f32){0, 0, -1};
    error_measure(&ray, &p, &exact, &said, &e);
    assert_true(fabs(e.normal * 0x1p-24 - 3.141592653589793) < 1e-15);
    said.normal = (vec3_f32){0, 0, 0}, said.u = (double)NAN;
    error_measure(&ray, &p, &exact, &said, &e);
    assert_true(e.normal > 5e7 && isinf(e.uv));
}

/* On a sphere the normal is the point seen from the centre, in an instance's own space. */
UNIT_TEST(test_sphere_errors) {
    court c = court_open();
    const fathom_id group = new_group(c.stage.scene, "one");
    add_sphere(&c.stage, group, 0, 0, 0, 1, 0);
    const double map[12] = {0, -2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0}; /* twice as large and turned about z */
    add_instance(&c.stage, group, map);
    court_begin(&c);
    oracle_ray ray = {{1, 0, 9}, {0, 0, -1}, 0, INFINITY};
    oracle_primitive p = search_primitive(c.stage.world, 0, 0, 0);
    oracle_answer exact;
    oracle_ask(&ray, &p, &exact);
    assert_true(exact.hit);
    double t = 9 - sqrt(3);
    error_said said = {t, {0, -0.5f, (float)sqrt(0.75)}, 0, 0};
    error_report e;
    error_measure(&ray, &p, &exact, &said, &e);
    assert_true(e.normal < 1 && e.uv < 0 && e.position < 1e-6);
}

/* ---- a whole comparison ---- */

/* The reference tracer, whose t is a little too large: tests/mutants has the other faults. */
typedef struct mutant {
    trace_tracer base;
    trace_tracer *inner;
} mutant;

static void mutant_closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                           trace_coherence coherence) {
    (void)fine;
    trace_closest(((const mutant *)tracer)->inner, blocks, count, coherence);
    for (size_t i = 0; i < count; ++i) {
        if (blocks[i / LANES].hits.geometry[i % LANES] != FATHOM_NONE)
            blocks[i / LANES].rays.t_far[i % LANES] *= 1 + 1e-4f;
    }
}

static void mutant_any(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                       trace_coherence coherence) {
    trace_any(((const mutant *)tracer)->inner, blocks, count, coherence);
}

static const trace_ops mutant_ops = {.closest = mutant_closest, .any = mutant_any};

typedef struct trial {
    court court;
    rays_source *source;
    mutant mutant;
    compare_subject subject;
} trial;

static void trial_open(trial *t) {
    trace_options kind = {.words = "reference"};
    t->court = court_open();
    stage *st = &t->court.stage;
    add_everything(st);
    court_begin(&t->court);
    t->mutant = (mutant){.base = {.ops = &mutant_ops, .world = st->world, .unit = 0x1p-24}};
    assert_ok(st->context, trace_create(st->context, st->world, &kind, &t->mutant.inner));
    own_tracer(t->mutant.inner);
    assert_ok(st->context, rays_create(st->context, st->world, &t->source));
    own_source(t->source);
    t->subject = (compare_subject){st->world, t->court.search, t->source, &t->mutant.base, plain};
}

static void trial_run(trial *t, unsigned threads, compare_result *out) {
    const compare_options options = {.families = 1u << RAYS_TANGENT | 1u << RAYS_UNIFORM,
                                     .rays = 300,
                                     .threads = threads,
                                     .failures = 1000};
    memset(out, 0, sizeof *out);
    assert_ok(t->court.stage.context, compare_run(t->court.stage.context, &t->subject, &options, out));
}

UNIT_TEST(failures_fail_again_when_their_calls_are_asked_again) {
    trial t;
    compare_result result;
    trial_open(&t);
    trial_run(&t, 2, &result);
    assert_true(result.failures.count > 100);
    for (size_t i = 0; i < result.failures.count && i < 20; ++i) {
        const compare_failure *failure = &result.failures.items[i];
        const ask_block *block = &failure->block;
        const ask_answer answer = ask_block_again(&t.mutant.base, block);
        verdict_report report;
        error_report errors;
        assert_true(ask_same(&answer, &failure->answer, block->any));
        assert_true(compare_judge(&t.subject, &block->rays[block->lane], &answer, block->any, t.court.room,
                                  &report, &errors));
        assert_int_equal(report.verdict, VERDICT_WRONG);
    }
    compare_result_free(&result);
}

UNIT_TEST(no_number_and_no_failure_depends_on_the_threads) {
    trial t;
    compare_result one, three;
    trial_open(&t);
    trial_run(&t, 1, &one);
    trial_run(&t, 3, &three);
    assert_memory_equal(one.families, three.families, sizeof one.families);
    assert_int_equal(one.failures.count, three.failures.count);
    for (size_t i = 0; i < one.failures.count; ++i)
        assert_int_equal(one.failures.items[i].index, three.failures.items[i].index);
    compare_result_free(&one);
    compare_result_free(&three);
}

/* ---- rays and counts ---- */

/* Every ray of every family is allowed, and the same when asked for again; another seed makes others. */
UNIT_TEST(test_rays) {
    court c = court_open();
    add_everything(&c.stage);
    court_begin(&c);
    rays_source *source;
    assert_ok(c.stage.context, rays_create(c.stage.context, c.stage.world, &source));
    own_source(source);
    for (int f = 0; f < RAYS_RENDERED; ++f) {
        unsigned same = 0;
        for (uint64_t i = 0; i < 2000; ++i) {
            oracle_ray a = rays_make(source, (rays_family)f, 5, i),
                       b = rays_make(source, (rays_family)f, 5, i);
            oracle_ray other = rays_make(source, (rays_family)f, 6, i);
            assert_true(rays_allowed(source, &a));
            assert_memory_equal(&a, &b, sizeof a);
            same += memcmp(&a, &other, sizeof a) == 0;
        }
        assert_true(same < 20);
    }
}

UNIT_TEST(test_histogram) {
    histogram h;
    memset(&h, 0, sizeof h);
    assert_true(histogram_quantile(&h, 0.5) == 0);
    for (int i = 1; i <= 1000; ++i) histogram_add(&h, i);
    for (double q = 0.1; q < 1; q += 0.1) {
        double found = histogram_quantile(&h, q), wanted = 1000 * q;
        /* A bin is a quarter of an octave. */
        assert_true(found >= wanted * (1 - 1e-9) && found <= wanted * 1.19);
    }
    assert_true(histogram_quantile(&h, 0.9999) == 1000); /* no more than the largest */
    histogram_add(&h, (double)INFINITY);
    assert_int_equal(h.total, 1001);
}

int main(void) { return unit_main(NULL, NULL); }
