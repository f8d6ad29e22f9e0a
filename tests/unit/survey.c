/* What is told of a mesh's triangles and of its extent, against looking at each by the definition. */
#include "random.h"
#include "scene/graph.h"
#include "scene/kernels.h"
#include "stage.h"
#include "variants.h"

#include <sys/mman.h>
#include <unistd.h>

VARIANTS(scene_kernels)

/* Corners on a grid of few steps, so that many triangles have none or hardly any area: their sides are
 * parallel in exact numbers, or off by a unit in the last place. */
static float coordinate(random_state *random, float size) {
    float steps = (float)(random_bits(random) % 7) - 3;
    if (random_bits(random) % 4 == 0) steps = nextafterf(steps, 100.0f);
    return steps * size;
}

/* On one line, so far apart that float rounds their differences, and each component in its own way. */
static void place_on_line(random_state *random, float size, float out[3]) {
    float along = ldexpf((float)(random_bits(random) % 4096), -(int)(random_bits(random) % 24));
    for (int k = 0; k < 3; ++k) out[k] = along * (float)(2 * k + 1) * size;
}

typedef struct told {
    uint64_t flat, beyond;
    float largest;
} told;

static told by_definition(const float *p, const uint32_t *t, uint32_t count) {
    told all = {0, 0, 0};
    for (uint32_t i = 0; i < count; ++i) {
        double v[3][3], reach = 0;
        bool within = true;
        for (int k = 0; k < 9; ++k) {
            v[k / 3][k % 3] = (double)p[3 * t[3 * i + (uint32_t)k / 3] + (uint32_t)k % 3];
            within &= fabs(v[k / 3][k % 3]) < WORLD_REACH;
            reach = fmax(reach, fabs(v[k / 3][k % 3]));
        }
        vec3_f64 a = load_f64(v[0]), ab = sub_f64(load_f64(v[1]), a), ac = sub_f64(load_f64(v[2]), a);
        vec3_f64 n = cross_f64(ab, ac);
        all.flat += n.x == 0 && n.y == 0 && n.z == 0;
        all.beyond += !within;
        if (within && reach > (double)all.largest) all.largest = (float)reach;
    }
    return all;
}

enum { VERTICES = 90 };

/* A mesh of the stage's memory, in the world alone: `size` of a grid's step, `odd` times a number that no
 * reader would let through. */
static void survey_one(float size, unsigned odd, uint32_t triangles, uint64_t key) {
    stage s = stage_open();
    random_state random = {key};
    float *p = unit_memory(sizeof(float) * (3 * VERTICES + 4));
    uint32_t *t = unit_memory(sizeof(uint32_t) * 3 * triangles);
    for (uint32_t i = 0; i < 3 * VERTICES + 3; ++i) p[i] = coordinate(&random, size);
    for (uint32_t i = 0; i < VERTICES; i += 3) place_on_line(&random, exp2f(rintf(log2f(size))), p + 3 * i);
    for (uint32_t i = 0; i < 3 * triangles; ++i) t[i] = (uint32_t)(random_bits(&random) % VERTICES);
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = VERTICES + key % 2; /* the last named by some, or by none */
    mesh.indices = t, mesh.triangle_count = triangles;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    stage_world(&s);
    static const float oddities[] = {NAN, INFINITY, -INFINITY, 1e18f, -3e38f};
    for (unsigned k = 0; k < odd; ++k) p[random_bits(&random) % (3 * VERTICES)] = oddities[k % 5];
    assert_ok(s.context, world_survey(s.world));
    told expected = by_definition(p, t, triangles);
    assert_int_equal(s.world->degenerate_triangles, expected.flat);
    assert_int_equal(s.world->beyond_reach, expected.beyond);
    assert_true(s.world->geometries.items[0].largest == expected.largest);
}

UNIT_TEST(triangles_are_counted_as_defined) {
    static const float sizes[] = {1, 0.1f, 1e-8f, 1e-20f, 1e-38f, 1e-44f, 1e9f, 1e17f};
    for (uint64_t k = 0; k < 8; ++k) {
        survey_one(sizes[k], 0, 3000, 100 + k);
        survey_one(sizes[k], 3, 3000, 200 + k);
    }
    /* Each by itself: one that needs a closer look takes its neighbours with it. */
    for (uint64_t k = 0; k < 1000; ++k) survey_one(sizes[k % 8], 0, 1, 300 + k);
}

/* Any number of vertices, packed and not. */
UNIT_TEST(bounds_hold_every_vertex) {
    for (uint32_t count = 3; count < 40; ++count) {
        stage s = stage_open();
        random_state random = {count};
        size_t numbers = count % 2 ? 3 : 5;
        float *p = unit_memory(sizeof(float) * (numbers * count + 4));
        float low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
        for (size_t i = 0; i < numbers * count; ++i) {
            p[i] = i % numbers < 3 ? coordinate(&random, 1) : 1e9f;
            if (i % numbers >= 3) continue;
            low[i % numbers] = fminf(low[i % numbers], p[i]);
            high[i % numbers] = fmaxf(high[i % numbers], p[i]);
        }
        static const uint32_t one[3] = {0, 1, 2};
        fathom_mesh mesh = default_mesh();
        mesh.positions = p, mesh.vertex_count = count, mesh.position_stride = numbers * sizeof(float);
        mesh.indices = one, mesh.triangle_count = 1;
        assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
        scene_bounds b;
        assert_ok(s.scene->context, scene_world_bounds(s.scene, &b));
        double found[6], expected[6];
        store_f64(found, b.lower), store_f64(found + 3, b.upper);
        for (int k = 0; k < 3; ++k) expected[k] = (double)low[k], expected[3 + k] = (double)high[k];
        for (int k = 0; k < 6; ++k) assert_true(found[k] == expected[k]);
    }
}

/* A page that nobody may touch follows the arrays of a mesh that is copied. */
UNIT_TEST(nothing_is_read_past_the_end) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = mmap(NULL, 4 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(pages != MAP_FAILED);
    assert_int_equal(mprotect(pages + page, page, PROT_NONE), 0);
    assert_int_equal(mprotect(pages + 3 * page, page, PROT_NONE), 0);
    for (uint32_t count = 3; count < 40; ++count) {
        stage s = stage_open();
        random_state random = {count};
        float *p = (float *)(void *)(pages + page) - 3 * count;
        uint32_t *t = (uint32_t *)(void *)(pages + 3 * page) - 3 * count;
        for (uint32_t i = 0; i < 3 * count; ++i) p[i] = coordinate(&random, 1), t[i] = i % count;
        fathom_mesh mesh = default_mesh();
        mesh.positions = p, mesh.vertex_count = count, mesh.indices = t, mesh.triangle_count = count;
        assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
        assert_int_equal(s.scene->mesh_facts.items[0].flat, by_definition(p, t, count).flat);
    }
    munmap(pages, 4 * page);
}

/* ---- the kernels of every instruction set ---- */

static void fill(random_state *random, float size, float *p, uint32_t vertices, uint32_t *t, uint32_t count) {
    for (uint32_t i = 0; i < 3 * vertices + 4; ++i) p[i] = coordinate(random, size);
    for (uint32_t i = 0; i < 3 * count; ++i) t[i] = (uint32_t)(random_bits(random) % vertices);
}

/* What all of them have to say of the same triangles, any number of them. */
UNIT_TEST(areas_are_told_apart) {
    static const float sizes[] = {1, 1e-20f, 1e17f, 4e17f};
    float p[3 * VERTICES + 4];
    uint32_t t[3 * 40];
    unsigned sure = 0;
    for (uint64_t key = 0; key < 4000; ++key) {
        random_state random = {key};
        uint32_t count = (uint32_t)(key % 40);
        fill(&random, sizes[key % 4], p, VERTICES, t, count);
        const told expected = by_definition(p, t, count);
        float first = 0;
        bool fine = scene_kernels_at(0)->areas(p, 12, t, count, &first);
        sure += fine && count;
        if (fine) assert_true(!expected.flat && !expected.beyond && first == expected.largest);
        for (unsigned k = 1; scene_kernels_at(k); ++k) {
            float other = 0;
            assert_int_equal(scene_kernels_at(k)->areas(p, 12, t, count, &other), fine);
            assert_true(other == first);
        }
    }
    assert_true(sure > 0);
}

UNIT_TEST(boundaries_are_summed) {
    uint32_t t[3 * 80];
    for (uint32_t count = 0; count < 80; ++count) {
        random_state random = {count};
        uint64_t sum = 0;
        uint32_t highest = 0;
        for (uint32_t i = 0; i < 3 * count; ++i) {
            t[i] = (uint32_t)random_bits(&random);
            highest = t[i] > highest ? t[i] : highest;
        }
        for (uint32_t i = 0; i < 3 * count; ++i) { /* edge by edge */
            boundary_pair a = boundary_of_index(t[i]), b = boundary_of_index(t[i % 3 == 2 ? i - 2 : i + 1]);
            sum += (uint64_t)a.x * b.y - (uint64_t)b.x * a.y;
        }
        for (unsigned k = 0; scene_kernels_at(k); ++k) {
            assert_true(scene_kernels_at(k)->boundary(t, count) == sum);
            assert_int_equal(scene_kernels_at(k)->indices(t, 3 * count, highest), count == 0);
            assert_true(scene_kernels_at(k)->indices(t, 3 * count, highest + 1));
        }
    }
}

/* Wherever the odd number stands. */
UNIT_TEST(odd_numbers_are_found) {
    static const float odd[] = {NAN, INFINITY, -INFINITY};
    float p[3 * 40];
    for (uint32_t at = 0; at < 3 * 40; ++at) {
        random_state random = {at};
        for (uint32_t i = 0; i < 3 * 40; ++i) p[i] = coordinate(&random, 1e38f);
        for (unsigned k = 0; scene_kernels_at(k); ++k) {
            float low[3] = {0}, high[3] = {0}, kept = p[at];
            assert_true(scene_kernels_at(k)->vectors(p, 12, 40, low, high));
            p[at] = odd[at % 3];
            assert_false(scene_kernels_at(k)->vectors(p, 12, 40, low, high));
            assert_false(scene_kernels_at(k)->vectors(p + at / 3 * 3, 12, 40 - at / 3, low, high));
            p[at] = kept;
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
