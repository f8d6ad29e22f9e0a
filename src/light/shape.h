/* Emissive shapes seen from a point: the solid angle that they cover, and directions sampled uniformly in it.
 *
 * All arithmetic is double, on differences that are exact or nearly so: shapes of any size and distance are
 * at least as accurate as float. No C library function is called except square roots: the bits are the same
 * on every processor, and loops over lanes vectorise. */
#pragma once

#include "math/inverse_root.h"
#include "math/vec.h"

#define SHAPE_PI 3.14159265358979323846

/* These must be inlined: a loop over lanes that calls one as a function does not vectorise. */
#define SHAPE_INLINE __attribute__((always_inline)) static inline

/* ---- functions ---- */

/* sin x for |x| <= pi/2: the series is truncated at an error of 4e-14. */
SHAPE_INLINE double shape_sine(double x) {
    double q = x * x;
    double s = 1 / 6227020800.0 - q * (1 / 1307674368000.0 - q * (1 / 355687428096000.0));
    s = 1 / 362880.0 - q * (1 / 39916800.0 - q * s);
    return x * (1 - q * (1 / 6.0 - q * (1 / 120.0 - q * (1 / 5040.0 - q * s))));
}

/* The polar angle of (x, y) for y >= 0, in [0, pi]; 0 for (0, 0). The tangent of the angle is halved twice,
 * to at most tan(pi/16), where the series is truncated at an error of 1e-15. */
SHAPE_INLINE double shape_angle(double y, double x) {
    double wide = fabs(x), big = wide > y ? wide : y, little = wide > y ? y : wide;
    double q = little / (big + 0x1p-1000);
    q = q / (1 + sqrt(1 + q * q));
    q = q / (1 + sqrt(1 + q * q));
    double z = q * q;
    double s = 1 / 15.0 - z * (1 / 17.0 - z * (1 / 19.0));
    s = 1 / 9.0 - z * (1 / 11.0 - z * (1 / 13.0 - z * s));
    double a = 4 * q * (1 - z * (1 / 3.0 - z * (1 / 5.0 - z * (1 / 7.0 - z * s))));
    a = y > wide ? SHAPE_PI / 2 - a : a;
    return x < 0 ? SHAPE_PI - a : a;
}

/* cos and sin of 2 pi u with both signs flipped. */
static inline void shape_turn(double u, double *cosine, double *sine) {
    double phi = 2 * SHAPE_PI * (u - 0.5), over = fabs(phi);
    double folded = over > SHAPE_PI / 2 ? SHAPE_PI - over : over;
    *cosine = shape_sine(SHAPE_PI / 2 - over);
    *sine = shape_sine(phi < 0 ? -folded : folded);
}

/* x a + y b + z w, where a and b make a right-handed frame with the unit vector w (Duff et al., JCGT 2017).
 */
static inline vec3_f64 shape_around(vec3_f64 w, double x, double y, double z) {
    double sign = w.z < 0 ? -1 : 1, k = -1 / (sign + w.z), m = w.x * w.y * k;
    vec3_f64 a = {1 + sign * w.x * w.x * k, sign * m, -sign * w.x}, b = {m, sign + w.y * w.y * k, -w.y};
    return madd_f64(madd_f64(scale_f64(x, a), y, b), z, w);
}

static inline vec3_f64 shape_unit(vec3_f64 v) { return scale_f64(1 / sqrt(dot_f64(v, v)), v); }

/* ---- all directions ---- */

/* Proportional to the cosine to the unit normal n; n = 0: uniform over the sphere. */
static inline vec3_f64 shape_all_sample(vec3_f64 n, double u, double v) {
    bool sided = dot_f64(n, n) > 0;
    double c, s, z = sided ? sqrt(1 - u) : 1 - 2 * u, r = sided ? sqrt(u) : 2 * sqrt(u * (1 - u));
    shape_turn(v, &c, &s);
    return shape_around(sided ? n : (vec3_f64){0, 0, 1}, r * c, r * s, z);
}
static inline double shape_all_density(vec3_f64 n, vec3_f64 direction) {
    double along = dot_f64(n, direction), cosine = along > 0 ? along / SHAPE_PI : 0;
    return dot_f64(n, n) > 0 ? cosine : 1 / (4 * SHAPE_PI);
}

/* ---- triangles and quads ---- */

/* In world space. A quad is the triangles (0,1,3) and (2,3,1), as in tracers; a triangle is (0,1,3). */
typedef struct shape_face {
    vec3_f64 corner[4];
    bool quad;
    double clear, slope; /* a shadow ray of length D must end at least clear + slope D away from the plane */
} shape_face;

/* A triangle seen from a point. g0, g1 and g2 give the tangent of half the solid angle of (a, b, c) when c
 * moves along its edge to a: see shape_triangle_sample(). */
typedef struct shape_seen {
    vec3_f64 a, b, c;  /* unit vectors towards the corners */
    double g0, g1, g2; /* |a·(b×c)|, (a+b)·c, 1 + a·b */
    vec3_f64 n;        /* unit normal */
    double height;     /* of the point above the plane, >= 0 */
    double clear;      /* of its face */
    double angle;      /* solid angle; 0 if height <= clear: the point may lie on either side of the plane */
} shape_seen;

/* Van Oosterom and Strackee 1983. The triple product is computed as twice the area times the height: nothing
 * cancels if the triangle is small. */
SHAPE_INLINE shape_seen shape_see(vec3_f64 p, vec3_f64 a, vec3_f64 b, vec3_f64 c, double clear) {
    vec3_f64 n = cross_f64(sub_f64(b, a), sub_f64(c, a)), pa = sub_f64(a, p), pb = sub_f64(b, p),
             pc = sub_f64(c, p);
    double la = inverse_root(dot_f64(pa, pa)), lb = inverse_root(dot_f64(pb, pb)),
           lc = inverse_root(dot_f64(pc, pc));
    double volume = fabs(dot_f64(pa, n)), size = inverse_root(dot_f64(n, n) + 0x1p-1000);
    shape_seen s = {.a = scale_f64(la, pa), .b = scale_f64(lb, pb), .c = scale_f64(lc, pc)};
    s.g0 = volume * la * lb * lc;
    s.g1 = dot_f64(s.a, s.c) + dot_f64(s.b, s.c);
    s.g2 = 1 + dot_f64(s.a, s.b);
    s.n = scale_f64(size, n);
    s.height = volume * size, s.clear = clear;
    double angle = 2 * shape_angle(s.g0, s.g1 + s.g2);
    s.angle = s.height > clear ? angle : 0;
    return s;
}

/* Uniform over the solid angle (Peters, "BRDF importance sampling for polygonal lights", 2021). c moves to c'
 * on its edge to a, so that (a, b, c') covers the fraction u: c' is a mirrored at o = x a + y c, and the
 * tangent of half the solid angle is y g0 / (x g2 + y g1). Then v chooses a point on the arc from b to c',
 * uniform in the cosine. Cosines near 1 are written as 1 - q, with q half a squared difference. */
SHAPE_INLINE vec3_f64 shape_triangle_sample(const shape_seen *s, double u, double v) {
    double half = 0.5 * u * s->angle, folded = half > SHAPE_PI / 2 ? SHAPE_PI - half : half;
    double cosine = shape_sine(SHAPE_PI / 2 - half), sine = shape_sine(folded);
    vec3_f64 o = madd_f64(scale_f64(s->g0 * cosine - s->g1 * sine, s->a), s->g2 * sine, s->c);
    double k = 2 * dot_f64(s->a, o) / (dot_f64(o, o) + 0x1p-1000);
    vec3_f64 c = sub_f64(scale_f64(k, o), s->a), apart = sub_f64(s->b, c);
    double q = 0.5 * dot_f64(apart, apart), t = sqrt(v * (2 - v * q) / (2 - q));
    vec3_f64 d = madd_f64(scale_f64(1 - v * q - t * (1 - q), s->b), t, c);
    return scale_f64(inverse_root(dot_f64(d, d)), d);
}

static inline vec3_f64 shape_choose(bool first, vec3_f64 a, vec3_f64 b) {
    return (vec3_f64){first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}
/* a or b, member by member, in a form that vectorises. */
SHAPE_INLINE shape_seen shape_either(bool first, const shape_seen *a, const shape_seen *b) {
    return (shape_seen){.a = shape_choose(first, a->a, b->a),
                        .b = shape_choose(first, a->b, b->b),
                        .c = shape_choose(first, a->c, b->c),
                        .g0 = first ? a->g0 : b->g0,
                        .g1 = first ? a->g1 : b->g1,
                        .g2 = first ? a->g2 : b->g2,
                        .n = shape_choose(first, a->n, b->n),
                        .height = first ? a->height : b->height,
                        .clear = a->clear,
                        .angle = first ? a->angle : b->angle};
}

/* 1 / angle; 0 if the solid angle is so small that double cannot hold its inverse. */
static inline double shape_inverse(double angle) {
    double inverse = 1 / (angle + 0x1p-1010);
    return angle > 0x1p-1000 ? inverse : 0;
}

/* The length at which a shadow ray along the unit vector d must end to stay clear of the plane. */
SHAPE_INLINE double shape_face_end(const shape_seen *s, vec3_f64 d, double slope) {
    double cosine = fabs(dot_f64(d, s->n)) + 0x1p-1000, length = s->height / cosine;
    double end = length - (s->clear + slope * length) / cosine;
    return end > 0x1p-126 ? end : 0x1p-126;
}

/* ---- spheres ---- */

/* The cone that a sphere covers. In a space whose unit directions d become k times as long in world space. */
typedef struct shape_cone {
    vec3_f64 axis;   /* unit, towards the centre */
    double distance; /* of the centre */
    double cap;      /* 1 - cos of half the angle that the sphere covers */
} shape_cone;

/* from: the vector from the centre to the point, which lies outside. */
static inline shape_cone shape_cone_of(vec3_f64 from, double radius) {
    double d = sqrt(dot_f64(from, from)), s = radius / d, square = s * s < 1 ? s * s : 1;
    return (shape_cone){scale_f64(-1 / d, from), d, square / (1 + sqrt(1 - square))};
}
static inline vec3_f64 shape_cone_sample(const shape_cone *cone, double u, double v) {
    double c, s, x = u * cone->cap, r = sqrt(x * (2 - x));
    shape_turn(v, &c, &s);
    return shape_around(cone->axis, r * c, r * s, 1 - x);
}
/* Unit vectors at the angle a are the root of 2 (1 - cos a) apart. */
static inline bool shape_cone_holds(const shape_cone *cone, vec3_f64 direction) {
    const vec3_f64 apart = sub_f64(direction, cone->axis);
    return dot_f64(apart, apart) <= 2 * cone->cap;
}
static inline double shape_cone_angle(const shape_cone *cone) { return 2 * SHAPE_PI * cone->cap; }

/* The distance from `from` along d to the nearer (side -1) or the farther (1) intersection with a sphere
 * around the origin; if the ray just misses the sphere, the distance of the closest approach. d need not be
 * unit. */
static inline double shape_sphere_root(vec3_f64 from, vec3_f64 d, double radius, double side) {
    double a = dot_f64(d, d), t = -dot_f64(from, d) / a;
    vec3_f64 nearest = madd_f64(from, t, d);
    double square = (radius * radius - dot_f64(nearest, nearest)) / a;
    return square > 0 ? t + side * sqrt(square) : t;
}
