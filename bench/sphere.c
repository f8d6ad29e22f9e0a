/* How often the robust sphere in float is wrong about hit or miss: sphere [RAYS] prints a table for
 * bench/README.md.
 *
 * A ray from E along d hits the sphere around C where D = R² d·d - |f×d|² >= 0, f = E - C, if it does not
 * start past it. D is first formed in double: with u = 2^-53, f and the cross product's terms are off by 4 u
 * |f||d|, which moves |f×d|² by 8 u |f||d| |f×d|, and the products and sums round by 6 u of R² d·d + |f×d|²;
 * 16 u stands for both. Cases that this cannot decide are computed in binary128, whose bound, the same with u
 * = 2^-113, has left no ray undecided.
 *
 * The band in which float inputs cannot tell: inputs off by a relative v = 2^-24 each move 1 - l²/R², l the
 * line's distance from the centre, by v (2 Σ|l_i| s_i + 2 l²) / R² with s_i = |E_i| + |t d_i| + |C_i| at the
 * closest approach t (src/verify/condition.c). */
#include "textbook.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t seed = 88172645463325252u;

static double uniform(void) {
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (double)(seed >> 11) * 0x1p-53;
}

static double between(double a, double b) { return a + (b - a) * uniform(); }

static vec3_f64 direction(void) {
    double z = between(-1, 1), phi = between(0, 6.283185307179586), s = sqrt(1 - z * z);
    return vec_f64(s * cos(phi), s * sin(phi), z);
}

static vec3_f64 perpendicular(vec3_f64 to) {
    vec3_f64 across;
    do across = cross_f64(direction(), to);
    while (!(dot_f64(across, across) > 1e-4 * dot_f64(to, to)));
    return normalize_f64(across);
}

typedef struct ray {
    vec3_f32 center, org, dir;
    float radius;
} ray;

/* `away` radii from the surface; every other ray within 1e-7 to 1e-1 radii of the rim. */
static ray make_ray(double away, bool near_rim) {
    ray r = {.radius = 1, .center = narrow(vec_f64(between(-1, 1), between(-1, 1), between(-1, 1)))};
    vec3_f64 center = widen(r.center), org = madd_f64(center, 1 + away, direction());
    double off = pow(10, between(-7, -1)), past = sqrt(uniform()) * 1.05;
    if (near_rim) past = uniform() < 0.5 ? 1 - off : 1 + off;
    vec3_f64 to = sub_f64(center, org);
    double sine = past / (1 + away), length = pow(10, between(-3, 3));
    if (sine > 1) sine = 1;
    vec3_f64 dir = add_f64(scale_f64(sqrt((1 - sine) * (1 + sine)), normalize_f64(to)),
                           scale_f64(sine, perpendicular(to)));
    r.org = narrow(org), r.dir = narrow(scale_f64(length, dir));
    return r;
}

/* The sign of D, exactly; 2: undecided. And c = |f|² - R² >= 0 with b = f·d > 0 is behind. */
static int sign_f128(const ray *r, double unit) {
    vec3_f128 f = sub_f128(quadruple_f32(r->org), quadruple_f32(r->center)), d = quadruple_f32(r->dir);
    vec3_f128 g = cross_f128(f, d);
    real_f128 left = (real_f128)r->radius * r->radius * dot_f128(d, d), right = dot_f128(g, g),
              D = left - right;
    real_f128 size = (real_f128)sqrt((double)(dot_f128(f, f) * dot_f128(d, d)) * (double)right);
    real_f128 error = 16 * (real_f128)unit * (size + left + right);
    if (D > error) return 1;
    if (D < -error) return -1;
    return D == 0 ? 0 : 2;
}

static int sign_f64(const ray *r) {
    vec3_f64 f = sub_f64(widen(r->org), widen(r->center)), d = widen(r->dir), g = cross_f64(f, d);
    double radius = (double)r->radius, left = radius * radius * dot_f64(d, d), right = dot_f64(g, g);
    double error = 16 * 0x1p-53 * (sqrt(dot_f64(f, f) * dot_f64(d, d) * right) + left + right),
           D = left - right;
    return D > error ? 1 : D < -error ? -1 : 2;
}

static bool in_band(const ray *r) {
    vec3_f64 e = widen(r->org), c = widen(r->center), d = widen(r->dir), f = sub_f64(e, c);
    double t = -dot_f64(f, d) / dot_f64(d, d), radius2 = (double)r->radius * (double)r->radius;
    vec3_f64 l = madd_f64(f, t, d);
    double l2 = dot_f64(l, l);
    double sum = fabs(l.x) * (fabs(e.x) + fabs(t * d.x) + fabs(c.x)) +
                 fabs(l.y) * (fabs(e.y) + fabs(t * d.y) + fabs(c.y)) +
                 fabs(l.z) * (fabs(e.z) + fabs(t * d.z) + fabs(c.z));
    return fabs(1 - l2 / radius2) <= 0x1p-24 * 2 * (sum + l2) / radius2;
}

/* The origin is outside and the sphere is not behind it, for rays made as above and rounded. */
static bool is_ahead(const ray *r) {
    vec3_f64 f = sub_f64(widen(r->org), widen(r->center));
    return dot_f64(f, widen(r->dir)) < 0 && dot_f64(f, f) > (double)r->radius * (double)r->radius;
}

int main(int argc, char **argv) {
    double rays = argc > 1 ? atof(argv[1]) : 1e7;
    printf(
        "| radius over distance | rays | in the band | robust: wrong | outside the band | textbook: wrong | "
        "undecided |\n|---|---|---|---|---|---|---|\n");
    for (int decade = -5; decade <= 5; ++decade) {
        double away = pow(10, -decade), count = 0, band = 0, wrong = 0, outside = 0, lecture = 0, open = 0;
        while (count < rays) {
            ray r = make_ray(away, (uint64_t)count % 2);
            if (!is_ahead(&r)) continue;
            ++count;
            int sign = sign_f64(&r);
            if (sign == 2) sign = sign_f128(&r, 0x1p-113);
            open += sign == 2;
            float t;
            bool met = sphere_robust_f32(r.center, r.radius, r.org, r.dir, 0, INFINITY, &t);
            bool lectured = sphere_textbook_f32(r.center, r.radius, r.org, r.dir, 0, INFINITY, &t);
            bool blurred = in_band(&r);
            band += blurred, wrong += met != (sign >= 0), lecture += lectured != (sign >= 0);
            outside += !blurred && met != (sign >= 0);
        }
        printf("| 1e%d | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f |\n", decade, count, band, wrong, outside,
               lecture, open);
        fflush(stdout);
    }
    return 0;
}
