/* Generated meshes: their counts, that they are whole, and that nothing but the options decides them. */
#include "owned.h"
#include "scene/graph.h"
#include "unit_context.h"

#include <fathom/read.h>
#include <unistd.h>

static fathom_scene *generate(fathom_generator kind, uint64_t triangles, uint64_t seed) {
    fathom_scene *scene = new_scene(context);
    fathom_generate_options options = default_generate_options();
    options.kind = kind, options.triangles = triangles, options.seed = seed;
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    assert_ok(context, fathom_scene_check(scene));
    return scene;
}

/* Triangles of everything that is placed. */
static uint64_t placed_triangles(const fathom_scene *scene) {
    scene_graph graph;
    assert_ok(context, graph_create(scene, &graph));
    uint64_t *ways = calloc(scene->groups.count, sizeof *ways), total = 0;
    assert_non_null(ways);
    ways[FATHOM_ROOT] = 1;
    for (uint32_t k = 0; k < graph.order_count; ++k) {
        uint32_t g = graph.order[k];
        for (uint32_t i = graph.objects.first[g]; i < graph.objects.first[g + 1]; ++i) {
            scene_object object = scene->objects.items[graph.objects.items[i]];
            total += ways[g] * scene->meshes.items[object.index].triangle_count;
        }
        for (uint32_t i = graph.instances.first[g]; i < graph.instances.first[g + 1]; ++i)
            ways[scene->instances.items[graph.instances.items[i]].group] += ways[g];
    }
    free(ways);
    graph_destroy(&graph);
    return total;
}

static vec3_f64 vertex(const fathom_mesh *mesh, uint32_t i) {
    return widen(load_f32(mesh->positions + (size_t)i * 3));
}

static vec3_f64 facet(const fathom_mesh *mesh, uint32_t triangle) {
    const uint32_t *t = mesh->indices + (size_t)triangle * 3;
    vec3_f64 a = vertex(mesh, t[0]);
    return cross_f64(sub_f64(vertex(mesh, t[1]), a), sub_f64(vertex(mesh, t[2]), a));
}

static int compare_u64(const void *a, const void *b) {
    uint64_t x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return x < y ? -1 : x > y;
}

/* Each directed edge comes once, and so does its opposite: closed, and the same side is out everywhere.
 * Returns V - E + F. */
static int64_t check_closed(const fathom_mesh *mesh) {
    size_t edges = (size_t)mesh->triangle_count * 3;
    uint64_t *there = malloc(edges * sizeof *there), *back = malloc(edges * sizeof *back);
    assert_true(there && back);
    for (size_t i = 0; i < edges; ++i) {
        uint64_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
        there[i] = a << 32 | b, back[i] = b << 32 | a;
    }
    qsort(there, edges, sizeof *there, compare_u64);
    qsort(back, edges, sizeof *back, compare_u64);
    assert_memory_equal(there, back, edges * sizeof *there);
    for (size_t i = 1; i < edges; ++i) assert_true(there[i - 1] < there[i]);
    free(there);
    free(back);
    return (int64_t)mesh->vertex_count - (int64_t)(edges / 2) + mesh->triangle_count;
}

static void check_facets(const fathom_mesh *mesh) {
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) assert_true(length_f64(facet(mesh, t)) > 0);
}

/* A unit vector whose components were each rounded to float: off by at most 2^-24 of itself, and a few
 * roundings of double. Normals lie on the outer side of each facet around them. */
static void check_normals(const fathom_mesh *mesh) {
    assert_int_equal(mesh->normal_count, mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        vec3_f64 n = widen(load_f32(mesh->normals + (size_t)i * 3));
        assert_near(sqrt(dot_f64(n, n)), 1, 0x1p-24 + 16 * 0x1p-53);
    }
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        vec3_f64 f = facet(mesh, t);
        for (int k = 0; k < 3; ++k) {
            uint32_t i = mesh->indices[(size_t)t * 3 + (size_t)k];
            assert_true(dot_f64(f, widen(load_f32(mesh->normals + (size_t)i * 3))) > 0);
        }
    }
}

static void check_uvs(const fathom_mesh *mesh) {
    assert_int_equal(mesh->uv_count, mesh->vertex_count);
    for (size_t i = 0; i < (size_t)mesh->uv_count * 2; ++i)
        assert_true(mesh->uvs[i] >= 0 && mesh->uvs[i] <= 1);
}

UNIT_TEST(spheres_are_closed) {
    const uint64_t counts[] = {1, 20, 80, 100, 180, 1000, 20000, 300000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        fathom_scene *scene = generate(FATHOM_GENERATE_SPHERE, counts[c], c);
        const fathom_mesh *mesh = &scene->meshes.items[0];
        assert_int_equal(check_closed(mesh), 2);
        check_normals(mesh);
        check_uvs(mesh);
        /* Star-shaped around the origin: each triangle and the origin span a positive volume. */
        for (uint32_t t = 0; t < mesh->triangle_count; ++t)
            assert_true(dot_f64(facet(mesh, t), vertex(mesh, mesh->indices[(size_t)t * 3])) > 0);
        scene_bounds bounds;
        assert_ok(scene->context, scene_world_bounds(scene, &bounds));
        assert_true(bounds.lower.x > -1.5 && bounds.upper.x < 1.5 && bounds.upper.x - bounds.lower.x > 1.2);
    }
}

/* Displacement is along the radius: brought back to the unit sphere, the largest triangle has at most 1.2
 * times the area of the smallest, however fine the grid. */
UNIT_TEST(sphere_triangles_are_even) {
    const uint64_t counts[] = {80, 2000, 20000, 200000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        fathom_scene *scene = generate(FATHOM_GENERATE_SPHERE, counts[c], 3);
        const fathom_mesh *mesh = &scene->meshes.items[0];
        double least = INFINITY, most = 0;
        for (size_t t = 0; t < mesh->triangle_count; ++t) {
            vec3_f64 p[3];
            for (size_t k = 0; k < 3; ++k) p[k] = normalize_f64(vertex(mesh, mesh->indices[t * 3 + k]));
            double area = length_f64(cross_f64(sub_f64(p[1], p[0]), sub_f64(p[2], p[0])));
            least = fmin(least, area), most = fmax(most, area);
        }
        assert_true(most / least < 1.2);
    }
}

static uint64_t off(uint64_t a, uint64_t b) { return a > b ? a - b : b - a; }

/* No other grid comes nearer. */
static void check_square_counts(fathom_generator kind, uint64_t factor) {
    const uint64_t asked[] = {1, 5, 30, 31, 100, 129, 130, 1000, 12345, 250000, 1000000};
    for (size_t c = 0; c < sizeof asked / sizeof *asked; ++c) {
        fathom_scene *scene = generate(kind, asked[c], 0);
        uint64_t count = placed_triangles(scene);
        assert_int_equal(count % factor, 0);
        uint64_t n = (uint64_t)sqrt((double)count / (double)factor);
        assert_int_equal(factor * n * n, count);
        for (uint64_t m = 1; m < n + 3; ++m)
            assert_true(off(count, asked[c]) <= off(factor * m * m, asked[c]));
    }
}

UNIT_TEST(counts_are_nearest) {
    check_square_counts(FATHOM_GENERATE_SPHERE, 20);
    check_square_counts(FATHOM_GENERATE_TERRAIN, 2);
}

UNIT_TEST(terrain_is_one_sheet) {
    fathom_scene *scene = generate(FATHOM_GENERATE_TERRAIN, 20000, 7);
    const fathom_mesh *mesh = &scene->meshes.items[0];
    check_facets(mesh);
    check_normals(mesh);
    check_uvs(mesh);
    /* Seen from above it covers the square [-1,1]² once: all facets look up, and their shadows add up to 4.
     * Each is a sum of products of floats, exact in double but for its roundings. */
    double area = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        vec3_f64 f = facet(mesh, t);
        assert_true(f.y > 0);
        area += f.y / 2;
    }
    assert_near(area, 4, mesh->triangle_count * 4 * 0x1p-53 * 4);
}

/* The boundary of a sponge of depth b: 2·20^b + 4·8^b squares around a volume of 8 (20/27)^b. */
UNIT_TEST(sponge_boundaries_are_closed) {
    const uint64_t triangles[] = {12, 144, 2112, 36096, 672768};
    double volume = 8;
    for (size_t depth = 0; depth < 5; ++depth, volume *= 20.0 / 27) {
        fathom_scene *scene = generate(FATHOM_GENERATE_SPONGE, triangles[depth], 0);
        assert_int_equal(placed_triangles(scene), triangles[depth]);
        assert_int_equal(scene->instances.count, 0);
        const fathom_mesh *mesh = &scene->meshes.items[0];
        int64_t euler = check_closed(mesh);
        if (depth == 0) assert_int_equal(euler, 2);
        if (depth == 1) assert_int_equal(euler, 2 - 2 * 5); /* a cube with three crossing tunnels: genus 5 */
        double sum = 0;
        for (uint32_t t = 0; t < mesh->triangle_count; ++t)
            sum += dot_f64(facet(mesh, t), vertex(mesh, mesh->indices[(size_t)t * 3])) / 6;
        /* Lattice coordinates are thirds rounded to float: each within 2^-25 of the true one, over an
         * area of at most triangles · 3^-2b · 2 around a volume. */
        double area = (double)triangles[depth] * 2 / pow(9, (double)depth);
        assert_near(sum, volume, 2 * area * 0x1p-25);
    }
}

/* Nested: 20 instances a level, twenty times the triangles. No other boundary and level comes
 * nearer to what was asked for. */
UNIT_TEST(sponges_nest) {
    const uint64_t boundary[] = {12, 144, 2112, 36096, 672768};
    const uint64_t asked[] = {1, 200, 240, 5000, 1000000, UINT64_C(10000000000), UINT64_C(100000000000)};
    for (size_t c = 0; c < sizeof asked / sizeof *asked; ++c) {
        fathom_scene *scene = generate(FATHOM_GENERATE_SPONGE, asked[c], 0);
        uint64_t count = placed_triangles(scene), factor = 1;
        assert_int_equal(scene->instances.count % 20, 0);
        for (size_t i = 0; i < scene->instances.count; i += 20) factor *= 20;
        assert_int_equal(count, scene->meshes.items[0].triangle_count * factor);
        for (size_t b = 0; b < 5; ++b) {
            factor = 1;
            for (int nest = 0; nest < 5; ++nest, factor *= 20)
                assert_true(off(count, asked[c]) <= off(boundary[b] * factor, asked[c]));
        }
        scene_bounds bounds;
        assert_ok(scene->context, scene_world_bounds(scene, &bounds));
        /* Up to four maps p/3 + 2/3, each rounded a few times, carry 1 to 1. */
        assert_near(length_f64(sub_f64(bounds.upper, (vec3_f64){1, 1, 1})), 0, 32 * 0x1p-53);
        assert_near(length_f64(sub_f64(bounds.lower, (vec3_f64){-1, -1, -1})), 0, 32 * 0x1p-53);
    }
}

/* Height of the ground at (x,z), by looking at every triangle. */
static double ground_height(const fathom_mesh *ground, double x, double z) {
    for (uint32_t t = 0; t < ground->triangle_count; ++t) {
        vec3_f64 a = vertex(ground, ground->indices[(size_t)t * 3]), n = facet(ground, t);
        bool inside = true;
        for (int k = 0; k < 3; ++k) {
            vec3_f64 p = vertex(ground, ground->indices[(size_t)t * 3 + (size_t)k]);
            vec3_f64 q = vertex(ground, ground->indices[(size_t)t * 3 + (size_t)(k + 1) % 3]);
            if ((q.z - p.z) * (x - p.x) - (q.x - p.x) * (z - p.z) < 0) inside = false;
        }
        if (inside) return a.y - (n.x * (x - a.x) + n.z * (z - a.z)) / n.y;
    }
    fail_msg("(%g, %g) is off the ground", x, z);
    return 0;
}

UNIT_TEST(trees_stand_on_the_ground) {
    fathom_scene *scene = generate(FATHOM_GENERATE_FOREST, 50000, 11);
    const fathom_mesh *ground = &scene->meshes.items[0];
    assert_true(scene->instances.count > 100);
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const double *m = scene->instances.items[i].transform;
        double size = m[5], sunk = ground_height(ground, m[3], m[11]) - m[7];
        /* 2.5 % of the tree is in the ground; x and z of the grid were rounded to float, which moves a
         * slope of less than 2 by 2^-23. */
        assert_true(size > 0);
        assert_near(sunk, 0.025 * size, 0x1p-22);
    }
}

UNIT_TEST(forests_come_out_exact) {
    const uint64_t asked[] = {32, 100, 101, 1000, 12345, 100000, 999999, 10000019};
    for (size_t c = 0; c < sizeof asked / sizeof *asked; ++c) {
        fathom_scene *scene = generate(FATHOM_GENERATE_FOREST, asked[c], c);
        assert_int_equal(placed_triangles(scene), asked[c]);
        for (size_t m = 0; m < scene->meshes.count; ++m) check_facets(&scene->meshes.items[m]);
    }
    fathom_scene *scene = generate(FATHOM_GENERATE_FOREST, UINT64_C(20000000000), 0);
    assert_int_equal(placed_triangles(scene), UINT64_C(20000000000));
}

/* Trees are about one high and stand on their origin; the leaves are bound to the wood. */
UNIT_TEST(trees_have_the_size_of_trees) {
    const uint64_t asked[] = {1000, 20000, 1000000, 30000000};
    for (size_t c = 0; c < sizeof asked / sizeof *asked; ++c) {
        fathom_scene *scene = generate(FATHOM_GENERATE_FOREST, asked[c], c);
        for (fathom_id id = 1; id < scene->objects.count; ++id) {
            scene_bounds b = scene_object_bounds(scene, id);
            assert_true(b.lower.y > -0.2 && b.upper.y < 1.5 && b.upper.y > 0.3);
            assert_true(b.lower.x > -1 && b.upper.x < 1 && b.lower.z > -1 && b.upper.z < 1);
        }
    }
}

UNIT_TEST(forests_use_the_material_asked_for) {
    fathom_scene *scene = new_scene(context);
    fathom_material grey = default_material();
    fathom_generate_options options = default_generate_options();
    options.kind = FATHOM_GENERATE_FOREST, options.triangles = 1000;
    assert_ok(context, fathom_scene_add_material(scene, "grey", &grey, &options.material));
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    assert_int_equal(scene->materials.count, 2);
    for (size_t m = 0; m < scene->meshes.count; ++m)
        assert_int_equal(scene->meshes.items[m].material, options.material);
}

static bool same_mesh(const fathom_mesh *a, const fathom_mesh *b) {
    size_t vertices = a->vertex_count, corners = (size_t)a->triangle_count * 3;
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
           !memcmp(a->positions, b->positions, vertices * 12) &&
           !memcmp(a->indices, b->indices, corners * 4) && !a->normals == !b->normals &&
           (!a->normals || !memcmp(a->normals, b->normals, vertices * 12)) && !a->uvs == !b->uvs &&
           (!a->uvs || !memcmp(a->uvs, b->uvs, vertices * 8)) && a->material == b->material;
}

static bool same_scene(const fathom_scene *a, const fathom_scene *b) {
    if (a->meshes.count != b->meshes.count || a->instances.count != b->instances.count) return false;
    for (size_t m = 0; m < a->meshes.count; ++m)
        if (!same_mesh(&a->meshes.items[m], &b->meshes.items[m])) return false;
    for (size_t i = 0; i < a->instances.count; ++i) {
        const fathom_instance *p = &a->instances.items[i], *q = &b->instances.items[i];
        if (p->group != q->group || p->parent != q->parent ||
            memcmp(p->transform, q->transform, sizeof p->transform))
            return false;
    }
    return true;
}

UNIT_TEST(threads_change_nothing_and_seeds_do) {
    const fathom_generator kinds[] = {FATHOM_GENERATE_SPHERE, FATHOM_GENERATE_TERRAIN, FATHOM_GENERATE_SPONGE,
                                      FATHOM_GENERATE_FOREST};
    for (size_t k = 0; k < 4; ++k) {
        fathom_context_set_threads(context, 1);
        fathom_scene *one = generate(kinds[k], 200000, 5);
        const unsigned threads[] = {2, 5};
        for (size_t t = 0; t < 2; ++t) {
            fathom_context_set_threads(context, threads[t]);
            fathom_scene *other = generate(kinds[k], 200000, 5);
            assert_true(same_scene(one, other));
        }
        fathom_context_set_threads(context, 0);
        fathom_scene *other = generate(kinds[k], 200000, 6);
        if (kinds[k] != FATHOM_GENERATE_SPONGE) assert_false(same_scene(one, other));
    }
}

UNIT_TEST(bad_options_are_refused) {
    fathom_scene *scene = new_scene(context);
    const fathom_generator kinds[] = {FATHOM_GENERATE_SPHERE, FATHOM_GENERATE_TERRAIN, FATHOM_GENERATE_SPONGE,
                                      FATHOM_GENERATE_FOREST};
    for (size_t k = 0; k < 4; ++k) {
        fathom_generate_options options = default_generate_options();
        options.kind = kinds[k], options.triangles = 0;
        assert_fails(context, fathom_scene_generate(scene, 0, &options), FATHOM_BAD_USAGE, "expected 1 to ");
        options.triangles = UINT64_MAX;
        assert_fails(context, fathom_scene_generate(scene, 0, &options), FATHOM_BAD_USAGE, "expected 1 to ");
        options.triangles = 100;
        assert_fails(context, fathom_scene_generate(scene, 77, &options), FATHOM_BAD_USAGE, "group 77");
        options.material = 77;
        assert_fails(context, fathom_scene_generate(scene, 0, &options), FATHOM_BAD_USAGE, "material 77");
    }
    assert_int_equal(scene->objects.count, 0);
}

UNIT_TEST(too_much_for_the_memory_is_a_status) {
    /* 4e9 triangles take 112 GB. */
    if (sysconf(_SC_PHYS_PAGES) > (100l << 30) / sysconf(_SC_PAGESIZE)) skip();
    fathom_scene *scene = new_scene(context);
    fathom_generate_options options = default_generate_options();
    options.triangles = 4000000000u;
    assert_fails(context, fathom_scene_generate(scene, 0, &options), FATHOM_OUT_OF_RESOURCES, "GiB");
    options.kind = FATHOM_GENERATE_TERRAIN;
    assert_fails(context, fathom_scene_generate(scene, 0, &options), FATHOM_OUT_OF_RESOURCES, "GiB");
}

int main(void) { return unit_main(open_context, NULL); }
