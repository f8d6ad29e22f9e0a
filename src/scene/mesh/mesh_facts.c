#include "scene/mesh/mesh_facts.h"

#include "base/kernel.h"
#include "base/threads.h"
#include "scene/kernels.h"
#include "scene/world/world.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

KERNEL_BEST(scene_kernels)

/* An array that a parallel loop reads. Sums, extremes and the first bad item do not depend on the order in
 * which threads add to them. */
typedef struct look {
    const scene_kernels *kernels;
    const float *values;
    size_t stride, components;
    const uint32_t *indices;
    uint32_t limit;
    const fathom_mesh *mesh;
    mesh_facts *facts;
    pthread_mutex_t lock;
    size_t bad; /* the first bad item */
} look;

#define LOOK(...)                                                                                            \
    (look) {                                                                                                 \
        .kernels = scene_kernels_best(), .lock = PTHREAD_MUTEX_INITIALIZER, .bad = SIZE_MAX, __VA_ARGS__     \
    }

static void note_bad(look *l, size_t i) {
    pthread_mutex_lock(&l->lock);
    l->bad = i < l->bad ? i : l->bad;
    pthread_mutex_unlock(&l->lock);
}

static float larger(float a, float b) { return a > b ? a : b; }

/* ---- numbers ---- */

static const float *item(const look *l, size_t i) { return mesh_row(l->values, l->stride, i); }

/* A float is not finite if all bits of its exponent are set. Without the sign, adding one to the lowest bit
 * of the exponent then carries into the top bit. This is integer arithmetic, so the loop vectorises. */
static bool is_finite(const float *values, size_t n) {
    uint32_t full = 0;
    for (size_t i = 0; i < n; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        full |= (bits & 0x7fffffffu) + 0x00800000u;
    }
    return !(full >> 31);
}

static void note_first_odd(look *l, size_t begin, size_t end) {
    while (begin < end && is_finite(item(l, begin), l->components)) ++begin;
    if (begin < end) note_bad(l, begin);
}

static void check_finite_run(void *user, size_t begin, size_t end) {
    look *l = user;
    bool packed = l->stride == l->components * sizeof(float);
    if (packed && is_finite(item(l, begin), (end - begin) * l->components)) return;
    note_first_odd(l, begin, end);
}

static void look_at_vectors(void *user, size_t begin, size_t end) {
    look *l = user;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    if (!l->kernels->vectors(item(l, begin), l->stride, end - begin, low, high)) {
        note_first_odd(l, begin, end);
        return;
    }
    pthread_mutex_lock(&l->lock);
    for (int k = 0; k < 3; ++k) { /* + 0: of -0 and 0, the same one whichever thread is first */
        l->facts->lower[k] = fminf(low[k], l->facts->lower[k]) + 0;
        l->facts->upper[k] = fmaxf(high[k], l->facts->upper[k]) + 0;
    }
    pthread_mutex_unlock(&l->lock);
}

static fathom_status check_values(fathom_context *context, const char *what, look *l, uint32_t count,
                                  loop_body run) {
    if (l->stride % 4 || l->stride < l->components * sizeof(float))
        return fail_field(context, FATHOM_BAD_INPUT, what,
                          "the stride is %zu; expected a multiple of 4 of at least %zu", l->stride,
                          l->components * sizeof(float));
    loop_parallel(fathom_context_threads(context), count, 1u << 16, run, l);
    if (l->bad == SIZE_MAX) return FATHOM_OK;
    return fail_item(context, FATHOM_BAD_INPUT, what, l->bad,
                     "expected finite numbers, found a NaN or an infinity");
}

fathom_status mesh_check_finite(fathom_context *context, const char *what, const float *values, size_t stride,
                                size_t components, uint32_t count) {
    look l = LOOK(.values = values, .stride = stride, .components = components);
    return check_values(context, what, &l, count, check_finite_run);
}

fathom_status mesh_look_at_vertices(fathom_context *context, const char *what, const float *values,
                                    size_t stride, uint32_t count, mesh_facts *facts) {
    look l = LOOK(.values = values, .stride = stride, .components = 3, .facts = facts);
    for (int k = 0; k < 3; ++k) facts->lower[k] = INFINITY, facts->upper[k] = -INFINITY;
    facts->upwards = false;
    return check_values(context, what, &l, count, look_at_vectors);
}

/* ---- indices and triangles ---- */

static void note_first_beyond(look *l, size_t begin, size_t end) {
    while (begin < end && l->indices[begin] < l->limit) ++begin;
    if (begin < end) note_bad(l, begin);
}

static void check_index_run(void *user, size_t begin, size_t end) {
    look *l = user;
    if (!l->kernels->indices(l->indices + begin, end - begin, l->limit)) note_first_beyond(l, begin, end);
}

static fathom_status check_indices(fathom_context *context, const char *what, look *l, size_t count,
                                   size_t grain, loop_body run) {
    loop_parallel(fathom_context_threads(context), count, grain, run, l);
    if (l->bad == SIZE_MAX) return FATHOM_OK;
    return fail_item(context, FATHOM_BAD_INPUT, what, l->bad,
                     "%u, of triangle %zu, is out of range; there are %u", l->indices[l->bad], l->bad / 3,
                     l->limit);
}

fathom_status mesh_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                 size_t count, uint32_t limit) {
    look l = LOOK(.indices = indices, .limit = limit);
    return check_indices(context, what, &l, count, 1u << 18, check_index_run);
}

/* Applies the definitions of the facts, in double. A NaN counts as beyond reach. */
static void look_closely(const fathom_mesh *m, size_t begin, size_t end, mesh_facts *to) {
    for (size_t i = begin; i < end; ++i) {
        const uint32_t *t = &m->indices[3 * i];
        vec3_f32 a = load_f32(mesh_vertex(m, t[0])), b = load_f32(mesh_vertex(m, t[1])),
                 c = load_f32(mesh_vertex(m, t[2]));
        vec3_f64 ab = sub_f64(widen(b), widen(a)), ac = sub_f64(widen(c), widen(a)), n = cross_f64(ab, ac);
        to->flat += n.x == 0 && n.y == 0 && n.z == 0;
        float x = world_reach_of(a), y = world_reach_of(b), z = world_reach_of(c);
        bool within = x < (float)WORLD_REACH && y < (float)WORLD_REACH && z < (float)WORLD_REACH;
        to->beyond += !within;
        if (within) to->largest = larger(to->largest, larger(x, larger(y, z)));
    }
}

/* Triangles per kernel call, few enough that their indices stay in the L1 cache from one kernel to the
 * next. */
#define TOGETHER 512

/* The kernel `areas` reads four floats from each vertex, but the last vertex may have only three. Runs that
 * use the last vertex are therefore checked by look_closely() instead. */
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

static void look_at_run(void *user, size_t begin, size_t end) {
    look *l = user;
    mesh_facts found = {.largest = 0};
    for (size_t i = begin; i < end; i += TOGETHER) {
        size_t stop = end - i < TOGETHER ? end : i + TOGETHER;
        if (look_at_some(l, i, stop, &found)) continue;
        note_first_beyond(l, 3 * i, 3 * stop);
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
    look l = LOOK(.indices = mesh->indices, .limit = mesh->vertex_count, .mesh = mesh, .facts = facts);
    facts->boundary = 0, facts->flat = facts->beyond = 0, facts->largest = 0;
    return check_indices(context, what, &l, mesh->triangle_count, 1u << 15, look_at_run);
}
