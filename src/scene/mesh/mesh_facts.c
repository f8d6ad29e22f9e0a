#include "scene/mesh/mesh_facts.h"

#include "base/threads.h"
#include "scene/array_check.h"
#include "scene/kernels.h"
#include "scene/world/world.h"

#include <math.h>
#include <pthread.h>

/* An array under a parallel look. Sums, extremes and the first bad item do not depend on who adds to them
 * when. */
typedef struct look {
    const scene_kernels *kernels;
    const float *values;
    size_t stride;
    const fathom_mesh *mesh;
    pthread_mutex_t lock;
    size_t bad; /* the first */
    mesh_facts *facts;
} look;

static void note_bad(look *l, size_t i) {
    pthread_mutex_lock(&l->lock);
    l->bad = i < l->bad ? i : l->bad;
    pthread_mutex_unlock(&l->lock);
}

static float smaller(float a, float b) { return a < b ? a : b; }
static float larger(float a, float b) { return a > b ? a : b; }

/* ---- vertices ---- */

static void look_at_vectors(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    look *l = user;
    const char *first = (const char *)l->values + begin * l->stride;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    if (!l->kernels->vectors((const float *)(const void *)first, l->stride, end - begin, low, high)) {
        note_bad(l, begin + array_first_odd((const float *)(const void *)first, l->stride, 3, end - begin));
        return;
    }
    pthread_mutex_lock(&l->lock);
    for (int k = 0; k < 3; ++k) {
        l->facts->lower[k] = smaller(low[k], l->facts->lower[k]);
        l->facts->upper[k] = larger(high[k], l->facts->upper[k]);
    }
    pthread_mutex_unlock(&l->lock);
}

fathom_status mesh_look_at_vertices(fathom_context *context, const char *what, const float *values,
                                    size_t stride, uint32_t count, mesh_facts *facts) {
    fathom_status status = array_check_stride(context, what, stride, 3);
    if (status != FATHOM_OK) return status;
    look l = {.kernels = scene_kernels_best(),
              .values = values,
              .stride = stride,
              .lock = PTHREAD_MUTEX_INITIALIZER,
              .bad = SIZE_MAX,
              .facts = facts};
    for (int k = 0; k < 3; ++k) facts->lower[k] = INFINITY, facts->upper[k] = -INFINITY;
    loop_parallel(fathom_context_threads(context), count, 1u << 16, look_at_vectors, &l);
    return l.bad == SIZE_MAX ? FATHOM_OK : array_fail_odd(context, what, l.bad);
}

/* ---- triangles ---- */

static vec3_f32 vertex(const fathom_mesh *m, uint32_t i) {
    return load_f32(
        (const float *)(const void *)((const char *)m->positions + (size_t)i * m->position_stride));
}

/* By the definition; a NaN is beyond reach. */
static void look_closely(const fathom_mesh *m, size_t begin, size_t end, mesh_facts *to) {
    for (size_t i = begin; i < end; ++i) {
        const uint32_t *t = &m->indices[3 * i];
        vec3_f32 a = vertex(m, t[0]), b = vertex(m, t[1]), c = vertex(m, t[2]);
        vec3_f64 ab = sub_f64(widen(b), widen(a)), ac = sub_f64(widen(c), widen(a)), n = cross_f64(ab, ac);
        to->flat += n.x == 0 && n.y == 0 && n.z == 0;
        float x = world_reach_of(a), y = world_reach_of(b), z = world_reach_of(c);
        bool within = x < (float)WORLD_REACH && y < (float)WORLD_REACH && z < (float)WORLD_REACH;
        to->beyond += !within;
        if (within) to->largest = larger(to->largest, larger(x, larger(y, z)));
    }
}

/* So few that their indices stay in the first-level cache from one kernel to the next. */
#define TOGETHER 512

/* The quick look reads four floats of each vertex: of the last there may be but three. */
static bool look_at_some(const look *l, size_t begin, size_t end, mesh_facts *to) {
    const fathom_mesh *m = l->mesh;
    const uint32_t *indices = m->indices + 3 * begin;
    const size_t count = end - begin;
    const bool before_last = l->kernels->indices(indices, 3 * count, m->vertex_count - 1);
    if (!before_last && !l->kernels->indices(indices, 3 * count, m->vertex_count)) return false;
    to->boundary += l->kernels->boundary(indices, count);
    if (!before_last || !l->kernels->areas(m->positions, m->position_stride, indices, count, &to->largest))
        look_closely(m, begin, end, to);
    return true;
}

static void look_at_run(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    look *l = user;
    mesh_facts found = {.largest = 0};
    for (size_t i = begin; i < end; i += TOGETHER) {
        size_t stop = end - i < TOGETHER ? end : i + TOGETHER;
        if (look_at_some(l, i, stop, &found)) continue;
        note_bad(l,
                 3 * i + array_first_beyond(l->mesh->indices + 3 * i, 3 * (stop - i), l->mesh->vertex_count));
        return;
    }
    pthread_mutex_lock(&l->lock);
    l->facts->boundary += found.boundary;
    l->facts->flat += found.flat;
    l->facts->beyond += found.beyond;
    l->facts->largest = larger(l->facts->largest, found.largest);
    pthread_mutex_unlock(&l->lock);
}

fathom_status mesh_look_at_triangles(fathom_context *context, const char *what, const fathom_mesh *mesh,
                                     mesh_facts *facts) {
    look l = {.kernels = scene_kernels_best(),
              .mesh = mesh,
              .lock = PTHREAD_MUTEX_INITIALIZER,
              .bad = SIZE_MAX,
              .facts = facts};
    facts->boundary = 0, facts->flat = facts->beyond = 0, facts->largest = 0;
    loop_parallel(fathom_context_threads(context), mesh->triangle_count, 1u << 15, look_at_run, &l);
    return l.bad == SIZE_MAX ? FATHOM_OK
                             : array_fail_index(context, what, mesh->indices, l.bad, mesh->vertex_count);
}
