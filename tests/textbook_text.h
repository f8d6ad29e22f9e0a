/* Intersectors as lectures have them, formula by formula: the one text that textbook.h stamps for each
 * precision. */

/* The quadratic as lectures have it: a = |d|², b = 2 d·(E-C), c = |E-C|² - R², b² - 4ac. It loses |E-C|²/R²
 * units of roundoff in the discriminant: at 4096 radii a third of near-silhouette rays go wrong in float. */
static inline bool FN(sphere_textbook)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                       REAL *t) {
    VEC3 f = FN(sub)(org, center);
    REAL a = FN(dot)(dir, dir), b = 2 * FN(dot)(dir, f), c = FN(dot)(f, f) - radius * radius;
    REAL discriminant = b * b - 4 * a * c;
    if (!(discriminant >= 0) || !(radius > 0)) return false;
    REAL s = SQRT(discriminant);
    REAL near = (-b - s) / (2 * a), far = (-b + s) / (2 * a);
    *t = near > t_min ? near : far;
    return *t > t_min && *t < t_max;
}

/* Cramer's rule as lectures have it, with a = A-C, b = B-C, e = E-C, D = (d×b)·a: t = (e×a)·b / D,
 * α = (d×b)·e / D, β = (e×a)·d / D, and P = αA + βB + (1-α-β)C. Neighbours round their common edge
 * differently: rays can pass between them. */
static inline bool FN(triangle_textbook)(VEC3 A, VEC3 B, VEC3 C, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                         FN(reference_hit) * hit) {
    VEC3 a = FN(sub)(A, C), b = FN(sub)(B, C), e = FN(sub)(org, C);
    VEC3 db = FN(cross)(dir, b), ea = FN(cross)(e, a);
    REAL D = FN(dot)(db, a);
    REAL t = FN(dot)(ea, b) / D, alpha = FN(dot)(db, e) / D, beta = FN(dot)(ea, dir) / D;
    if (!(t > t_min && t < t_max && alpha >= 0 && beta >= 0 && alpha + beta <= 1)) return false;
    hit->t = t, hit->u = beta, hit->v = 1 - alpha - beta;
    return true;
}

/* Plane through v0 spanned by u = v1-v0 and v = v3-v0, t = (v0-E)·n / (d·n), then the coordinates of the
 * point along u and v: inside when both are at least 0 and at most 1. Beyond the diagonal the sides v2 v3 and
 * v2 v1 bound it, so planar quads that are no parallelograms are right too. Parallel rays miss. */
static inline bool FN(quad_textbook)(VEC3 v0, VEC3 v1, VEC3 v2, VEC3 v3, VEC3 org, VEC3 dir, REAL t_min,
                                     REAL t_max, FN(reference_hit) * hit) {
    VEC3 e = FN(sub)(v1, v0), g = FN(sub)(v3, v0), n = FN(cross)(e, g);
    REAL t = FN(dot)(FN(sub)(v0, org), n) / FN(dot)(dir, n);
    if (!(t > t_min && t < t_max)) return false;
    VEC3 p = FN(madd)(org, t, dir), q = FN(sub)(p, v0);
    REAL n2 = FN(dot)(n, n), u = FN(dot)(FN(cross)(q, g), n) / n2, v = FN(dot)(FN(cross)(e, q), n) / n2;
    bool inside = u >= 0 && v >= 0;
    if (u + v > 1) {
        e = FN(sub)(v3, v2), g = FN(sub)(v1, v2), q = FN(sub)(p, v2), n = FN(cross)(e, g), n2 = FN(dot)(n, n);
        u = 1 - FN(dot)(FN(cross)(q, g), n) / n2, v = 1 - FN(dot)(FN(cross)(e, q), n) / n2;
        inside = u <= 1 && v <= 1;
    }
    hit->t = t, hit->u = u, hit->v = v;
    return inside;
}

/* The plane (P - point)·n = 0: t = (point-E)·n / (d·n). n need not be unit. Parallel rays miss. */
static inline bool FN(plane_textbook)(VEC3 point, VEC3 normal, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                      REAL *t) {
    *t = FN(dot)(FN(sub)(point, org), normal) / FN(dot)(dir, normal);
    return *t > t_min && *t < t_max;
}
