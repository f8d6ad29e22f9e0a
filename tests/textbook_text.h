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
