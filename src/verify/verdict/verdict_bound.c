/* Forward error of the intersectors, to first order in the unit roundoff u.
 *
 * S bounds every number that is a length: in object space |E| + |t d| + the largest |V|. In an instance with
 * map M and translation T, the ray's part is |M| (|E| + |T| + |t d|), times |M| |A| for a tracer that
 * computes M as the inverse of A itself. In object space the ray is rounded once more, by u S. L is the
 * longest side, n = e × e' with |n| <= L².
 *
 * Triangle, by edge planes (Embree's robust mode) or Cramer's rule: differences and cross products cost 4 u L
 * S in an edge's normal e × v, products and sums 3 more: 7 u |d| L S. So the error of the weights is 7 u |d|
 * L S / |d·n|, and the same again for the division by their sum: 14. t = n·v / n·d: 7 u L² S in the
 * numerator, 6 u L² |d| in the denominator, which is 6 u L² S / |d·n| in t: 13, and 3 more for an approximate
 * reciprocal. By shearing (Woop): a sheared coordinate has an error of 5 u S. The edge functions of sheared
 * vertices are exact if a sign is in doubt, so the error of the weights is 2 · 5 u |d| L S / |d·n|, otherwise
 * 13 of these units. Depth is interpolated over two sides of depth at most L / |d|: 26 u L² S / |d·n|. So 32
 * bounds all of them, with room for the rounding of the ray in object space. Grazing rays and slivers enter
 * by |d·n|.
 *
 * If sides are differences of corners relative to E, as in Embree, their error is 2 u S, and that of n is 4 u
 * L S. n is used in both n·v and n·d, so the error of t is 4 u L S |V - P| / |d·n| with P on the plane: at
 * most 4 u L S L / |d·n| for hits. For a point outside the triangle, which the exact ray just misses, |V - P|
 * <= L Σ|w_k|, with its weights. d·n also gets an error of 4 u L S |d|: from so far away that this equals
 * d·n, the normal is lost and t is arbitrary. The 4 u |d| L S / |d·n| are an eighth of the bound of the
 * weights.
 *
 * All of this is to first order and assumes an accurate denominator. But d·n has an error of 6 u L² |d|, and
 * d that of the map. If r = K u L² |d| / |d·n| is not small, the bounds grow by 1 / (1 - r). From r = 1 on
 * there is no bound: the ray cannot be distinguished from one in the triangle's plane.
 *
 * Quad: as its triangles.
 *
 * Sphere in the form without cancellation (sphere_text.h): |δD| <= 36 u |f| √(R² + l²), |f| <= S: 1 - l²/R²
 * has an error of 36 u S √(R² + l²) / R² <= 36 u S (R + l) / R²; from so far away that the error of l exceeds
 * R, l is the larger. The root moves by |δD| / (2 |d| √D) <= 26 u S R / |d·m| with m = P - C and |d·m| = |d|
 * √D; c / q adds 27 u |t|, b / a 6 u |f| / |d|: at most 33 u S R / |d·m|, since |d·m| <= |d| R. 64 bounds
 * both sums. |d·m| = |d|² |t - t'| / 2, with t' the other root.
 *
 * Plane: the error of f·n is 4 u |n| S, that of d·n is 3 u |n| |d|: together 7 u |n| S / |d·n|, and 16 with
 * the roundings of origin and quotient. */
#include "reference/reference.h"
#include "verify/verdict/verdict.h"

#include <float.h>

typedef struct frame {
    vec3_f64 org, dir;
    double norm, inverse_norm; /* of the map's linear part and its inverse; 1 in the world */
    double shift;              /* of to_world */
    double dir_size;           /* bounds |dir|; the direction's error is relative to it */
} frame;

static double norm_of(const float m[3][4]) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) sum += (double)m[i][j] * (double)m[i][j];
    }
    return sqrt(sum);
}

static frame frame_of(const verdict_tracer *tracer, const oracle_ray *ray, const world_instance *instance) {
    frame f = {widen(ray->org), widen(ray->dir), 1, 1, 0, length_f64(widen(ray->dir))};
    if (!instance) return f;
    const affine_f64 to_object = affine_widen(instance->to_object);
    f.org = affine_point(&to_object, f.org), f.dir = affine_vector(&to_object, f.dir);
    f.norm = norm_of(instance->to_object), f.inverse_norm = norm_of(instance->to_world);
    vec3_f64 shift = {(double)instance->to_world[0][3], (double)instance->to_world[1][3],
                      (double)instance->to_world[2][3]};
    f.shift = length_f64(shift);
    f.dir_size *= f.norm * (tracer->inverted ? f.norm * f.inverse_norm : 1);
    return f;
}

static bool in_float(const verdict_tracer *tracer) { return tracer->unit >= 0x1p-24; }

double verdict_rounding(const verdict_tracer *tracer, double t) {
    double flushed = in_float(tracer) ? (double)FLT_MIN : 0;
    return VERDICT_ULPS * 2 * fmax(tracer->unit, 0x1p-53) * fabs(t) + flushed;
}

double verdict_constant(oracle_shape shape) {
    switch (shape) {
    case ORACLE_SPHERE: return 64;
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: return 32;
    case ORACLE_PLANE: return 16;
    }
    return 0;
}

/* 1 / (1 - r), or infinite. */
static double widened(double r) { return r < 1 ? 1 / (1 - r) : (double)INFINITY; }

static verdict_bound of_triangle(const frame *f, const vec3_f32 v[3], const oracle_answer *answer,
                                 double size, double factor) {
    vec3_f64 a = widen(v[0]), b = widen(v[1]), c = widen(v[2]), n = cross_f64(sub_f64(b, a), sub_f64(c, a));
    double along = fabs(dot_f64(f->dir, n)), d = length_f64(f->dir);
    double side = fmax(length_f64(sub_f64(b, a)), fmax(length_f64(sub_f64(c, a)), length_f64(sub_f64(c, b))));
    double wide = widened(factor * side * side * f->dir_size / along) / along;
    double spread = 0; /* of the weights, 1 within */
    for (int k = 0; k < 3; ++k) spread += fabs((double)answer->weight[k]);
    return (verdict_bound){side * side * fmax(1, spread) * size * wide, d * side * size * wide, size, 0, 0};
}

/* If the line misses, the closest approach at t' replaces the roots. They differ from it by at most √|δD| /
 * |d|, which is of the order √u, so `factor` moves under the root. */
static verdict_bound of_sphere(const frame *f, double radius, const oracle_answer *answer, double size,
                               double factor) {
    double d = length_f64(f->dir), l = sqrt(fmax(0, 1 - (double)answer->edge)); /* divided by R */
    double edge = size * (1 + l) / radius;
    if (!answer->line) return (verdict_bound){(size + radius * sqrt(edge / factor)) / d, edge, size, 0, 0};
    double gap = fabs((double)(answer->t - answer->other));
    return (verdict_bound){size * radius / (d * d * gap / 2), edge, size, 0, 0};
}

static verdict_bound of_plane(const frame *f, vec3_f64 n, double size, double factor) {
    double along = fabs(dot_f64(f->dir, n)), r = factor * length_f64(n) * f->dir_size / along;
    return (verdict_bound){length_f64(n) * size / along * widened(r), 0, size, 0, 0};
}

static verdict_bound of_shape(const frame *f, const oracle_primitive *p, const oracle_answer *answer,
                              double size, double factor) {
    switch (p->shape) {
    case ORACLE_SPHERE: return of_sphere(f, oracle_radius(p), answer, size, factor);
    case ORACLE_PLANE: return of_plane(f, widen(p->v[1]), size, factor);
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: break;
    }
    vec3_f32 corners[3];
    oracle_part(p, answer->part, corners);
    return of_triangle(f, corners, answer, size, factor);
}

/* ---- intersections without rounding ---- */

/* A multiple of 1/16 up to 16: products of three differences of such numbers fit in float. */
static bool has_few_digits(double x) { return fabs(x) <= 16 && 16 * x == floor(16 * x); }

static bool is_plain(vec3_f32 p) {
    return has_few_digits((double)p.x) && has_few_digits((double)p.y) && has_few_digits((double)p.z);
}

static bool is_power(double x) {
    int exponent;
    return fabs(frexp(x, &exponent)) == 0.5;
}

/* The axis of the ray if its direction is a power of two along an axis; else -1. */
static int axis_of(const oracle_ray *ray) {
    const double d[3] = {(double)ray->dir.x, (double)ray->dir.y, (double)ray->dir.z};
    int axis = -1;
    for (int i = 0; i < 3; ++i) {
        if (d[i] == 0) continue;
        if (axis >= 0 || !is_power(d[i]) || fabs(d[i]) > 256 || fabs(d[i]) < 1.0 / 256) return -1;
        axis = i;
    }
    return axis;
}

static double part_of(vec3_f32 v, int axis) { return (double)(axis == 0 ? v.x : axis == 1 ? v.y : v.z); }

/* True when all corners have few digits, the primitive is perpendicular to the axis, and its area is a power
 * of two. */
static bool is_level(const oracle_primitive *p, int axis) {
    if (p->shape == ORACLE_PLANE)
        return is_plain(p->v[0]) && fabs(part_of(p->v[1], axis)) == 1 && length_f64(widen(p->v[1])) == 1;
    const unsigned corners = oracle_corners(p);
    for (unsigned k = 0; k < corners; ++k) {
        if (!is_plain(p->v[k]) || part_of(p->v[k], axis) != part_of(p->v[0], axis)) return false;
    }
    vec3_f64 a = widen(p->v[0]);
    vec3_f64 n = cross_f64(sub_f64(widen(p->v[1]), a), sub_f64(widen(p->v[corners - 1]), a));
    return is_power(n.x + n.y + n.z);
}

/* True when every intersector computes this t without rounding: the direction is a power of two along an
 * axis, and the ray hits at right angles a primitive whose coordinates and weights have few digits. Then
 * rounding does not affect the ends of the interval either. */
static bool is_exact(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *p,
                     const oracle_answer *answer) {
    int axis = axis_of(ray);
    bool ours = tracer->strict && !(tracer->seen >> p->shape & 1);
    if (!ours || p->instance || p->shape == ORACLE_SPHERE || axis < 0) return false;
    bool exact = is_plain(ray->org) && is_level(p, axis);
    for (int k = 0; k < 3 && p->shape != ORACLE_PLANE; ++k)
        exact = exact && has_few_digits((double)answer->weight[k]);
    return exact;
}

/* ---- the bounds ---- */

static double largest_corner(const oracle_primitive *p) {
    if (p->shape == ORACLE_PLANE) return length_f64(widen(p->v[0]));
    if (p->shape == ORACLE_SPHERE) return length_f64(widen(p->v[0])) + (double)p->radius;
    double size = 0;
    for (unsigned k = 0; k < oracle_corners(p); ++k) size = fmax(size, length_f64(widen(p->v[k])));
    return size;
}

/* S at the ray's t. */
static double size_of(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *p,
                      const frame *f, double t) {
    double reach = length_f64(widen(ray->org)) + f->shift + fabs(t) * length_f64(widen(ray->dir));
    /* A flushed result has an error of at most FLT_MIN, like rounding in a number of size FLT_MIN / u. */
    double size = f->norm * reach + (in_float(tracer) ? (double)FLT_MIN / tracer->unit : 0);
    if (tracer->inverted && p->instance) size *= f->norm * f->inverse_norm;
    return size + largest_corner(p);
}

verdict_bound verdict_bound_of(const verdict_tracer *tracer, const oracle_ray *ray,
                               const oracle_primitive *primitive, const oracle_answer *answer) {
    frame f = frame_of(tracer, ray, primitive->instance);
    double t = (double)answer->t, size = size_of(tracer, ray, primitive, &f, t);
    double factor = verdict_constant(primitive->shape) * tracer->unit;
    verdict_bound bound = of_shape(&f, primitive, answer, size, factor);
    bound.t = factor * bound.t + verdict_rounding(tracer, t);
    bound.edge *= factor;
    bound.aside *= factor * (primitive->instance ? f.inverse_norm : 1);
    if (is_exact(tracer, ray, primitive, answer)) bound.t = bound.edge = 0;
    return bound;
}

/* The angle between the normals of a quad's parts. */
static double twist_of(const oracle_primitive *quad) {
    const vec3_f32 *v = quad->v;
    vec3_f64 n = cross_f64(sub_f64(widen(v[1]), widen(v[0])), sub_f64(widen(v[3]), widen(v[0])));
    vec3_f64 m = cross_f64(sub_f64(widen(v[3]), widen(v[2])), sub_f64(widen(v[1]), widen(v[2])));
    return atan2(length_f64(cross_f64(n, m)), dot_f64(n, m));
}

/* The normal (not unit) and corners of the triangle, or of the quad's part that was hit. */
static vec3_f64 normal_of(const oracle_primitive *p, const oracle_answer *answer, vec3_f64 *a, vec3_f64 *b,
                          vec3_f64 *c) {
    vec3_f32 v[3];
    oracle_part(p, answer->part, v);
    *a = widen(v[0]), *b = widen(v[1]), *c = widen(v[2]);
    return cross_f64(sub_f64(*b, *a), sub_f64(*c, *a));
}

/* Embree divides by the sum of the weights, d·n, and sets the quotients to 0 if it is below 1e-18. The factor
 * 2 leaves room for rounding. */
static bool clamps_weights(const verdict_tracer *tracer, const oracle_primitive *p,
                           const oracle_answer *answer, vec3_f64 dir) {
    if (!(tracer->seen >> p->shape & 1)) return false;
    vec3_f64 a, b, c;
    return fabs(dot_f64(normal_of(p, answer, &a, &b, &c), dir)) < 2 * tracer->clamped;
}

/* The maximum rotation of a vector whose error is this fraction of its length: asin(share) <= 2 share. From 1
 * on, the vector may be zero or point anywhere. */
static double turn_of(double share) { return share < 1 ? 2 * share : 4; }

/* The error of sides is 2 u of their length or, if computed relative to the ray's origin, of S; the products
 * and differences of n = e × e' add the same again: 16 u L S / |n| covers both. Two products and their
 * difference, flushed to zero below 2^-126, add 3 √3 2^-126. A flushed side changes n by less than 16 u L² if
 * L is above 2^-104; below, all of n is flushed. A normal above the largest float cannot be reported:
 * infinite. A quad's normal may be that of either part. */
static double normal_bound(const verdict_tracer *tracer, const oracle_primitive *p,
                           const oracle_answer *answer, double size) {
    vec3_f64 a, b, c, n = normal_of(p, answer, &a, &b, &c);
    double side = fmax(length_f64(sub_f64(b, a)), fmax(length_f64(sub_f64(c, a)), length_f64(sub_f64(c, b))));
    double reach = tracer->seen >> p->shape & 1 ? size : side;
    if (2 * side * side > (double)FLT_MAX) return (double)INFINITY;
    double r = (16 * fmax(tracer->unit, 0x1p-24) * side * reach + 6 * (double)FLT_MIN) / length_f64(n);
    return turn_of(r) + (p->shape == ORACLE_QUAD ? twist_of(p) : 0);
}

/* In every precision normals are reported in float, u and v in double. */
verdict_bound verdict_bound_all(const verdict_tracer *tracer, const oracle_ray *ray,
                                const oracle_primitive *p, const oracle_answer *answer) {
    verdict_bound bound = verdict_bound_of(tracer, ray, p, answer);
    const double unit = fmax(tracer->unit, 0x1p-24), least = 8 * unit;
    const double flushed = 2 * (double)FLT_MIN; /* one FLT_MIN per component: √3, rounded up to 2 */
    frame f = frame_of(tracer, ray, p->instance);
    double size = size_of(tracer, ray, p, &f, (double)answer->t);
    bound.weight =
        clamps_weights(tracer, p, answer, f.dir) ? 1 : bound.edge + 4 * fmax(tracer->unit, 0x1p-53);
    switch (p->shape) {
    case ORACLE_SPHERE:
        bound.normal = least + 2 * (bound.t * length_f64(f.dir) + 8 * unit * size) / oracle_radius(p) +
                       turn_of(flushed / oracle_radius(p));
        break;
    case ORACLE_PLANE: bound.normal = least; break; /* a copy of the world's, with denormals */
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: bound.normal = least + normal_bound(tracer, p, answer, size); break;
    }
    return bound;
}

/* |t d| is at most |E| + extent, and corners are at most |M| extent. */
double verdict_aside(const verdict_tracer *tracer, const world *w, const oracle_ray *ray, double extent) {
    double far = 2 * length_f64(widen(ray->org)) + extent, factor = 64 * tracer->unit;
    double most = factor * (far + extent);
    for (size_t k = 0; k < w->instances.count; ++k) {
        frame f = frame_of(tracer, ray, &w->instances.items[k]);
        double spread = f.norm * f.inverse_norm, share = tracer->inverted ? spread : 1;
        most = fmax(most, factor * spread * ((far + f.shift) * share + extent));
    }
    return most;
}

double verdict_reported(const verdict_tracer *tracer, const oracle_primitive *p, const verdict_bound *bound) {
    return tracer->seen >> p->shape & 1 ? bound->t * widened(bound->edge / 8) : bound->t;
}

/* The same limit as in embree_limits.c. */
static bool origin_beyond(const world *w, vec3_f32 org, double limit) {
    double size = (double)largest_f32(org);
    if (size > limit) return true;
    for (size_t k = 0; k < w->instances.count; ++k) {
        for (int i = 0; i < 3; ++i) {
            const float *m = w->instances.items[k].to_object[i];
            double s = fabs((double)m[0]) + fabs((double)m[1]) + fabs((double)m[2]);
            if (size * s + fabs((double)m[3]) > limit) return true;
        }
    }
    return false;
}

bool verdict_beyond(const verdict_tracer *tracer, const world *w, const oracle_ray *ray,
                    const oracle_primitive *p, double t) {
    if (in_float(tracer) && fabs(t) > (double)FLT_MAX) return true;
    if (!(tracer->largest > 0)) return false;
    return largest_corner(p) > tracer->largest || origin_beyond(w, ray->org, tracer->largest);
}

bool verdict_in_plane(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *p) {
    if (p->shape == ORACLE_SPHERE) return false;
    frame f = frame_of(tracer, ray, p->instance);
    vec3_f64 v = widen(p->v[0]), n = widen(p->v[1]);
    if (p->shape != ORACLE_PLANE)
        n = cross_f64(sub_f64(n, v), sub_f64(widen(p->v[p->shape == ORACLE_QUAD ? 3 : 2]), v));
    double limit = verdict_constant(p->shape) * tracer->unit * size_of(tracer, ray, p, &f, 0);
    double length = length_f64(n);
    return length > 0 && fabs(dot_f64(sub_f64(f.org, v), n)) <= limit * length;
}
