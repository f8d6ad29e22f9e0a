/* Laws of sampled light. Every statistical test is made once, with fixed numbers, at 5 standard errors
 * (6e-7); with at most a thousand of them here one fails by chance with 6e-4. */
#include "unit_light.h"

enum { BLOCKS = 4000 };

static const double errors = 5;

static fathom_id emission(float r, float g, float b) {
    fathom_material m = default_material();
    m.k_e[0] = r, m.k_e[1] = g, m.k_e[2] = b;
    return new_material(scene, NULL, &m);
}

static void add_sphere(fathom_id group, vec3_f64 center, double radius, fathom_id material) {
    fathom_sphere s = default_sphere();
    store_f64(s.center, center), s.radius = radius, s.material = material;
    assert_ok(context, fathom_scene_add_sphere(scene, group, &s, NULL));
}

static void add_quad(const double center[3], const double u[3], const double v[3], fathom_id material) {
    fathom_quad q;
    fathom_quad_from_axes(center, u, v, &q);
    q.material = material;
    assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &q, NULL));
}

static void add_point(vec3_f64 at, float intensity) {
    fathom_light light = default_light();
    store_f64(light.position, at);
    for (int c = 0; c < 3; ++c) light.intensity[c] = intensity;
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

/* ---- sampling ---- */

static vec3_f32 lane(const lanes3 v, int i) { return vec_f32(v[0][i], v[1][i], v[2][i]); }

/* The mean of some samples, and its error. */
typedef struct mean {
    double sum, squares;
    uint64_t count;
} mean;

static void take(mean *m, double x) { m->sum += x, m->squares += x * x, ++m->count; }
static double mean_of(const mean *m) { return m->sum / (double)m->count; }
static double error_of(const mean *m) {
    double n = (double)m->count, a = m->sum / n;
    return sqrt(fmax(m->squares / n - a * a, 0) / (n - 1));
}

/* What a sample adds to the irradiance over pi, in the first channel; checks that its numbers are sound. */
static double part(const emitter_sample *s, int i, vec3_f64 n) {
    vec3_f64 d = widen(lane(s->direction, i));
    if (!(s->density[i] > 0)) {
        assert_true(s->density[i] == 0);
        return 0;
    }
    assert_near(length_f64(d), 1, 4e-7); /* three roundings of float */
    assert_true(s->distance[i] > 0);
    assert_true(isfinite(s->density[i]));
    for (int c = 0; c < 3; ++c) assert_true(s->radiance[c][i] >= 0 && isfinite(s->radiance[c][i]));
    return (double)s->radiance[0][i] * fmax(dot_f64(n, d), 0) / ((double)s->density[i] * M_PI);
}

static mean irradiance(vec3_f64 p, vec3_f64 n, int blocks) {
    random_state r = {1};
    mean m = {0};
    emitter_query q;
    fill_query(&q, p, n);
    for (int b = 0; b < blocks; ++b) {
        lanes3 u;
        emitter_sample s;
        fill_numbers(&r, u);
        emitters_sample(e, &q, u, &s);
        for (int i = 0; i < LANES; ++i) take(&m, part(&s, i, n));
    }
    return m;
}

/* 1e-6: roundings of float. */
static void assert_irradiance(vec3_f64 p, vec3_f64 n, double expected) {
    mean m = irradiance(p, n, BLOCKS);
    assert_near(mean_of(&m), expected, errors * error_of(&m) + 1e-6 * expected);
}

static const vec3_f64 up = {0, 0, 1}, origin = {0, 0, 0};

/* ---- closed forms ---- */

UNIT_TEST(a_rectangle_sends_what_its_formula_says) {
    add_quad((double[3]){0.5, 1, 1.5}, (double[3]){0.5, 0, 0}, (double[3]){0, 1, 0}, emission(1, 1, 1));
    open_light();
    assert_irradiance(origin, up, 0.12235966);
}

/* The same rectangle in triangles, of which one is seen at a time. */
UNIT_TEST(triangles_send_what_their_polygon_does) {
    static const float p[6][3] = {{0, 0, 1.5f}, {1, 0, 1.5f},    {1, 2, 1.5f},
                                  {0, 2, 1.5f}, {0.3f, 1, 1.5f}, {0.9f, 0.4f, 1.5f}};
    static const uint32_t index[] = {0, 1, 5, 1, 2, 5, 0, 5, 4, 5, 2, 4, 2, 3, 4, 3, 0, 4};
    fathom_mesh mesh = default_mesh();
    mesh.positions = p[0], mesh.vertex_count = 6, mesh.indices = index, mesh.triangle_count = 6;
    mesh.material = emission(1, 1, 1);
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    open_light();
    assert_irradiance(origin, up, 0.12235966);
}

/* Lambert's edge sum over a polygon that the horizon does not cut. */
static double edge_sum(vec3_f64 p, vec3_f64 n, const vec3_f64 *corner, int count) {
    double sum = 0;
    for (int k = 0; k < count; ++k) {
        vec3_f64 a = normalize_f64(sub_f64(corner[k], p)),
                 b = normalize_f64(sub_f64(corner[(k + 1) % count], p));
        vec3_f64 g = cross_f64(a, b);
        sum += atan2(length_f64(g), dot_f64(a, b)) * dot_f64(normalize_f64(g), n);
    }
    return fabs(sum) / (2 * M_PI);
}

/* Triangles of any shape, from 1e-6 to 1e6 of their distance, at any tilt, in frames that turn and stretch.
 */
UNIT_TEST(any_triangle_sends_lamberts_edge_sum) {
    random_state r = {7};
    for (int trial = 0; trial < 60; ++trial) {
        double size = random_log(&r, 1e-6, 0.5);
        vec3_f64 corner[3], at = {0, 0, 2};
        float p[3][3];
        static const uint32_t index[3] = {0, 1, 2};
        for (int k = 0; k < 3; ++k) {
            corner[k] = madd_f64(at, 1.9 * size, random_direction(&r));
            store_f32(p[k], narrow(corner[k]));
            corner[k] = widen(load_f32(p[k]));
        }
        fathom_mesh mesh = default_mesh();
        mesh.positions = p[0], mesh.vertex_count = 3, mesh.indices = index, mesh.triangle_count = 1;
        mesh.material = emission(1, 1, 1);
        assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
        open_light();
        mean m = irradiance(origin, up, 200);
        double expected = edge_sum(origin, up, corner, 3);
        assert_near(mean_of(&m), expected, errors * error_of(&m) + 4e-6 * expected);
        begin_light(state);
    }
}

UNIT_TEST(a_sphere_sends_its_share_of_the_sky) {
    random_state r = {3};
    for (int trial = 0; trial < 40; ++trial) {
        double d = random_log(&r, 1, 1e6), radius = d * random_log(&r, 1e-6, 0.5);
        double most = M_PI / 2 - asin(radius / d), theta = random_in(&r, 0, most);
        add_sphere(FATHOM_ROOT, vec_f64(d * sin(theta), 0, d * cos(theta)), radius, emission(1, 1, 1));
        open_light();
        mean m = irradiance(origin, up, 200);
        double expected = pow(radius / d, 2) * cos(theta);
        assert_near(mean_of(&m), expected, errors * error_of(&m) + 4e-6 * expected);
        begin_light(state);
    }
}

UNIT_TEST(the_horizon_cuts_a_sphere) {
    const double theta[2] = {1.3, 1.8}, expected[2] = {0.08923406, 0.01210569}, radius = sqrt(0.3);
    for (int k = 0; k < 2; ++k) {
        add_sphere(FATHOM_ROOT, vec_f64(sin(theta[k]), 0, cos(theta[k])), radius, emission(1, 1, 1));
        open_light();
        assert_irradiance(origin, up, expected[k]);
        begin_light(state);
    }
}

UNIT_TEST(inside_a_sphere_light_comes_from_everywhere) {
    add_sphere(FATHOM_ROOT, vec_f64(0.2, 0.3, -0.4), 1, emission(1, 1, 1));
    open_light();
    assert_irradiance(origin, up, 1);
    /* And on its inner surface. */
    assert_irradiance(vec_f64(0.2, 0.3, -1.4), up, 1);
    /* But not on the outer one, where it lies behind. */
    assert_irradiance(vec_f64(0.2, 0.3, 0.6), up, 0);
}

UNIT_TEST(a_constant_background_sends_its_radiance) {
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0.7f, 0.1f, 0.2f}));
    open_light();
    assert_irradiance(origin, up, 0.7);
}

UNIT_TEST(a_point_light_falls_off_by_the_square) {
    add_point(vec_f64(0, 0, 2), 3);
    open_light();
    assert_irradiance(origin, up, 0.75); /* k_l / d² */
}

/* A flattened sphere against rays in all directions. */
UNIT_TEST(an_ellipsoid_sends_what_rays_find) {
    fathom_instance place = default_instance();
    const fathom_id group = new_group(scene, NULL);
    add_sphere(group, vec_f64(0.1, 0, 0), 0.5, emission(1, 1, 1));
    const double map[12] = {1.5, 0.3, 0, 0.2, 0, 0.4, 0.2, -0.3, 0.1, 0, 0.8, 1.2};
    memcpy(place.transform, map, sizeof map), place.group = group;
    assert_ok(context, fathom_scene_add_instance(scene, &place, NULL));
    open_light();
    affine_f64 to_world, to_object;
    affine_load(&to_world, map);
    assert_true(affine_invert(&to_world, &to_object));
    vec3_f64 from = sub_f64(affine_point(&to_object, origin), vec_f64(0.1, 0, 0));
    random_state r = {5};
    mean found = {0}, density = {0};
    emitter_hit hit = {.geometry = 0, .instance = 0};
    while (hit.geometry < w->geometries.count && w->geometries.items[hit.geometry].kind != WORLD_SPHERES)
        ++hit.geometry;
    for (int k = 0; k < 400000; ++k) {
        vec3_f64 d = random_direction(&r), o = affine_vector(&to_object, d);
        double b = dot_f64(from, o), c = dot_f64(from, from) - 0.25, a = dot_f64(o, o);
        bool meets = b < 0 && b * b > a * c;
        take(&found, meets ? 4 * fmax(d.z, 0) : 0);
        float at = emitters_hit_density(e, narrow(origin), narrow(up), narrow(d), &hit);
        take(&density, meets ? 4 * M_PI * (double)at : 0);
    }
    mean m = irradiance(origin, up, BLOCKS);
    assert_near(mean_of(&m), mean_of(&found), errors * hypot(error_of(&m), error_of(&found)));
    assert_near(mean_of(&density), 1, errors * error_of(&density));
}

/* ---- many lights ---- */

/* Small spheres in a box, some of them instanced, and lamps. */
static uint32_t many(random_state *r, uint32_t count, vec3_f64 *at) {
    const fathom_id group = new_group(scene, NULL);
    add_sphere(group, origin, 0.003, emission(5, 1, 2));
    for (uint32_t k = 0; k < count; ++k) {
        at[k] = vec_f64(random_in(r, -4, 4), random_in(r, -4, 4), random_in(r, -4, 4));
        float strength = (float)random_log(r, 0.01, 100);
        if (k % 3 == 1) {
            fathom_instance place = default_instance();
            place.group = group, place.transform[3] = at[k].x, place.transform[7] = at[k].y,
            place.transform[11] = at[k].z;
            assert_ok(context, fathom_scene_add_instance(scene, &place, NULL));
        } else if (k % 3 == 2) {
            add_point(at[k], strength);
        } else {
            add_sphere(FATHOM_ROOT, at[k], 0.002, emission(strength, 1, 1));
        }
    }
    return count;
}

static uint32_t nearest(const vec3_f64 *at, uint32_t count, vec3_f64 p) {
    uint32_t best = 0;
    for (uint32_t k = 1; k < count; ++k) {
        if (length_f64(sub_f64(at[k], p)) < length_f64(sub_f64(at[best], p))) best = k;
    }
    return best;
}

/* chi²: how often each of 90 lights is taken, against the chances that samples state. Wilson and Hilferty
 * 1931 turn the sum into a normal number. */
UNIT_TEST(lights_are_taken_as_often_as_their_samples_say) {
    enum { COUNT = 90 };
    random_state r = {11};
    vec3_f64 at[COUNT];
    many(&r, COUNT, at);
    open_light();
    const vec3_f64 p = {0.3, -0.2, 0.1};
    double taken[COUNT] = {0}, chance[COUNT] = {0}, sum = 0, chi = 0, all = 0, none = 0;
    emitter_query q;
    fill_query(&q, p, up);
    for (int b = 0; b < 6000; ++b) {
        lanes3 u;
        emitter_sample s;
        fill_numbers(&r, u);
        emitters_sample(e, &q, u, &s);
        for (int i = 0; i < LANES; ++i) {
            if (!(s.density[i] > 0)) {
                ++none, ++all;
                continue;
            }
            vec3_f64 to = madd_f64(p, (double)s.distance[i], widen(lane(s.direction, i)));
            uint32_t k = nearest(at, COUNT, to);
            double d = length_f64(sub_f64(at[k], p)), radius = k % 3 == 1 ? 0.003 : 0.002;
            double angle = 2 * M_PI * (1 - sqrt(1 - pow(radius / d, 2)));
            ++taken[k], ++all;
            chance[k] = (double)s.density[i] * (s.sized[i] ? angle : 1);
        }
    }
    int cells = 0;
    double rare = 0, rare_taken = 0;
    for (int k = 0; k < COUNT; ++k) {
        double expected = chance[k] * all;
        sum += chance[k];
        if (expected < 20) {
            rare += expected, rare_taken += taken[k];
            continue;
        }
        chi += pow(taken[k] - expected, 2) / expected, ++cells;
    }
    if (rare > 5) chi += pow(rare_taken - rare, 2) / rare, ++cells;
    double f = 2.0 / (9 * (cells - 1)), z = (cbrt(chi / (cells - 1)) - (1 - f)) / sqrt(f);
    assert_true(fabs(z) < errors);
    /* Some choose none, where all that they could choose lies below the horizon. Those never taken are
     * missing from the sum: fewer than one in 96,000 samples each. */
    assert_near(sum + none / all, 1, errors * 0.5 / sqrt(all) + 1e-3);
}

/* The sphere or quad whose surface is nearest, of small ones far apart. */
static emitter_hit nearest_primitive(vec3_f64 to) {
    emitter_hit hit = {.instance = FATHOM_NONE};
    double best = INFINITY;
    for (uint32_t g = 0; g < w->geometries.count; ++g) {
        const world_geometry *in = &w->geometries.items[g];
        const bool root = g < w->groups.items[0].count;
        for (uint32_t k = 0; k < (root ? in->count : (uint32_t)w->instances.count); ++k) {
            const world_sphere *ball = &w->spheres.items[in->first + (root ? k : 0)];
            double off = fabs(to.x - (6 - w->origin.x));
            if (in->kind == WORLD_SPHERES) {
                vec3_f64 c = widen(ball->center);
                const float(*m)[4] = root ? NULL : w->instances.items[k].to_world;
                if (m) c = vec_f64((double)m[0][3], (double)m[1][3], (double)m[2][3]);
                off = fabs(length_f64(sub_f64(to, c)) - (double)ball->radius);
            }
            if (off >= best) continue;
            best = off, hit.geometry = g;
            hit.primitive = root ? k : 0, hit.instance = root ? FATHOM_NONE : k;
        }
    }
    return hit;
}

/* What a sample says of its direction, a ray that goes there by chance gets as well. */
static void expect_own_densities(random_state *r, int least) {
    int sized = 0;
    for (int b = 0; b < 400; ++b) {
        const vec3_f64 p = {random_in(r, -4, 4), random_in(r, -4, 4), random_in(r, -4, 4)};
        const vec3_f64 n = b % 3 ? random_direction(r) : origin;
        const vec3_f32 at_world = narrow(sub_f64(p, w->origin));
        emitter_query q;
        lanes3 u, radiance;
        emitter_sample s;
        float outside[LANES];
        fill_query(&q, p, n);
        fill_numbers(r, u);
        emitters_sample(e, &q, u, &s);
        emitters_outside(e, (1u << LANES) - 1, q.p, q.n, s.direction, radiance, outside);
        for (int i = 0; i < LANES; ++i) {
            if (!s.sized[i] || !(s.density[i] > 0)) continue;
            vec3_f32 d = lane(s.direction, i);
            float density = outside[i];
            if (isfinite(s.distance[i])) {
                vec3_f64 to = madd_f64(widen(at_world), (double)s.distance[i], widen(d));
                emitter_hit hit = nearest_primitive(to);
                density = emitters_hit_density(e, at_world, narrow(n), d, &hit);
                assert_true(outside[i] == 0 && radiance[0][i] == 0.1f);
            }
            ++sized;
            assert_near(density, s.density[i], 1e-5 * (double)s.density[i]);
        }
    }
    assert_true(sized > least);
}

UNIT_TEST(a_hit_gets_the_density_of_its_sample) {
    enum { COUNT = 60 };
    random_state r = {13};
    vec3_f64 at[COUNT];
    many(&r, COUNT, at);
    add_quad((double[3]){6, 0, 0}, (double[3]){0, 1, 0}, (double[3]){0, 0.3, 1}, emission(3, 1, 1));
    /* Light samples leave an even background to other rays, if there is another light. */
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0.1f, 0.1f, 0.1f}));
    open_light();
    expect_own_densities(&r, 100);
}

UNIT_TEST(the_background_gets_the_density_of_its_sample) {
    random_state r = {14};
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0.1f, 0.1f, 0.1f}));
    open_light();
    expect_own_densities(&r, 1000);
}

/* A lamp next to the point and a million times weaker ones far away, and so for others. */
UNIT_TEST(many_lights_send_the_sum_of_each) {
    enum { COUNT = 200 };
    random_state r = {17};
    double expected = 0;
    for (int k = 0; k < COUNT; ++k) {
        vec3_f64 at = scale_f64(random_log(&r, 0.1, 100), random_direction(&r));
        float strength = (float)random_log(&r, 1e-3, 1e3);
        add_point(at, strength);
        double d = length_f64(at);
        expected += (double)strength * fmax(at.z, 0) / (d * d * d);
    }
    open_light();
    assert_irradiance(origin, up, expected);
}

/* Boxes of the tree stick out above a horizon that all lights are below. */
UNIT_TEST(lights_below_the_horizon_send_nothing) {
    random_state r = {29};
    for (int trial = 0; trial < 200; ++trial) {
        const vec3_f64 n = random_direction(&r);
        for (int k = 0; k < 60; ++k) {
            const vec3_f64 d = scale_f64(random_log(&r, 0.1, 1), random_direction(&r));
            const double off = dot_f64(d, n) + random_log(&r, 1e-3, 0.1);
            add_point(madd_f64(d, -off, n), (float)random_log(&r, 1e-3, 1e3));
        }
        open_light();
        mean m = irradiance(origin, n, 4);
        assert_true(mean_of(&m) == 0);
        begin_light(state);
    }
}

/* A lamp of any size lights as one without does, where it is wholly above the horizon. */
UNIT_TEST(a_lamps_radius_leaves_its_light) {
    random_state r = {19};
    for (int trial = 0; trial < 10; ++trial) {
        fathom_light light = default_light();
        light.position[2] = 2, light.radius = (float)random_log(&r, 1e-6, 1.9);
        light.intensity[0] = 3;
        assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
        open_light();
        assert_irradiance(origin, up, 0.75);
        begin_light(state);
    }
}

/* A surface that faces the middle of the disc gets the sun's irradiance, whatever the disc's size. */
UNIT_TEST(a_suns_disc_sends_its_irradiance) {
    random_state r = {23};
    for (int trial = 0; trial < 10; ++trial) {
        fathom_light light = default_light();
        light.type = FATHOM_LIGHT_DIRECTIONAL, light.angular_radius = (float)random_log(&r, 1e-6, 1.5);
        light.direction[1] = 0, light.direction[2] = -1;
        assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
        open_light();
        assert_irradiance(origin, up, 1);
        begin_light(state);
    }
}

UNIT_TEST(nothing_sends_nothing) {
    open_light();
    assert_true(emitters_none(e));
    mean m = irradiance(origin, up, 2);
    assert_true(mean_of(&m) == 0);
}

/* ---- blocks ---- */

static void add_triangle(random_state *r, fathom_id material) {
    static const uint32_t index[3] = {0, 1, 2};
    const vec3_f64 at = {random_in(r, -4, 4), random_in(r, -4, 4), random_in(r, -4, 4)};
    float p[3][3];
    for (int k = 0; k < 3; ++k)
        store_f32(p[k], narrow(madd_f64(at, random_log(r, 1e-3, 3), random_direction(r))));
    fathom_mesh mesh = default_mesh();
    mesh.positions = p[0], mesh.vertex_count = 3, mesh.indices = index, mesh.triangle_count = 1;
    mesh.material = material;
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
}

static void add_any_quad(random_state *r, fathom_id material) {
    const vec3_f64 at = scale_f64(4, random_direction(r)),
                   u = scale_f64(random_log(r, 1e-3, 3), random_direction(r)),
                   v = scale_f64(random_log(r, 1e-3, 3), cross_f64(u, random_direction(r)));
    add_quad((double[3]){at.x, at.y, at.z}, (double[3]){u.x, u.y, u.z}, (double[3]){v.x, v.y, v.z}, material);
}

static void add_lamp(random_state *r) {
    fathom_light light = default_light();
    store_f64(light.position, scale_f64(random_in(r, 0, 4), random_direction(r)));
    store_f64(light.direction, random_direction(r));
    const double kind = random_unit(r);
    if (kind < 0.5) light.type = FATHOM_LIGHT_SPOT;
    if (kind > 0.8) light.type = FATHOM_LIGHT_DIRECTIONAL;
    if (kind > 0.9) light.angular_radius = (float)random_log(r, 1e-3, 1);
    if (kind < 0.8 && random_unit(r) < 0.5) light.radius = (float)random_log(r, 1e-3, 1);
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

static void add_stretched(random_state *r, fathom_id material) {
    fathom_instance place = default_instance();
    const fathom_id group = new_group(scene, NULL);
    add_sphere(group, origin, random_log(r, 0.01, 1), material);
    place.group = group;
    for (int k = 0; k < 12; ++k) place.transform[k] = k % 5 ? random_in(r, -0.3, 0.3) : random_in(r, 0.5, 2);
    assert_ok(context, fathom_scene_add_instance(scene, &place, NULL));
}

static void add_any(random_state *r) {
    const fathom_id material = emission((float)random_in(r, 0.1, 5), 1, 2);
    switch ((int)(random_unit(r) * 5)) {
    case 0: add_triangle(r, material); break;
    case 1: add_any_quad(r, material); break;
    case 2: add_lamp(r); break;
    case 3: add_stretched(r, material); break;
    default: add_sphere(FATHOM_ROOT, scale_f64(4, random_direction(r)), random_log(r, 0.01, 3), material);
    }
}

/* All that a sample says of one lane. Where there is no light, the rest is of no meaning. */
typedef struct lane_sample {
    vec3_f32 direction, radiance;
    float distance, density;
    uint32_t sized;
} lane_sample;

static lane_sample sampled(const emitter_query *q, const lanes3 u, int i) {
    lane_sample out;
    emitter_sample s;
    emitters_sample(e, q, u, &s);
    memset(&out, 0, sizeof out);
    if (!(s.density[i] > 0)) return out;
    out.direction = lane(s.direction, i), out.radiance = lane(s.radiance, i);
    out.distance = s.distance[i], out.density = s.density[i], out.sized = s.sized[i];
    return out;
}

static void random_query(random_state *r, emitter_query *q, lanes3 u) {
    fill_numbers(r, u);
    for (int i = 0; i < LANES; ++i) {
        const vec3_f64 p = sub_f64(scale_f64(random_in(r, 0, 5), random_direction(r)), w->origin);
        put_lane_f32(q->p, (unsigned)i, narrow(p));
        put_lane_f32(q->n, (unsigned)i,
                     random_unit(r) < 0.1 ? vec_f32(0, 0, 0) : narrow(random_direction(r)));
        q->time[i] = 0;
    }
}

static void spread(emitter_query *q, lanes3 u, int from) {
    const vec3_f32 p = lane(q->p, from), n = lane(q->n, from), numbers = lane(u, from);
    for (unsigned i = 0; i < LANES; ++i) {
        put_lane_f32(q->p, i, p), put_lane_f32(q->n, i, n), put_lane_f32(u, i, numbers);
    }
}

UNIT_TEST(no_lane_depends_on_its_neighbours) {
    random_state r = {31};
    for (int trial = 0; trial < 300; ++trial) {
        const int lights = 1 + (int)(random_unit(&r) * (trial % 2 ? 12 : 2));
        for (int k = 0; k < lights; ++k) add_any(&r);
        if (trial % 5 == 0)
            assert_ok(context, fathom_scene_set_background(scene, (float[3]){0.1f, 0.2f, 0.3f}));
        open_light();
        for (int b = 0; b < 60; ++b) {
            emitter_query q;
            lanes3 u;
            random_query(&r, &q, u);
            const int i = (int)(random_unit(&r) * LANES);
            const lane_sample among = sampled(&q, u, i);
            spread(&q, u, i);
            const lane_sample alone = sampled(&q, u, i);
            assert_memory_equal(&among, &alone, sizeof among);
        }
        begin_light(state);
    }
}

int main(void) { return unit_main_each(begin_light, NULL); }
