/* Triangles A, B, C. Included once per precision; see stamp.h. A hit at P has u and v with P = (1-u-v) A + u
 * B + v C. */

/* The ray, prepared for the watertight test; computed once for many triangles. */
typedef struct FN(triangle_ray) {
    VEC3 org;
    REAL dz, sx, sy; /* the largest component of the direction; the other two divided by it */
    int axis;        /* index of the largest component */
} FN(triangle_ray);

/* v with its coordinates permuted cyclically so that `axis` comes last. */
static inline VEC3 FN(turned)(VEC3 v, int axis) {
    VEC3 r = {axis == 0   ? v.y
              : axis == 1 ? v.z
                          : v.x,
              axis == 0   ? v.z
              : axis == 1 ? v.x
                          : v.y,
              axis == 0   ? v.x
              : axis == 1 ? v.y
                          : v.z};
    return r;
}

static inline FN(triangle_ray) FN(triangle_ray_make)(VEC3 org, VEC3 dir) {
    REAL x = ABS(dir.x), y = ABS(dir.y), z = ABS(dir.z);
    int axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    VEC3 d = FN(turned)(dir, axis);
    FN(triangle_ray) ray = {org, d.z, d.x / d.z, d.y / d.z, axis};
    return ray;
}

/* The vertex in the ray's sheared space, where the ray starts at 0 and runs along z. The result depends only
 * on the ray and the vertex, so triangles that share a vertex get the same bits. */
static inline VEC3 FN(sheared)(const FN(triangle_ray) * ray, VEC3 p) {
    VEC3 q = FN(turned)(FN(sub)(p, ray->org), ray->axis);
    return FN(vec)(q.x - ray->sx * q.z, q.y - ray->sy * q.z, q.z);
}

/* False when the area cannot be distinguished from zero even in the next wider precision. Each component of
 * the cross product has an error of at most 8 u times the product of the longest sides. */
static inline bool FN(triangle_has_area)(VEC3 a, VEC3 b, VEC3 c) {
    VEC3 e = FN(sub)(b, a), g = FN(sub)(c, a);
    if (FN(largest)(FN(cross)(e, g)) > 8 * UNIT * FN(largest)(e) * FN(largest)(g) + AREA_LOW) return true;
    return FN(triangle_has_area_wide)(a, b, c);
}

/* The watertight test on sheared vertices (Woop, Benthin, Wald 2013, Journal of Computer Graphics Techniques
 * 2(1)): the ray hits the triangle if the three edge functions do not differ in sign. Rounding cannot change
 * a sign, it can only give zero. Then, or when the sum leaves the range of full relative precision, the
 * products are computed again in the next wider precision, where they are exact. So neighbours always agree
 * about their common edge, and no ray passes between them.
 *
 * The depth is computed from A and the differences to it. Its error is a few units of the distance to A, plus
 * the edges' depth times the relative error of u and v. */
static inline bool FN(triangle_sheared)(const FN(triangle_ray) * ray, VEC3 a, VEC3 b, VEC3 c, REAL t_min,
                                        REAL t_max, FN(reference_hit) * hit) {
    REAL u = c.x * b.y - c.y * b.x, v = a.x * c.y - a.y * c.x, w = b.x * a.y - b.y * a.x;
    bool negative = (u < 0) | (v < 0) | (w < 0), positive = (u > 0) | (v > 0) | (w > 0);
    if (negative & positive) return false;
    REAL sum = u + v + w, size = ABS(sum), weight[2] = {v / sum, w / sum};
    if ((u == 0) | (v == 0) | (w == 0) | !((size > AREA_LOW) & (size < AREA_HIGH))) {
        if (!FN(triangle_weights_wide)(a, b, c, weight)) return false;
    }
    REAL t = (a.z + (weight[0] * (b.z - a.z) + weight[1] * (c.z - a.z))) / ray->dz;
    if (!((t > t_min) & (t < t_max))) return false;
    hit->t = t, hit->u = weight[0], hit->v = weight[1];
    return true;
}

/* For many triangles and one ray. Triangles with a vertex that is not finite or without area are never
 * hit. */
static inline bool FN(triangle_robust_ray)(VEC3 a, VEC3 b, VEC3 c, const FN(triangle_ray) * ray, REAL t_min,
                                           REAL t_max, FN(reference_hit) * hit) {
    return FN(triangle_sheared)(ray, FN(sheared)(ray, a), FN(sheared)(ray, b), FN(sheared)(ray, c), t_min,
                                t_max, hit) &&
           FN(triangle_has_area)(a, b, c);
}

/* Two-sided. t in (t_min, t_max), in units of |dir|, which need not be 1. */
static inline bool FN(triangle_robust)(VEC3 a, VEC3 b, VEC3 c, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                       FN(reference_hit) * hit) {
    FN(triangle_ray) ray = FN(triangle_ray_make)(org, dir);
    return FN(triangle_robust_ray)(a, b, c, &ray, t_min, t_max, hit);
}
