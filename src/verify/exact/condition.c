/* Let s_i = |E_i| + |t| |d_i| + (size of the shape's own coordinate i). In units of u, this vector bounds how
 * far the ray's point and the surface move apart if inputs have a relative error of u.
 *
 * Triangle, n its normal: t changes by n·δ / (d·n) for a change δ of the origin, by t n·δ / (d·n) for one of
 * the direction, and by -w_k n·δ / (d·n) for one of corner k with weight w_k. So the condition of t is Σ|n_i|
 * s_i / |d·n| with the shape's size Σ_k |w_k| |V_k,i|.
 *
 * Sphere, m = P - C: t changes by m·δ / (d·m) and by R δR / (d·m), so the condition is (Σ|m_i| s_i + R²) /
 * |d·m|.
 *
 * Plane: as a triangle, plus |P - point|_i |n_i| for its normal.
 *
 * In an instance E is M E + T, and d is M d: their sizes are |M| |E| + |T| and |M| |d|. For a tracer that
 * inverts A to get M, each of its few roundings costs |M| |A| |M| instead of |M|. Sizes are computed in plain
 * binary128, because a condition number needs only one digit. */
#include "verify/exact/exact.h"
#include "verify/mode.h"

typedef real_f128 real;

typedef struct sizes {
    real org[3], dir[3];
    object_ray ray;
} sizes;

static void components(vec3_f128 v, real out[3]) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

static real weighted(vec3_f128 v, const real size[3]) {
    return abs_f128(v.x) * size[0] + abs_f128(v.y) * size[1] + abs_f128(v.z) * size[2];
}

/* |M| |A| |M| with its translation part, or |M| itself. */
static void map_sizes(const world_instance *instance, bool inverted, real out[3][4]) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) out[i][j] = abs_f128((real)instance->to_object[i][j]);
    }
    if (!inverted) return;
    real left[3][3] = {{0}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) left[i][j] += out[i][k] * abs_f128((real)instance->to_world[k][j]);
        }
    }
    for (int i = 0; i < 3; ++i) {
        real row[3] = {0};
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) row[j] += left[i][k] * abs_f128((real)instance->to_object[k][j]);
        }
        for (int j = 0; j < 3; ++j) out[i][3] += row[j] * abs_f128((real)instance->to_world[j][3]);
        for (int j = 0; j < 3; ++j) out[i][j] = row[j];
    }
}

static vec3_f128 carried(const float m[3][4], vec3_f128 p, real w) {
    real r[3];
    for (int i = 0; i < 3; ++i) {
        r[i] = (real)m[i][0] * p.x + (real)m[i][1] * p.y + (real)m[i][2] * p.z + (real)m[i][3] * w;
    }
    return (vec3_f128){r[0], r[1], r[2]};
}

object_ray object_ray_of(const oracle_ray *ray, const world_instance *instance) {
    const object_ray r = {quadruple_f32(ray->org), quadruple_f32(ray->dir)};
    if (!instance) return r;
    return (object_ray){carried(instance->to_object, r.org, 1), carried(instance->to_object, r.dir, 0)};
}

static void sizes_of(const oracle_ray *ray, const world_instance *instance, bool inverted, sizes *out) {
    real org[3], dir[3];
    components(quadruple_f32(ray->org), org);
    components(quadruple_f32(ray->dir), dir);
    out->ray = object_ray_of(ray, instance);
    for (int i = 0; i < 3; ++i) out->org[i] = abs_f128(org[i]), out->dir[i] = abs_f128(dir[i]);
    if (!instance) return;
    real m[3][4];
    map_sizes(instance, inverted, m);
    for (int i = 0; i < 3; ++i) {
        out->org[i] = m[i][3], out->dir[i] = 0;
        for (int j = 0; j < 3; ++j) {
            out->org[i] += m[i][j] * abs_f128(org[j]);
            out->dir[i] += m[i][j] * abs_f128(dir[j]);
        }
    }
}

static void moved(const sizes *size, real t, real out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = size->org[i] + abs_f128(t) * size->dir[i];
}

static void add_point(real out[3], real weight, vec3_f128 p) {
    out[0] += abs_f128(weight * p.x), out[1] += abs_f128(weight * p.y), out[2] += abs_f128(weight * p.z);
}

static double ratio(real a, real b) { return b == 0 ? (double)INFINITY : (double)(a / abs_f128(b)); }

static double of_triangle(const oracle_primitive *triangle, const sizes *size, const oracle_answer *answer) {
    vec3_f128 v[3];
    real s[3];
    moved(size, answer->t, s);
    for (int k = 0; k < 3; ++k) {
        v[k] = quadruple_f32(triangle->v[k]);
        add_point(s, answer->weight[k], v[k]);
    }
    vec3_f128 n = cross_f128(sub_f128(v[1], v[0]), sub_f128(v[2], v[0]));
    return ratio(weighted(n, s), dot_f128(size->ray.dir, n));
}

/* At a tangent, d·m is zero except for rounding. */
static double of_sphere(const oracle_primitive *sphere, const sizes *size, const oracle_answer *answer) {
    if (!(answer->edge > 0)) return (double)INFINITY;
    vec3_f128 center = quadruple_f64(oracle_center(sphere));
    vec3_f128 m = madd_f128(sub_f128(size->ray.org, center), answer->t, size->ray.dir);
    real radius = (real)sphere->radius + (real)sphere->radius_rest, s[3];
    moved(size, answer->t, s);
    add_point(s, 1, center);
    return ratio(weighted(m, s) + radius * radius, dot_f128(size->ray.dir, m));
}

static double of_plane(const oracle_primitive *plane, const sizes *size, const oracle_answer *answer) {
    vec3_f128 point = quadruple_f32(plane->v[0]), n = quadruple_f32(plane->v[1]);
    real s[3];
    moved(size, answer->t, s);
    add_point(s, 1, point);
    add_point(s, 1, sub_f128(madd_f128(size->ray.org, answer->t, size->ray.dir), point));
    return ratio(weighted(n, s), dot_f128(size->ray.dir, n));
}

MODE_APART double condition_of(const oracle_ray *ray, const oracle_primitive *primitive,
                               const oracle_answer *answer, bool inverted) {
    sizes size;
    sizes_of(ray, primitive->instance, inverted, &size);
    switch (primitive->shape) {
    case ORACLE_SPHERE: return of_sphere(primitive, &size, answer);
    case ORACLE_PLANE: return of_plane(primitive, &size, answer);
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: break;
    }
    return of_triangle(primitive, &size, answer);
}
