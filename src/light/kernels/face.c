/* One face that all lanes sample: shape_see() and shape_triangle_sample() in float. */
#include "light/kernels/kernel.h"
#include "math/turn.h"

#define PI ((float)SHAPE_PI)

SHAPE_INLINE uint32_t mask_of(bool is) { return is ? ~0u : 0; }

SHAPE_INLINE vec3_f32 either(uint32_t mask, vec3_f32 a, vec3_f32 b) {
    return (vec3_f32){chosen(mask, a.x, b.x), chosen(mask, a.y, b.y), chosen(mask, a.z, b.z)};
}

/* shape_angle(). The polynomial is the minimax one of its degree: its error is 1.5e-8 of the angle. */
SHAPE_INLINE float angle_of(float y, float x) {
    const float wide = fabsf(x), big = wide > y ? wide : y, little = wide > y ? y : wide;
    const float q = little / (big + 0x1p-120f), z = q * q;
    float a = 0.00297458656f * z - 0.0165811684f;
    a = (a * z + 0.0435535163f) * z - 0.0758057609f;
    a = (a * z + 0.106789395f) * z - 0.142142087f;
    a = (a * z + 0.199941367f) * z - 0.333331674f;
    a = q + q * z * a;
    a = chosen(mask_of(y > wide), PI / 2 - a, a);
    return chosen(mask_of(x < 0), PI - a, a);
}

/* The height above a triangle's plane is a small difference of large numbers: computed in double, it has all
 * digits of float. */
static void find_heights(const shape_face_f32 *f, int k, const lanes3 p, float *restrict height) {
    const vec3_f64 n = f->n[k], at = widen(f->corner[2 * k]);
    for (unsigned i = 0; i < LANES; ++i) {
        const double x = (double)p[0][i] - at.x, y = (double)p[1][i] - at.y, z = (double)p[2][i] - at.z;
        height[i] = (float)fabs(x * n.x + y * n.y + z * n.z);
    }
}

/* As shape_seen. */
typedef struct seen {
    vec3_f32 a, b, c, n;
    float g0, g1, g2, height, angle;
} seen;

/* The unit vector towards a corner, and the inverse of its distance. Squares must stay in float's range. */
SHAPE_INLINE vec3_f32 towards(vec3_f32 corner, vec3_f32 p, float *inverse, uint32_t *unsure) {
    const vec3_f32 to = sub_f32(corner, p);
    const float square = dot_f32(to, to);
    *inverse = inverse_root_f32(square);
    *unsure |= mask_of(!((square > 0x1p-80f) & (square < 0x1p80f)));
    return scale_f32(*inverse, to);
}

/* apart: the product of the three inverse distances. If both arguments of the tangent are small, they are
 * sums of larger numbers and have few digits; above 1/16 they give the angle with a relative error of
 * 2^-17. */
SHAPE_INLINE seen see(vec3_f32 a, vec3_f32 b, vec3_f32 c, float size, float apart, float height, float clear,
                      uint32_t *unsure) {
    seen s = {.a = a, .b = b, .c = c, .height = height};
    s.g0 = height * (size * apart);
    s.g1 = dot_f32(a, c) + dot_f32(b, c);
    s.g2 = 1 + dot_f32(a, b);
    const float x = s.g1 + s.g2;
    *unsure |= mask_of(!((fabsf(x) > 0x1p-4f) | (s.g0 > 0x1p-4f)));
    s.angle = chosen(mask_of(height > clear), 2 * angle_of(s.g0, x), 0);
    return s;
}

SHAPE_INLINE seen either_seen(uint32_t mask, const seen *x, const seen *y) {
    return (seen){.a = either(mask, x->a, y->a),
                  .b = either(mask, x->b, y->b),
                  .c = either(mask, x->c, y->c),
                  .n = either(mask, x->n, y->n),
                  .g0 = chosen(mask, x->g0, y->g0),
                  .g1 = chosen(mask, x->g1, y->g1),
                  .g2 = chosen(mask, x->g2, y->g2),
                  .height = chosen(mask, x->height, y->height),
                  .angle = chosen(mask, x->angle, y->angle)};
}

/* shape_triangle_sample() */
SHAPE_INLINE vec3_f32 sample(const seen *s, float u, float v) {
    float cosine, sine;
    turn_by(u * s->angle * (0.25f / PI), &cosine, &sine);
    const vec3_f32 o = madd_f32(scale_f32(s->g0 * cosine - s->g1 * sine, s->a), s->g2 * sine, s->c);
    const float k = 2 * dot_f32(s->a, o) / (dot_f32(o, o) + 0x1p-120f);
    const vec3_f32 c = sub_f32(scale_f32(k, o), s->a), apart = sub_f32(s->b, c);
    const float q = 0.5f * dot_f32(apart, apart), t = sqrtf(v * (2 - v * q) / (2 - q));
    const vec3_f32 d = madd_f32(scale_f32(1 - v * q - t * (1 - q), s->b), t, c);
    return scale_f32(inverse_root_f32(dot_f32(d, d)), d);
}

/* For a light with a smaller solid angle, float directions resolve positions on it only roughly. */
#define LEAST_ANGLE 0x1p-16f

uint32_t KERNEL(face)(const shape_face_f32 *f, const lanes3 p, const lanes3 u, float *restrict density,
                      float (*restrict direction)[LANES], float *restrict distance) {
    float height[2][LANES];
    uint32_t unsure[LANES], bits = 0;
    const vec3_f32 n[2] = {narrow(f->n[0]), narrow(f->n[1])};
    for (int k = 0; k < 2; ++k) find_heights(f, k, p, height[k]);
    for (unsigned i = 0; i < LANES; ++i) {
        const vec3_f32 at = {p[0][i], p[1][i], p[2][i]};
        float near[4];
        uint32_t doubt = 0;
        const vec3_f32 a = towards(f->corner[0], at, &near[0], &doubt),
                       b = towards(f->corner[1], at, &near[1], &doubt),
                       c = towards(f->corner[2], at, &near[2], &doubt),
                       d = towards(f->corner[3], at, &near[3], &doubt);
        const float edge = near[1] * near[3];
        seen one = see(a, b, d, f->size[0], edge * near[0], height[0][i], f->clear, &doubt),
             two = see(c, d, b, f->size[1], edge * near[2], height[1][i], f->clear, &doubt);
        one.n = n[0], two.n = n[1];
        const float all = one.angle + two.angle, along = u[0][i] * all;
        const uint32_t second = mask_of(!(along < one.angle));
        const seen s = either_seen(second, &two, &one);
        float part = (along - chosen(second, one.angle, 0)) / (s.angle + 0x1p-120f);
        part = part < 1 ? part : 1;
        const vec3_f32 to = sample(&s, part, u[1][i]);
        const float cosine = fabsf(dot_f32(to, s.n)) + 0x1p-120f, length = s.height / cosine;
        const float end = length - (f->clear + f->slope * length) / cosine;
        direction[0][i] = to.x, direction[1][i] = to.y, direction[2][i] = to.z;
        distance[i] = end > 0x1p-126f ? end : 0x1p-126f;
        /* A point on the face itself gets no light, and needs no double precision. */
        const uint32_t lit = mask_of((height[0][i] > f->clear) | (height[1][i] > f->clear));
        density[i] = chosen(lit, 1 / all, 0);
        unsure[i] = lit & (doubt | mask_of(!(all > LEAST_ANGLE)));
    }
    for (unsigned i = 0; i < LANES; ++i) bits |= unsure[i] & 1u << i;
    return bits;
}
