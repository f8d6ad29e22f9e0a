/* Directions to an emissive triangle or quad, for sixteen points at once. */
#include "base/kernel.h"
#include "light/face.h"

/* A choice that gcc turns into a blend. */
static inline double pick(bool second, double a, double b) { return second ? b : a; }

static inline vec3_f64 pick3(bool second, vec3_f64 a, vec3_f64 b) {
    return (vec3_f64){pick(second, a.x, b.x), pick(second, a.y, b.y), pick(second, a.z, b.z)};
}

static inline shape_seen pick_seen(bool second, const shape_seen *a, const shape_seen *b) {
    shape_seen s = {pick3(second, a->a, b->a), pick3(second, a->b, b->b), pick3(second, a->c, b->c)};
    for (int k = 0; k < 3; ++k) s.g[k] = pick(second, a->g[k], b->g[k]);
    s.n = pick3(second, a->n, b->n);
    s.height = pick(second, a->height, b->height);
    s.angle = pick(second, a->angle, b->angle);
    return s;
}

static void sample(const shape_face *face, const face_query *from, face_answer *restrict out) {
    const shape_face f = *face;
    const vec3_f64 *c = f.corner;
    const double quad = f.quad ? 1 : 0;
    for (int i = 0; i < LANES; ++i) {
        const vec3_f64 p = {from->p[0][i], from->p[1][i], from->p[2][i]};
        const shape_seen first = shape_see(p, c[0], c[1], c[3], f.clear);
        const shape_seen other = shape_see(p, c[2], c[3], c[1], f.clear);
        const double all = first.angle + quad * other.angle, u = from->u[i] * all;
        const bool second = !(u < first.angle) && f.quad;
        const shape_seen s = pick_seen(second, &first, &other);
        const double part = pick(second, u, u - first.angle) / (s.angle + 0x1p-1022);
        const vec3_f64 d = shape_triangle_sample(&s, part < 1 ? part : 1, from->v[i]);
        out->direction[0][i] = d.x, out->direction[1][i] = d.y, out->direction[2][i] = d.z;
        out->distance[i] = shape_face_end(&s, d, f.clear, f.slope);
        out->density[i] = all > 0x1p-1000 ? 1 / all : 0;
    }
}

const face_kernels KERNEL(face_kernels) = {.sample = sample};
