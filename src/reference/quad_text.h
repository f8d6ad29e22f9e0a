/* Quads v0 v1 v2 v3 (corners in order) and infinite planes. Included once per precision; see stamp.h. */

/* Zero times a number is zero unless it is infinite or NaN. */
static inline bool FN(corner_is_finite)(VEC3 p) { return p.x * 0 + p.y * 0 + p.z * 0 == 0; }

/* Tests the triangles (v0,v1,v3) and (v2,v3,v1), which is how Embree splits its QUAD, with the watertight
 * test: the diagonal leaks no more than the sides. Reports the nearer hit, on equal t the first triangle's.
 * (u,v) is (0,0) at v0, (1,0) at v1, (0,1) at v3, (1,1) at v2, and continuous over the diagonal. A quad with
 * a corner that is not finite is never hit, not even in the triangle without that corner. */
static inline bool FN(quad_robust)(VEC3 v0, VEC3 v1, VEC3 v2, VEC3 v3, VEC3 org, VEC3 dir, REAL t_min,
                                   REAL t_max, FN(reference_hit) * hit) {
    FN(triangle_ray) ray = FN(triangle_ray_make)(org, dir);
    VEC3 s0 = FN(sheared)(&ray, v0), s1 = FN(sheared)(&ray, v1), s2 = FN(sheared)(&ray, v2),
         s3 = FN(sheared)(&ray, v3);
    FN(reference_hit) second;
    bool met = FN(triangle_sheared)(&ray, s0, s1, s3, t_min, t_max, hit) && FN(triangle_has_area)(v0, v1, v3);
    if (met) t_max = hit->t;
    if (FN(triangle_sheared)(&ray, s2, s3, s1, t_min, t_max, &second) && FN(triangle_has_area)(v2, v3, v1)) {
        hit->t = second.t, hit->u = 1 - second.u, hit->v = 1 - second.v;
        met = true;
    }
    return met && FN(corner_is_finite)(v0) && FN(corner_is_finite)(v2);
}

/* The plane (P - point)·n = 0: t = (point-E)·n / (d·n). n need not be unit. Parallel rays miss. *sure:
 * rounding cannot have changed the sign of the numerator or the denominator. The difference, product and sums
 * have an error of at most 4 u of each of three products, so 12 u of the product of the largest components.
 * Above 64 u both signs are certain. */
static inline REAL FN(plane_ratio)(VEC3 point, VEC3 normal, VEC3 org, VEC3 dir, bool *sure) {
    VEC3 f = FN(sub)(point, org);
    REAL above = FN(dot)(f, normal), along = FN(dot)(dir, normal), n = FN(largest)(normal);
    REAL above_limit = 64 * UNIT * (n * FN(largest)(f)) + AREA_LOW;
    REAL along_limit = 64 * UNIT * (n * FN(largest)(dir)) + AREA_LOW;
    *sure = (ABS(above) > above_limit) & (ABS(above) < AREA_HIGH) & (ABS(along) > along_limit) &
            (ABS(along) < AREA_HIGH);
    return above / along;
}

/* Same, but in the next wider precision if the origin is nearly on the plane or the ray nearly parallel to
 * it. */
static inline bool FN(plane_robust)(VEC3 point, VEC3 normal, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                    REAL *t) {
    bool sure;
    *t = FN(plane_ratio)(point, normal, org, dir, &sure);
    if (!sure) *t = FN(plane_wide)(point, normal, org, dir);
    return *t > t_min && *t < t_max;
}
