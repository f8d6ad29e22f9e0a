/* Spheres with twice the digits of float, from the world to every tracer, the oracle and the rays of one's
 * own. */
#include "stage.h"
#include "verify/exact/oracle.h"
#include "verify/search/search.h"

/* 2^24 + 1/2 and its like are no floats; the sphere touches the origin from below. */
static const double big = 16777216.5;

static stage open_with(double radius, double z) {
    stage s = stage_open();
    add_sphere(&s, FATHOM_ROOT, 0, 0, z, radius, 0);
    stage_world(&s);
    return s;
}

UNIT_TEST(kept_where_it_shows) {
    static const struct {
        double radius, z;
        bool split;
    } cases[] = {{big, -big, true},
                 {big, 0, false},
                 {0.3, 5.1, false},
                 {6371000, -6371000, false},
                 {6371000.3, -6371000.3, true},
                 {0.1, 0.10000001, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        stage s = open_with(cases[i].radius, cases[i].z);
        const world_sphere *sphere = &s.world->spheres.items[0];
        assert_int_equal(world_sphere_is_split(sphere), cases[i].split);
        if (cases[i].split) {
            /* Two floats hold 48 bits. */
            assert_near(world_sphere_radius(sphere), cases[i].radius, 0x1p-48 * cases[i].radius);
            assert_near(world_sphere_center(sphere).z, cases[i].z, 0x1p-48 * cases[i].radius);
        }
    }
}

UNIT_TEST(the_oracle_takes_all_of_it) {
    stage s = open_with(big, -big);
    oracle_primitive p = search_primitive(s.world, 0, 0, FATHOM_NONE);
    oracle_ray down = {{0, 0, 1}, {0, 0, -1}, 0, INFINITY}, along = {{-1, 0, 0}, {1, 0, 0}, 0, INFINITY};
    oracle_answer a;
    oracle_ask(&down, &p, &a);
    assert_true(a.hit && a.t == 1);
    oracle_ask(&along, &p, &a);
    assert_true(a.hit && a.edge == 0); /* a tangent */
    along.org.z = 0x1p-100f;
    oracle_ask(&along, &p, &a);
    assert_false(a.hit);
}

/* What lies nearer than the roundings of a planet in double, 16 2^-53 R, is no one's; what is farther is
 * told. */
UNIT_TEST(all_tracers_meet_it_where_it_is) {
    static const char *const specs[] = {"reference", "linear:f64", "linear:f128", "bvh",        "bvh:f64",
                                        "bvh:f128",  "embree",     "embree:1",    "embree:user"};
    stage s = open_with(6371000.3, -6371000.3);
    oracle_primitive p = search_primitive(s.world, 0, 0, FATHOM_NONE);
    ray_set rays = random_rays(1000);
    for (size_t n = 0; n < sizeof specs / sizeof *specs; ++n) {
        trace_tracer *tracer = stage_spec(&s, specs[n]);
        ray_set hits = traced(tracer, &rays, TRACE_INCOHERENT);
        unsigned char *any = occluded(tracer, &rays, TRACE_INCOHERENT);
        for (size_t i = 0; i < rays.count; ++i) {
            const trace_rays *r = &rays.blocks[i / 16].rays;
            size_t k = i % 16;
            oracle_ray ray = {{r->org_x[k], r->org_y[k], r->org_z[k]},
                              {r->dir_x[k], r->dir_y[k], r->dir_z[k]},
                              0,
                              INFINITY};
            oracle_answer a;
            oracle_ask(&ray, &p, &a);
            bool met = hits.blocks[i / 16].hits.geometry[k] != FATHOM_NONE;
            double slope = fabs((double)ray.dir.z), near = 16 * 0x1p-53 * 6371000.3;
            if (fabs((double)ray.org.z) < near || slope < 1e-3) continue;
            if (met != a.hit || any[i] != a.hit)
                fail_msg("%s: ray %zu: met %d, hit %d", specs[n], i, met, a.hit);
            /* t is rounded to float, and the double's roundings are seen at a slope. */
            double t = (double)a.t;
            if (met) assert_near(hit_t(&hits, i), t, 0x1p-24 * t + near / slope);
        }
    }
}

UNIT_TEST(rays_of_ones_own) {
    stage s = open_with(6371000.3, -6371000.3);
    fathom_tracer *tracer;
    for (int kind = 0; kind < 2; ++kind) {
        assert_ok(s.context,
                  fathom_tracer_create(s.context, s.scene, kind ? "embree" : "reference", &tracer));
        fathom_ray ray = {.origin = {0, 0, 1e-3}, .direction = {0.6, 0, -0.8}, .t_min = 0, .t_max = 1};
        fathom_hit hit;
        assert_ok(s.context, fathom_tracer_closest(tracer, &ray, 1, &hit));
        /* The ground is flat within 1e-13 m there; centre and radius have 48 bits, and double loses some
         * 2^-53 R. */
        assert_near(hit.t, 1e-3 / 0.8, 1e-7);
        assert_near(hit.position[2], 0, 1e-7);
        ray.t_max = 1.24e-3;
        assert_ok(s.context, fathom_tracer_closest(tracer, &ray, 1, &hit));
        assert_true(isinf(hit.t));
        fathom_tracer_destroy(tracer);
    }
}

int main(void) { return unit_main(NULL, NULL); }
