/* The reference BVH answers what linear search answers, to the last bit: the same primitive, the same t. */
#include "stage.h"

#include "trace/bvh/bvh.h"

/* ---- parity ---- */

/* Bit by bit, lane by lane, hits and shadows; returns how many rays met something. */
static size_t same_as_linear(stage *s, const char *precision, const ray_set *set) {
    char text[32];
    snprintf(text, sizeof text, "bvh:%s", precision);
    trace_tracer *tree = stage_spec(s, text);
    snprintf(text, sizeof text, "linear:%s", precision);
    trace_tracer *linear = stage_spec(s, text);
    size_t blocks = (set->count + 15) / 16, met = 0, differ = 0, any_differ = 0;
    ray_set b = rays_copy(set), l = rays_copy(set);
    trace_fine *bf = unit_memory(blocks * sizeof *bf), *lf = unit_memory(blocks * sizeof *lf);
    unsigned state = trace_thread_begin();
    trace_closest_fine(tree, b.blocks, bf, set->count, TRACE_INCOHERENT);
    trace_closest_fine(linear, l.blocks, lf, set->count, TRACE_INCOHERENT);
    trace_thread_end(state);
    unsigned char *bo = occluded(tree, set, TRACE_INCOHERENT), *lo = occluded(linear, set, TRACE_INCOHERENT);
    for (size_t i = 0; i < set->count; ++i) {
        bool hit = l.blocks[i / 16].hits.geometry[i % 16] != FATHOM_NONE;
        bool same = same_hit(&b, &l, i) && hit_t(&b, i) == hit_t(&l, i);
        if (hit) {
            const trace_fine *x = &bf[i / 16], *y = &lf[i / 16];
            same = same && x->t[i % 16] == y->t[i % 16] && x->t_low[i % 16] == y->t_low[i % 16] &&
                   x->u[i % 16] == y->u[i % 16] && x->v[i % 16] == y->v[i % 16];
        }
        differ += !same, any_differ += bo[i] != lo[i], met += hit;
    }
    assert_int_equal(differ, 0);
    assert_int_equal(any_differ, 0);
    return met;
}

static void check(stage *s, const char *precision, ray_set set) {
    assert_true(same_as_linear(s, precision, &set) > set.count / 10);
}

UNIT_TEST(everything) {
    stage s = stage_open();
    add_everything(&s);
    stage_spec(&s, "bvh");
    check(&s, "f32", random_rays(20000));
    check(&s, "f32", edge_rays(s.world, 20000));
    check(&s, "f32", camera_rays(120));
    check(&s, "f64", random_rays(2000));
    check(&s, "f64", edge_rays(s.world, 2000));
    check(&s, "f128", random_rays(40));
}

/* Triangles of all sizes, from points to slivers that cross the scene, many through each other. */
static void add_soup(stage *s, uint32_t triangles, double reach) {
    float *p = unit_memory(triangles * 9 * sizeof *p);
    uint32_t *index = unit_memory(triangles * 3 * sizeof *index);
    for (uint32_t i = 0; i < triangles; ++i) {
        double size = pow(10, between(-4, 0.3));
        for (int k = 0; k < 3; ++k) {
            double c = between(-reach, reach);
            for (int v = 0; v < 3; ++v) {
                double thin = i % 5 == 0 && v == 2 ? 1e-4 : 1;
                p[9 * i + 3 * (uint32_t)v + (uint32_t)k] = (float)(c + thin * size * between(-1, 1));
            }
        }
        for (uint32_t v = 0; v < 3; ++v) index[3 * i + v] = 3 * i + v;
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 3 * triangles;
    mesh.indices = index, mesh.triangle_count = triangles;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

/* At vertices and along edges of the soup, where every rounding counts; from inside and from afar. */
static ray_set aimed_rays(const world *w, size_t count, double reach) {
    const fathom_mesh *m = &w->meshes.items[0];
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count; ++i) {
        size_t t = 3 * (size_t)(uniform() * m->triangle_count), c = (size_t)(uniform() * 3);
        const float *a = &m->positions[3 * (size_t)m->indices[t + c]];
        const float *b = &m->positions[3 * (size_t)m->indices[t + (c + 1) % 3]];
        double f = i % 4 ? uniform() : 0, target[3], org[3];
        double from = i % 3 ? reach : 100 * reach;
        for (int k = 0; k < 3; ++k) {
            target[k] = (double)a[k] + f * ((double)b[k] - (double)a[k]);
            org[k] = i % 7 == (size_t)k ? target[k] : between(-from, from); /* along a coordinate plane */
        }
        ray_towards(&set, i, org, target);
    }
    return set;
}

UNIT_TEST(soup) {
    stage s = stage_open();
    add_soup(&s, 100000, 4);
    stage_spec(&s, "bvh");
    check(&s, "f32", aimed_rays(s.world, 200, 4));
    check(&s, "f64", aimed_rays(s.world, 16, 4));
    s = stage_open();
    add_soup(&s, 10000, 1);
    stage_spec(&s, "bvh");
    check(&s, "f32", aimed_rays(s.world, fewer(1200), 1));
    check(&s, "f64", aimed_rays(s.world, 100, 1));
    check(&s, "f128", aimed_rays(s.world, 4, 1));
}

/* Everything twice and more: the first in world order stays, whatever the tree looks like. */
UNIT_TEST(ties) {
    stage s = stage_open();
    const double center[3] = {0.2, 0, 0}, u[3] = {0.7, 0, 0}, v[3] = {0, 0.7, 0};
    const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const fathom_id group = new_group(s.scene, "again");
    for (int i = 0; i < 3; ++i) add_grid(&s, 24, 0);
    for (int i = 0; i < 9; ++i) add_quad(&s, FATHOM_ROOT, center, i % 2 ? u : v, i % 2 ? v : u, 0);
    for (int i = 0; i < 9; ++i) add_sphere(&s, FATHOM_ROOT, 0.5, 0.5, 0, 0.3, 0);
    add_ball(&s, group, 12, 0, 0.5, 0, 0), add_ball(&s, group, 12, 0, 0.5, 0, 0);
    for (int i = 0; i < 3; ++i) add_instance(&s, group, identity);
    add_plane(&s, 0, 0);
    stage_spec(&s, "bvh");
    check(&s, "f32", camera_rays(40));
    check(&s, "f32", edge_rays(s.world, 1000));
    check(&s, "f64", camera_rays(25));
}

/* Spheres by their silhouettes, small and large, near and far. */
UNIT_TEST(silhouettes) {
    stage s = stage_open();
    ray_set set = silhouette_rays(&s, 200, -4, 8000, -2, 6);
    same_as_linear(&s, "f32", &set);
    same_as_linear(&s, "f64", &set);
}

/* A triangle of aspect 10^4 around c. */
static void add_sliver(stage *s, fathom_id group, const double c[3]) {
    static const uint32_t index[] = {0, 1, 2};
    float *p = unit_memory(9 * sizeof *p);
    for (int k = 0; k < 3; ++k) {
        double along = between(-1, 1);
        p[k] = (float)(c[k] - along), p[3 + k] = (float)(c[k] + along);
        p[6 + k] = (float)(c[k] + 1e-4 * between(-1, 1));
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 3, mesh.indices = index, mesh.triangle_count = 1;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

/* Instances squeezed, sheared, mirrored, far from the origin, and within one another's boxes; from near by
 * and from as far as float lets a ray find them, where carrying it into their space moves it by their size.
 */
UNIT_TEST(instances) {
    stage s = stage_open();
    const fathom_id group = new_group(s.scene, "group");
    add_ball(&s, group, SANITIZED ? 6 : 16, 0.1, 1, 0, 0);
    add_sphere(&s, group, 2, 0, 0, 0.5, 0);
    const double center[3] = {0, 2, 0}, u[3] = {0.5, 0, 0}, v[3] = {0, 0.2, 0.5};
    add_quad(&s, group, center, u, v, 0);
    for (int i = 0; i < 200; ++i) {
        double m[12], size = pow(10, between(-3, 1));
        for (int k = 0; k < 12; ++k) m[k] = k % 4 == 3 ? between(-30, 30) : size * between(-1, 1);
        if (i % 10 == 0) m[0] *= 1e-3, m[1] *= 1e-3, m[2] *= 1e-3;
        if (i % 20 == 0) m[3] += 1e4;
        add_instance(&s, group, m);
    }
    stage_spec(&s, "bvh");
    ray_set set = rays_new(480);
    for (size_t i = 0; i < set.count; ++i) {
        const float(*m)[4] = s.world->instances.items[i % s.world->instances.count].to_world;
        double p[3] = {between(-1, 1), between(-1, 1), between(-1, 1)}, target[3], org[3];
        for (int k = 0; k < 3; ++k) {
            target[k] =
                (double)m[k][0] * p[0] + (double)m[k][1] * p[1] + (double)m[k][2] * p[2] + (double)m[k][3];
            org[k] = between(-40, 40) + (i % 3 ? 0 : target[k]);
        }
        if (i % 4 == 0) {
            double far = pow(10, between(2, 8)), away[3] = {between(-1, 1), between(-1, 1), between(-1, 1)};
            for (int k = 0; k < 3; ++k) org[k] = target[k] + far * away[k];
        }
        ray_towards(&set, i, org, target);
    }
    assert_true(same_as_linear(&s, "f32", &set) > 72);
    set.count = 100;
    assert_true(same_as_linear(&s, "f64", &set) > 12);
}

/* A map of random shape whose inverse shrinks by up to a thousand. */
static void random_map(double m[12]) {
    for (int k = 0; k < 12; ++k) m[k] = k % 4 == 3 ? between(-5, 5) : between(-1, 1);
    double thin = pow(10, between(-3, 0));
    for (int k = 0; k < 3; ++k) m[4 + k] = thin * m[4 + k] + (1 - thin) * m[k];
}

/* One thing alone, so that its box is no larger than itself: a sphere, a sphere in an instance, a sliver in
 * an instance. From so far that float moves rays by the thing's own size, and carrying them by more: a box
 * without slack would stand beside what the intersector meets. */
UNIT_TEST(lone_boxes) {
    size_t met = 0;
    for (int round = 0; round < 60; ++round) {
        stage s = stage_open();
        seed += 7919 * (uint64_t)round;
        double m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
               c[3] = {between(-9, 9), between(-9, 9), between(-9, 9)};
        fathom_id group = FATHOM_ROOT;
        if (round % 3) {
            assert_ok(s.context, fathom_scene_add_group(s.scene, "group", &group));
            random_map(m);
            add_instance(&s, group, m);
        }
        if (round % 3 < 2)
            add_sphere(&s, group, c[0], c[1], c[2], 1, 0);
        else
            add_sliver(&s, group, c);
        stage_spec(&s, "bvh");
        ray_set set = rays_new(1600);
        for (size_t i = 0; i < set.count; ++i) {
            double far = pow(10, between(0, 8)), p[3], target[3], org[3];
            for (int k = 0; k < 3; ++k) p[k] = c[k] + between(-1, 1);
            for (int k = 0; k < 3; ++k) {
                target[k] = m[4 * k] * p[0] + m[4 * k + 1] * p[1] + m[4 * k + 2] * p[2] + m[4 * k + 3];
                org[k] = target[k] + far * (i % 5 == (size_t)k ? 0 : between(-1, 1));
            }
            store_f64(target, sub_f64(load_f64(target), s.world->origin));
            store_f64(org, sub_f64(load_f64(org), s.world->origin));
            ray_towards(&set, i, org, target);
        }
        met += same_as_linear(&s, "f32", &set) + same_as_linear(&s, "f64", &set);
    }
    assert_true(met > 60 * 300);
}

/* ---- scales, damage, nothing ---- */

UNIT_TEST(scales) {
    const double reaches[] = {1e-12, 1e-6, 1e6, 1e15};
    for (int i = 0; i < 4; ++i) {
        stage s = stage_open();
        add_soup(&s, 300, reaches[i]);
        float *p = (float *)(uintptr_t)s.scene->meshes.items[0].positions;
        if (i == 0) { /* all of the triangles tiny, too */
            for (int k = 0; k < 2700; ++k) p[k] *= 1e-12f;
        }
        stage_spec(&s, "bvh");
        ray_set set = aimed_rays(s.world, 1500, reaches[i]);
        same_as_linear(&s, "f32", &set);
        same_as_linear(&s, "f64", &set);
        for (size_t r = 0; r < set.count; ++r) { /* directions of other lengths, intervals that end */
            trace_rays *rays = &set.blocks[r / 16].rays;
            float scale = r % 2 ? 1e15f : 1e-15f;
            rays->dir_x[r % 16] *= scale, rays->dir_y[r % 16] *= scale, rays->dir_z[r % 16] *= scale;
            rays->t_near[r % 16] = 0.5f / scale, rays->t_far[r % 16] = 1.5f / scale;
        }
        same_as_linear(&s, "f32", &set);
        same_as_linear(&s, "f64", &set);
    }
}

UNIT_TEST(damaged_triangles_are_left_out) {
    stage s = stage_open();
    add_soup(&s, 1000, 1);
    float *p = (float *)(uintptr_t)s.scene->meshes.items[0].positions;
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e30f};
    for (size_t i = 0; i < 200; ++i) p[(size_t)(uniform() * 9000)] = bad[i % 6];
    for (size_t i = 0; i < 50; ++i) memcpy(p + 90 * i, p + 90 * i + 3, 12); /* no area */
    stage_spec(&s, "bvh");
    check(&s, "f32", random_rays(5000));
    check(&s, "f64", random_rays(1000));
    for (size_t i = 0; i < 9000; ++i) p[i] = NAN;
    ray_set set = random_rays(64);
    assert_int_equal(same_as_linear(&s, "f32", &set), 0);
}

UNIT_TEST(shadows_and_planes) {
    stage s = stage_open();
    add_shadow_columns(&s);
    add_plane(&s, -11, 0);
    stage_spec(&s, "bvh");
    check(&s, "f32", random_rays(5000));
    check(&s, "f64", random_rays(1000));
    s = stage_open(); /* nothing at all */
    ray_set set = random_rays(16);
    stage_spec(&s, "bvh");
    assert_int_equal(same_as_linear(&s, "f32", &set), 0);
}

/* ---- building ---- */

/* Each item in one leaf, within every box above it. */
static uint32_t holds(const bvh_tree *tree, const bvh_item *items, uint32_t at, unsigned level) {
    const bvh_node *node = &tree->nodes[at];
    assert_in_range(level, 0, 79);
    uint32_t below = 0, first = node->count ? node->first : 0;
    for (uint32_t i = first; i < first + node->count; ++i) {
        for (int k = 0; k < 3; ++k) {
            assert_true(items[i].lower[k] >= node->lower[k] && items[i].upper[k] <= node->upper[k]);
        }
    }
    if (node->count) return node->count;
    for (uint32_t c = node->first; c < node->first + 2; ++c) {
        for (int k = 0; k < 3; ++k) {
            assert_true(tree->nodes[c].lower[k] >= node->lower[k] &&
                        tree->nodes[c].upper[k] <= node->upper[k]);
        }
        below += holds(tree, items, c, level + 1);
    }
    return below;
}

/* Items that no plane parts (all in one place), and items that each split peels off one by one. */
UNIT_TEST(hard_cases_end) {
    enum { count = 20000 };
    bvh_item *items = unit_memory(count * sizeof *items);
    for (int hard = 0; hard < 2; ++hard) {
        for (uint32_t i = 0; i < count; ++i) {
            items[i].id = i;
            float x = hard ? ldexpf(1, -(int)(i % 140)) : 1;
            for (int k = 0; k < 3; ++k) items[i].lower[k] = items[i].upper[k] = k ? 0 : x;
        }
        const bvh_build build = {.context = NULL};
        bvh_tree tree = {0};
        assert_int_equal(bvh_tree_build(&build, items, count, &tree), FATHOM_OK);
        assert_int_equal(holds(&tree, items, 0, 0), count);
        free(tree.nodes);
    }
}

static bool stop_at(void *user, double fraction) {
    double *at = user;
    assert_true(fraction >= 0 && fraction <= 1);
    return fraction < *at;
}

UNIT_TEST(building_can_be_stopped) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 100, 0.05, 1, 0, 0);
    stage_world(&s);
    trace_spec spec;
    assert_ok(s.context, trace_spec_parse(s.context, "bvh", &spec));
    double at = 0;
    trace_options options = {.spec = &spec, .threads = 2, .progress = stop_at, .user = &at};
    trace_tracer *tracer = NULL;
    assert_fails(s.context, trace_create(s.context, s.world, &options, &tracer), FATHOM_INTERRUPTED,
                 "stopped");
    assert_null(tracer);
    at = 2;
    assert_ok(s.context, trace_create(s.context, s.world, &options, &tracer));
    assert_string_equal(trace_name(tracer), "reference BVH, f32");
    assert_true(trace_bvh_bytes(tracer) > 4 * 100 * 99 * sizeof(uint32_t));
    trace_destroy(tracer);
}

int main(void) { return unit_main(NULL, NULL); }
