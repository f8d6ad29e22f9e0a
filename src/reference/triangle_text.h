/* Triangles A, B, C: the one text that reference.h stamps for each precision.
 * Hits carry P = (1-u-v) A + u B + v C. */

/* The ray as the watertight test needs it, computed once for many triangles. */
typedef struct FN(triangle_ray) {
    VEC3 org;
    REAL dz, sx, sy; /* the largest component of the direction; the other two over it */
    int axis;        /* which one it is */
} FN(triangle_ray);

/* v with its coordinate `axis` last, in cyclic order. */
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

/* The vertex as the ray sees it: the ray starts at 0 and runs along z. It depends on the ray and the vertex
 * alone, so triangles that share the vertex agree on it to the last bit. */
static inline VEC3 FN(sheared)(const FN(triangle_ray) * ray, VEC3 p) {
    VEC3 q = FN(turned)(FN(sub)(p, ray->org), ray->axis);
    return FN(vec)(q.x - ray->sx * q.z, q.y - ray->sy * q.z, q.z);
}

/* False when the triangle's area cannot be told from zero in the next wider precision. Each component of the
 * computed cross product is off by at most 8 u times the longest sides. */
static inline bool FN(triangle_has_area)(VEC3 a, VEC3 b, VEC3 c) {
    VEC3 e = FN(sub)(b, a), g = FN(sub)(c, a);
    if (FN(largest)(FN(cross)(e, g)) > 8 * UNIT * FN(largest)(e) * FN(largest)(g) + AREA_LOW) return true;
    return FN(triangle_has_area_wide)(a, b, c);
}

/* The watertight test on sheared vertices (Woop, Benthin, Wald 2013, Journal of Computer Graphics Techniques
 * 2(1)): the ray meets the triangle when the three edge functions do not differ in sign. Rounding cannot turn
 * a sign, only make it zero; then, or when the sum leaves the range of full relative precision, the products
 * are formed again in the next wider precision, where they are exact. So neighbours never disagree about
 * their edge, and a ray cannot pass between them.
 *
 * The depth is computed from A and the differences to it: its error is a few units of the distance to A, and
 * of the edges' depth times the relative error of u and v. */
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

/* For many triangles and one ray. Vertices that are not finite and triangles without area are never met. */
static inline bool FN(triangle_robust_ray)(VEC3 a, VEC3 b, VEC3 c, const FN(triangle_ray) * ray, REAL t_min,
                                           REAL t_max, FN(reference_hit) * hit) {
    return FN(triangle_sheared)(ray, FN(sheared)(ray, a), FN(sheared)(ray, b), FN(sheared)(ray, c), t_min,
                                t_max, hit) &&
           FN(triangle_has_area)(a, b, c);
}

/* Both sides count. t in (t_min, t_max), in units of |dir|, which need not be 1. */
static inline bool FN(triangle_robust)(VEC3 a, VEC3 b, VEC3 c, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                       FN(reference_hit) * hit) {
    FN(triangle_ray) ray = FN(triangle_ray_make)(org, dir);
    return FN(triangle_robust_ray)(a, b, c, &ray, t_min, t_max, hit);
}
