/* What tracers are told about primitives: how many have no area, how many lie beyond all reach, how large
 * they are. */
#include "base/threads.h"
#include "math/four.h"
#include "scene/world.h"

#include <stdatomic.h>
#include <string.h>

/* ---- meshes ---- */

typedef struct survey {
    const fathom_mesh *mesh;
    _Atomic uint64_t flat, beyond;
    _Atomic uint32_t largest; /* bits of a float of at least 0, which order as it does */
} survey;

static vec3_f32 vertex(const fathom_mesh *m, uint32_t i) {
    return load_f32(
        (const float *)(const void *)((const char *)m->positions + (size_t)i * m->position_stride));
}

static float larger(float a, float b) { return a > b ? a : b; }

/* NaN for a NaN. */
static float reach_of(vec3_f32 p) {
    return larger(fabsf(p.x), larger(fabsf(p.y), fabsf(p.z))) + (p.x * 0 + p.y * 0 + p.z * 0);
}

static void raise_to(_Atomic uint32_t *to, float value) {
    uint32_t bits, old = atomic_load(to);
    memcpy(&bits, &value, sizeof bits);
    while (old < bits && !atomic_compare_exchange_weak(to, &old, bits)) continue;
}

typedef struct count {
    uint64_t flat, beyond;
    float largest;
} count;

static void survey_closely(const fathom_mesh *m, size_t begin, size_t end, count *to) {
    for (size_t i = begin; i < end; ++i) {
        const uint32_t *t = &m->indices[3 * i];
        vec3_f32 a = vertex(m, t[0]), b = vertex(m, t[1]), c = vertex(m, t[2]);
        vec3_f64 ab = sub_f64(widen(b), widen(a)), ac = sub_f64(widen(c), widen(a)), n = cross_f64(ab, ac);
        to->flat += n.x == 0 && n.y == 0 && n.z == 0;
        float x = reach_of(a), y = reach_of(b), z = reach_of(c), reach = larger(x, larger(y, z));
        bool within = x < (float)WORLD_REACH && y < (float)WORLD_REACH && z < (float)WORLD_REACH;
        to->beyond += !within;
        to->largest = within ? larger(to->largest, reach) : to->largest;
    }
}

/* Of the fourth number nothing is used. Embree reads vertices so too: the bytes are there. */
FOUR_INLINE four four_of(const fathom_mesh *m, uint32_t i) {
    return four_load((const char *)m->positions + (size_t)i * m->position_stride);
}

/* Marks the components of p - q, products of differences of floats, that are not zero for sure. With u =
 * 2^-24 the differences are off by up to u of themselves, their products by 3u and p - q by 4u (|p| + |q|) in
 * all; 16u leave room for the sum's own roundings, and 2^-120 for all that denormals lose. Nor are they zero
 * in double then. What overflows is not marked. */
FOUR_INLINE four_marks surely_not_zero(four p, four q) {
    return four_magnitude(p - q) > (four_magnitude(p) + four_magnitude(q)) * 0x1p-20f + 0x1p-120f;
}

/* The larger of magnitudes, which order as their bits do; a NaN is the largest. */
FOUR_INLINE four_marks larger_bits(four_marks a, four_marks b) {
    four_marks first = a > b;
    return (a & first) | (b & ~first);
}

/* False where not every triangle has an area for sure and lies within reach; else raises the largest. */
FOUR_INLINE bool survey_text(const fathom_mesh *m, size_t begin, size_t end, count *to) {
    four_marks most = {0, 0, 0, 0}, fine = {-1, -1, -1, -1};
    for (size_t i = begin; i < end; ++i) {
        const uint32_t *t = &m->indices[3 * i];
        four a = four_of(m, t[0]), b = four_of(m, t[1]), c = four_of(m, t[2]), ab = b - a, ac = c - a;
        four p = __builtin_shufflevector(ab, ab, 1, 2, 0, 3) * __builtin_shufflevector(ac, ac, 2, 0, 1, 3);
        four q = __builtin_shufflevector(ab, ab, 2, 0, 1, 3) * __builtin_shufflevector(ac, ac, 1, 2, 0, 3);
        four_marks area = surely_not_zero(p, q);
        fine &= area | __builtin_shufflevector(area, area, 1, 2, 0, 3) |
                __builtin_shufflevector(area, area, 2, 0, 1, 3);
        four_marks bits = larger_bits((four_marks)four_magnitude(b), (four_marks)four_magnitude(c));
        most = larger_bits(most, larger_bits((four_marks)four_magnitude(a), bits));
    }
    four reach = (four)most;
    fine &= reach < (float)WORLD_REACH;
    if (!(fine[0] & fine[1] & fine[2])) return false;
    to->largest = larger(to->largest, larger(reach[0], larger(reach[1], reach[2])));
    return true;
}

/* Without contraction no instruction set rounds otherwise. */
#if defined(__x86_64__)
__attribute__((target("avx2"))) static bool survey_avx2(const fathom_mesh *m, size_t begin, size_t end,
                                                        count *to) {
    return survey_text(m, begin, end, to);
}
static bool survey_quickly(const fathom_mesh *m, size_t begin, size_t end, count *to) {
    return __builtin_cpu_supports("avx2") ? survey_avx2(m, begin, end, to) : survey_text(m, begin, end, to);
}
#else
static bool survey_quickly(const fathom_mesh *m, size_t begin, size_t end, count *to) {
    return survey_text(m, begin, end, to);
}
#endif

#define SURVEY_TRIANGLES 256

static void survey_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    survey *all = user;
    count found = {0, 0, 0};
    for (size_t i = begin; i < end; i += SURVEY_TRIANGLES) {
        size_t stop = end - i < SURVEY_TRIANGLES ? end : i + SURVEY_TRIANGLES;
        if (!survey_quickly(all->mesh, i, stop, &found)) survey_closely(all->mesh, i, stop, &found);
    }
    atomic_fetch_add(&all->flat, found.flat);
    atomic_fetch_add(&all->beyond, found.beyond);
    raise_to(&all->largest, found.largest);
}

static void survey_mesh(world *w, world_geometry *geometry) {
    survey all = {.mesh = &w->meshes.items[geometry->first]};
    loop_parallel(fathom_context_threads(w->scene->context), all.mesh->triangle_count, 1u << 15, survey_run,
                  &all);
    uint32_t bits = atomic_load(&all.largest);
    memcpy(&geometry->largest, &bits, sizeof bits);
    geometry->flat = (uint32_t)atomic_load(&all.flat);
    w->degenerate_triangles += geometry->flat;
    w->beyond_reach += atomic_load(&all.beyond);
}

/* ---- the others ---- */

/* Takes one primitive into the counts; reach: of its largest coordinate. */
static void survey_one(world *w, world_geometry *geometry, float reach, bool flat) {
    bool within = reach < (float)WORLD_REACH;
    w->beyond_reach += !within;
    geometry->flat += flat;
    if (within) geometry->largest = larger(geometry->largest, reach);
}

static void survey_sphere(world *w, world_geometry *geometry, const world_sphere *s) {
    survey_one(w, geometry, reach_of(s->center) + fabsf(s->radius), !(s->radius > 0));
}

static void survey_quad(world *w, world_geometry *geometry, const world_quad *quad) {
    float reach = 0;
    for (int i = 0; i < 4; ++i) {
        float corner = reach_of(quad->corner[i]);
        reach = corner <= reach ? reach : corner; /* NaN too */
        if (!(reach < INFINITY)) break;
    }
    vec3_f64 a = widen(quad->corner[0]), b = widen(quad->corner[1]), c = widen(quad->corner[2]),
             d = widen(quad->corner[3]);
    vec3_f64 m = cross_f64(sub_f64(b, a), sub_f64(d, a)), n = cross_f64(sub_f64(d, c), sub_f64(b, c));
    bool area = (m.x != 0 || m.y != 0 || m.z != 0) && (n.x != 0 || n.y != 0 || n.z != 0);
    survey_one(w, geometry, reach, !area);
}

static void survey_geometry(world *w, world_geometry *geometry) {
    geometry->flat = 0, geometry->largest = 0;
    switch (geometry->kind) {
    case WORLD_SPHERES:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_sphere(w, geometry, &w->spheres.items[geometry->first + i]);
        break;
    case WORLD_QUADS:
        for (uint32_t i = 0; i < geometry->count; ++i)
            survey_quad(w, geometry, &w->quads.items[geometry->first + i]);
        break;
    case WORLD_MESH: survey_mesh(w, geometry); break;
    }
}

void world_survey(world *w) {
    w->degenerate_triangles = w->beyond_reach = 0;
    for (size_t i = 0; i < w->geometries.count; ++i) survey_geometry(w, &w->geometries.items[i]);
}
