#include "verify/exact/filter.h"

#define UNIT 0x1p-53

static double row_times(const float row[4], vec3_f64 p, double w, double *size) {
    double x = (double)row[0] * p.x, y = (double)row[1] * p.y, z = (double)row[2] * p.z,
           t = (double)row[3] * w;
    *size += fabs(x) + fabs(y) + fabs(z) + fabs(t);
    return x + y + z + t;
}

/* Products of floats are exact in double. The three sums have an error of at most 3 u of the sum of their
 * terms' sizes. The sum over all rows bounds the Euclidean length; 8 u leaves room for the rounding of the
 * bound itself. */
static vec3_f64 carried(const float m[3][4], vec3_f64 p, double w, double *error) {
    double size = 0;
    vec3_f64 r = {row_times(m[0], p, w, &size), 0, 0};
    r.y = row_times(m[1], p, w, &size);
    r.z = row_times(m[2], p, w, &size);
    *error = 8 * UNIT * size;
    return r;
}

/* The error of dir·dir is 2 |dir| dir_error plus rounding. With dir_error <= |dir|/64, quotients by it have a
 * relative error of at most 8 dir_error/|dir| + 2^-48. */
filter_ray filter_ray_of(const oracle_ray *ray, const world_instance *instance) {
    filter_ray r = {.org = widen(ray->org), .dir = widen(ray->dir)};
    if (instance) {
        r.org = carried(instance->to_object, r.org, 1, &r.org_error);
        r.dir = carried(instance->to_object, r.dir, 0, &r.dir_error);
    }
    r.length = sqrt(dot_f64(r.dir, r.dir));
    r.largest = fmax(fabs(r.dir.x), fmax(fabs(r.dir.y), fabs(r.dir.z)));
    r.inverse = 1 / dot_f64(r.dir, r.dir);
    r.vague = !(r.length > FILTER_LEAST) || !(r.dir_error <= r.length / 64) || !isfinite(r.length);
    r.widen = r.vague ? 0 : 8 * r.dir_error / r.length + 0x1p-48;
    r.t_near = (double)ray->t_near, r.t_far = (double)ray->t_far;
    return r;
}

/* With f from the origin to a sphere's centre, F = |f|, B = |dir|: the line misses the sphere if |f×dir| > R
 * B. The difference, the products and the sums have an error of at most 16 u F B in |f×dir| and in f·dir. The
 * ray's own errors add org_error B + F dir_error, and R B has an error of R dir_error. `reach` is R B plus
 * more than twice all of this. t of a point in the sphere is within (f·dir ± reach) / dir·dir. */
static bool may_meet(const filter_ray *ray, double x, double y, double z, double radius, double *low) {
    double fx = x - ray->org.x, fy = y - ray->org.y, fz = z - ray->org.z;
    double dx = ray->dir.x, dy = ray->dir.y, dz = ray->dir.z;
    double gx = fy * dz - fz * dy, gy = fz * dx - fx * dz, gz = fx * dy - fy * dx;
    double far = sqrt(fx * fx + fy * fy + fz * fz), apart = sqrt(gx * gx + gy * gy + gz * gz);
    double reach = (radius * (1 + 0x1p-47) + far * 0x1p-46 + 2 * ray->org_error) * ray->length +
                   2 * (far + radius) * ray->dir_error + FILTER_LEAST;
    double along = fx * dx + fy * dy + fz * dz;
    double first = (along - reach) * ray->inverse, last = (along + reach) * ray->inverse;
    first -= fabs(first) * ray->widen, last += fabs(last) * ray->widen;
    *low = first;
    return !((apart > reach) | (first >= ray->t_far) | (last <= ray->t_near));
}

bool filter_sphere(const filter_ray *ray, vec3_f64 center, double radius, double *low) {
    bool meets = may_meet(ray, center.x, center.y, center.z, radius, low);
    if (!ray->vague) return meets;
    *low = -(double)INFINITY;
    return true;
}

void filter_run(const filter_ray *ray, const filter_spheres *spheres, size_t first, size_t count,
                uint8_t *out, double *low) {
    const double *x = spheres->x + first, *y = spheres->y + first, *z = spheres->z + first;
    const double *radius = spheres->radius + first;
    for (size_t i = 0; i < count; ++i) out[i] = may_meet(ray, x[i], y[i], z[i], radius[i], &low[i]);
    if (!ray->vague) return;
    for (size_t i = 0; i < count; ++i) out[i] = 1, low[i] = -(double)INFINITY;
}

static double larger(double a, double b) { return a > b ? a : b; }

static double largest(vec3_f64 a) { return larger(fabs(a.x), larger(fabs(a.y), fabs(a.z))); }

/* Corners p, q, r are relative to the origin; A is their largest component and ε = u A + org_error the error
 * of each. Sides are differences of floats; L is their largest component and u L the error of each. B is the
 * largest component of dir. From far away L is much less than A, so edge functions are computed as d·(q×r) =
 * d·(q×(r-q)), with six terms d q s. The error of each term is 1.1 B L ε from the corner, 1.1 u A B L from
 * the side, 1.2 A L dir_error from the direction (for ε <= A/16), and 5.1 u A B L from rounding: in all less
 * than 16 B L ε + 64 u A B L + 8 A L dir_error. Their sum is d·n with n = s×s' of two sides: six terms d s
 * s', each with errors of 2.2 u B L², 1.1 L² dir_error and 5.1 u B L². Likewise for p·n: 1.1 L² ε, 2.2 u A L²
 * and 5.1 u A L². */
filter_verdict filter_triangle(const filter_ray *ray, vec3_f64 a, vec3_f64 b, vec3_f64 c, double *low,
                               double *high) {
    *low = -(double)INFINITY, *high = (double)INFINITY;
    vec3_f64 p = sub_f64(a, ray->org), q = sub_f64(b, ray->org), r = sub_f64(c, ray->org);
    vec3_f64 ab = sub_f64(b, a), bc = sub_f64(c, b), ca = sub_f64(a, c);
    double A = larger(largest(p), larger(largest(q), largest(r))), B = ray->largest;
    double L = larger(largest(ab), larger(largest(bc), largest(ca)));
    const double tiny = FILTER_LEAST * FILTER_LEAST;
    double off = UNIT * A + ray->org_error;
    if (ray->vague || !(off <= A / 16)) return FILTER_DOUBT;
    double edge_error = L * (16 * B * off + 64 * UNIT * A * B + 8 * A * ray->dir_error) + tiny;
    double u = dot_f64(ray->dir, cross_f64(q, bc)), v = dot_f64(ray->dir, cross_f64(r, ca)),
           w = dot_f64(ray->dir, cross_f64(p, ab));
    double least = u < v ? u : v, most = u < v ? v : u;
    least = least < w ? least : w, most = most > w ? most : w;
    if (least < -edge_error && most > edge_error) return FILTER_MISS;
    vec3_f64 n = cross_f64(ab, bc);
    double sum = dot_f64(ray->dir, n), sum_error = L * L * (64 * UNIT * B + 8 * ray->dir_error) + tiny;
    double left = fabs(sum) - sum_error;
    if (!(left > 0)) return FILTER_DOUBT;
    double above_error = L * L * (8 * off + 64 * UNIT * A) + tiny;
    double t = dot_f64(p, n) / sum;
    double t_error = (above_error + fabs(t) * sum_error) / left * (1 + 0x1p-40) + fabs(t) * 0x1p-50;
    *low = t - t_error, *high = t + t_error;
    if (*low >= ray->t_far || *high <= ray->t_near) return FILTER_MISS;
    bool within = least > edge_error || most < -edge_error;
    return within && *low > ray->t_near && *high < ray->t_far ? FILTER_HIT : FILTER_DOUBT;
}
