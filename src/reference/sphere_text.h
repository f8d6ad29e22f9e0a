/* Spheres |P - C| = R. Included once per precision; see stamp.h. */

/* Computes both roots in order, without branches. False: the line misses.
 *
 * With f = E - C, a = |d|², b = -f·d: the discriminant D = R² - |l|² comes from the rejection l = f + (b/a)
 * d, so nothing of size |f|² is subtracted. With q = b + sign(b) √(a D) and c = |f|² - R², the roots are c/q
 * and q/a, so nothing is subtracted from √ either (Haines et al., Ray Tracing Gems, chapter 7).
 *
 * Errors, with u the unit roundoff: f, b, a and the sum give |δl| ≤ 10 u |f|, so |δD| ≤ 20 u |f||l| + 5 u (R²
 * + |l|²), at most 36 u |f| √(R² + |l|²) where D is near 0; and |δc| ≤ 6 u (|f|² + R²). *sure means that
 * sizes are in range, |D| is at least 256 u |f| √(R² + |l|²), seven times its error, and |c| is at least
 * R²/4. Then hit or miss and inside or outside are certain, c has a relative error of at most 54 u, and D of
 * at most 1/7. */
static inline bool FN(sphere_plain)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL roots[2], bool *sure) {
    VEC3 f = FN(sub)(org, center);
    REAL far = FN(largest)(f), big = far > radius ? far : radius, longest = FN(largest)(dir);
    REAL a = FN(dot)(dir, dir), b = -FN(dot)(f, dir);
    VEC3 l = FN(madd)(f, b / a, dir);
    REAL f2 = FN(dot)(f, f), l2 = FN(dot)(l, l), r2 = radius * radius;
    REAL c = f2 - r2, D = r2 - l2;
    *sure = (big > RANGE_LOW) & (big < RANGE_HIGH) & (longest > RANGE_LOW) & (longest < RANGE_HIGH) &
            (D * D > 65536 * UNIT * UNIT * f2 * (r2 + l2)) & (4 * ABS(c) > r2);
    REAL s = SQRT(a * (D < 0 ? 0 : D)), q = b < 0 ? b - s : b + s;
    REAL by_c = q != 0 ? c / q : 0, by_a = q / a;
    roots[0] = b < 0 ? by_a : by_c;
    roots[1] = b < 0 ? by_c : by_a;
    /* A ray that starts inside always hits. */
    return (((c < 0) & (D < 0)) | (D >= 0)) & (radius > 0);
}

/* Same, for any finite numbers: falls back to the next wider precision if not sure. */
static inline bool FN(sphere_roots)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL roots[2]) {
    bool sure, met = FN(sphere_plain)(center, radius, org, dir, roots, &sure);
    return sure ? met : FN(sphere_roots_wide)(center, radius, org, dir, roots);
}

/* The smaller root in (t_min, t_max), else the larger one. */
static inline bool FN(sphere_choose)(const REAL roots[2], REAL t_min, REAL t_max, REAL *t) {
    *t = roots[0] > t_min ? roots[0] : roots[1];
    return *t > t_min && *t < t_max;
}

/* Nearest root in (t_min, t_max). t is in units of |dir|, which need not be 1. Zero or negative radii and
 * zero directions miss. Float and double agree about a hit for the same float inputs. */
static inline bool FN(sphere_robust)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL t_min, REAL t_max,
                                     REAL *t) {
    REAL roots[2];
    return FN(sphere_roots)(center, radius, org, dir, roots) && FN(sphere_choose)(roots, t_min, t_max, t);
}

/* Same, for a centre and a radius in two parts. */
static inline bool FN(sphere_split)(const VEC3 center[2], const REAL radius[2], VEC3 org, VEC3 dir,
                                    REAL t_min, REAL t_max, REAL *t) {
    REAL roots[2];
    return FN(sphere_roots_split)(center, radius, org, dir, roots) &&
           FN(sphere_choose)(roots, t_min, t_max, t);
}
