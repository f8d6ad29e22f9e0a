/* Directions to an emissive triangle or quad, for sixteen points at once. */
#include "light/face.h"
#include "base/kernel.h"

/* A choice that gcc turns into a blend. */
static inline double pick(bool second, double a, double b) { return second ? b : a; }

static inline vec3_f64 pick3(bool second, vec3_f64 a, vec3_f64 b) {
    return (vec3_f64){pick(second, a.x, b.x), pick(second, a.y, b.y), pick(second, a.z, b.z)};
}

static inline shape_seen pick_seen(bool second, const shape_seen *a, const shape_seen *b) {
    return (shape_seen){
        .a = pick3(second, a->a, b->a),
        .b = pick3(second, a->b, b->b),
        .c = pick3(second, a->c, b->c),
        .g = {pick(second, a->g[0], b->g[0]), pick(second, a->g[1], b->g[1]), pick(second, a->g[2], b->g[2])},
        .n = pick3(second, a->n, b->n),
        .height = pick(second, a->height, b->height),
        .angle = pick(second, a->angle, b->angle)};
}

static inline vec3_f64 lane(const lanes3_f64 v, int i) { return (vec3_f64){v[0][i], v[1][i], v[2][i]}; }

static void sample(const face_query *q, face_answer *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const vec3_f64 p = lane(q->p, i), a = lane(q->corner[0], i), b = lane(q->corner[1], i),
                       c = lane(q->corner[2], i), d = lane(q->corner[3], i);
        const shape_seen first = shape_see(p, a, b, d, q->clear[i]),
                         other = shape_see(p, c, d, b, q->clear[i]);
        const double all = first.angle + q->quad[i] * other.angle, u = q->u[i] * all;
        const bool second = !(u < first.angle) & (q->quad[i] > 0);
        const shape_seen s = pick_seen(second, &first, &other);
        const double part = pick(second, u, u - first.angle) / (s.angle + 0x1p-1022);
        const vec3_f64 to = shape_triangle_sample(&s, part < 1 ? part : 1, q->v[i]);
        out->direction[0][i] = to.x, out->direction[1][i] = to.y, out->direction[2][i] = to.z;
        out->distance[i] = shape_face_end(&s, to, q->clear[i], q->slope[i]);
        out->density[i] = all > 0x1p-1000 ? 1 / all : 0;
    }
}

const face_kernels KERNEL(face_kernels) = {.sample = sample};
