#include "read/mesh/normals.h"

#include "base/threads.h"
#include "math/vec.h"
#include "scene/mesh/mesh_facts.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Sums are integers, so that the order in which threads add does not matter. The unit is 2^-29. A corner
 * weighs at most pi, so a sum has room for 2^63 / 2^29 / pi = 5.4e9 corners, more than a mesh can have. The
 * rounding error of a corner is 2^-30, far below the 2^-24 of a float normal. */
#define UNIT 0x1p29

typedef struct smoothing {
    const fathom_mesh *mesh;
    const uint32_t *slots;
    uint32_t slot_count;
    _Atomic int64_t (*sums)[3];
    float *normals;
    atomic_bool empty; /* at least one sum is zero */
} smoothing;

/* atan over [0, 1], error below 2e-8 (Abramowitz and Stegun 4.4.49). The C library's function differs in the
 * last bit between processors. */
static double arc_tangent(double t) {
    double s = t * t;
    return t * (1 + s * (-.3333314528 +
                         s * (.1999355085 +
                              s * (-.1420889944 +
                                   s * (.1065626393 +
                                        s * (-.0752896400 +
                                             s * (.0429096138 + s * (-.0161657367 + s * .0028662257))))))));
}

/* The angle whose sine and cosine are proportional to the arguments; sine >= 0. */
static double angle_of(double sine, double cosine) {
    const double half_pi = 1.5707963267948966;
    double c = fabs(cosine);
    double angle = sine < c ? arc_tangent(sine / c) : sine > 0 ? half_pi - arc_tangent(c / sine) : 0;
    return cosine < 0 ? 2 * half_pi - angle : angle;
}

static vec3_f64 vertex(const fathom_mesh *mesh, uint32_t i) { return widen(load_f32(mesh_vertex(mesh, i))); }

/* The unit normal of triangle t, and its angles unless `angles` is NULL; false when it has no area. */
static bool triangle_normal(const fathom_mesh *mesh, size_t t, vec3_f64 *normal, double angles[3]) {
    const uint32_t *corner = mesh->indices + 3 * t;
    vec3_f64 p[3] = {vertex(mesh, corner[0]), vertex(mesh, corner[1]), vertex(mesh, corner[2])};
    vec3_f64 edge[3];
    for (int i = 0; i < 3; ++i) edge[i] = normalize_f64(sub_f64(p[(i + 1) % 3], p[i]));
    vec3_f64 area = cross_f64(sub_f64(p[1], p[0]), sub_f64(p[2], p[0]));
    if (!(length_f64(area) > 0)) return false;
    *normal = normalize_f64(area);
    for (int i = 0; angles && i < 3; ++i) {
        vec3_f64 next = edge[i], last = neg_f64(edge[(i + 2) % 3]);
        angles[i] = angle_of(length_f64(cross_f64(next, last)), dot_f64(next, last));
    }
    return true;
}

static uint32_t slot_of(const smoothing *s, size_t corner) {
    return s->slots ? s->slots[corner] : s->mesh->indices[corner];
}

static void add_triangles(void *user, size_t begin, size_t end) {
    smoothing *s = user;
    for (size_t t = begin; t < end; ++t) {
        vec3_f64 n;
        double angles[3];
        if (!triangle_normal(s->mesh, t, &n, angles)) continue;
        for (size_t i = 0; i < 3; ++i) {
            _Atomic int64_t *sum = s->sums[slot_of(s, 3 * t + i)];
            double w = angles[i] * UNIT;
            atomic_fetch_add_explicit(&sum[0], (int64_t)rint(w * n.x), memory_order_relaxed);
            atomic_fetch_add_explicit(&sum[1], (int64_t)rint(w * n.y), memory_order_relaxed);
            atomic_fetch_add_explicit(&sum[2], (int64_t)rint(w * n.z), memory_order_relaxed);
        }
    }
}

static void finish_slots(void *user, size_t begin, size_t end) {
    smoothing *s = user;
    for (size_t i = begin; i < end; ++i) {
        vec3_f64 sum = {(double)s->sums[i][0], (double)s->sums[i][1], (double)s->sums[i][2]};
        vec3_f32 n = narrow(normalize_f64(sum));
        if (dot_f64(sum, sum) == 0) atomic_store(&s->empty, true);
        store_f32(s->normals + 3 * i, n);
    }
}

/* Serial, because "the last triangle" depends on the order. Only needed for meshes with corners that cancel
 * out or unused vertices. */
static void fill_empty(const smoothing *s) {
    for (size_t t = 0; t < s->mesh->triangle_count; ++t) {
        for (size_t i = 0; i < 3; ++i) {
            uint32_t slot = slot_of(s, 3 * t + i);
            const _Atomic int64_t *sum = s->sums[slot];
            vec3_f64 n;
            if (!(sum[0] | sum[1] | sum[2]) && triangle_normal(s->mesh, t, &n, NULL))
                store_f32(s->normals + 3 * (size_t)slot, narrow(n));
        }
    }
    for (size_t i = 0; i < s->slot_count; ++i) {
        float *n = s->normals + 3 * i;
        if (n[0] == 0 && n[1] == 0 && n[2] == 0) n[2] = 1;
    }
}

_Static_assert(sizeof *((smoothing *)NULL)->sums == NORMALS_SMOOTH_BYTES, "what readers count beforehand");

fathom_status normals_smooth(fathom_context *context, const fathom_mesh *mesh, const uint32_t *slots,
                             uint32_t slot_count, float *normals) {
    smoothing s = {.mesh = mesh, .slots = slots, .slot_count = slot_count, .normals = normals};
    s.sums = calloc((size_t)slot_count + 1, sizeof *s.sums);
    if (!s.sums) return fail_memory(context, slot_count * sizeof *s.sums);
    unsigned threads = fathom_context_threads(context);
    loop_parallel(threads, mesh->triangle_count, 1u << 14, add_triangles, &s);
    loop_parallel(threads, slot_count, 1u << 14, finish_slots, &s);
    if (s.empty) fill_empty(&s);
    free(s.sums);
    return FATHOM_OK;
}
