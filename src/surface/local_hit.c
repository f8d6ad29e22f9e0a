/* Points are computed in double, so that what is left of their error is a matter of how they are used: see
 * gather.c. `self_hit` is what an intersector itself may be wrong about. */
#include "surface/local_hit.h"

#include "reference/reference.h"

static double largest3(double a, double b, double c) { return fmax(fabs(a), fmax(fabs(b), fabs(c))); }

static double largest(vec3_f64 v) { return largest3(v.x, v.y, v.z); }

/* v / |v|: the squares of what is computed of floats stay in the range of double. */
static vec3_f64 unit_of(vec3_f64 v) {
    double square = dot_f64(v, v);
    return square > 0 ? scale_f64(1 / sqrt(square), v) : v;
}

/* True when a ray starts inside is decided in double wherever float is in doubt, and for split spheres
 * (sphere_text.h), by c = |f|² - R²: near the surface it is off by 6 (|f|² + R²) 2^-53, which is 6 R 2^-53 of
 * distance. f and the point here are off by a few 2^-53 of |C| + R more. */
void local_sphere(const world_sphere *sphere, const local_ray *ray, local_hit *out) {
    vec3_f64 c = world_sphere_center(sphere);
    double radius = world_sphere_radius(sphere), roots[2];
    bool sure;
    vec3_f64 from = sub_f64(ray->org, c);
    /* A ray that, recomputed, just misses: the point nearest to the centre. */
    double t = -dot_f64(from, ray->dir) / dot_f64(ray->dir, ray->dir);
    if (sphere_plain_f64(c, radius, ray->org, ray->dir, roots, &sure)) {
        t = roots[0] > (double)ray->t_near ? roots[0] : roots[1];
    }
    vec3_f64 n = unit_of(madd_f64(from, t, ray->dir));
    *out = (local_hit){.p = madd_f64(c, radius, n),
                       .n = n,
                       .ns = narrow(n),
                       .self_hit = 16 * 0x1p-53 * (largest(c) + radius)};
}

/* On which side of a plane a ray starts is decided in double wherever float is in doubt (quad_text.h). */
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double along = dot_f64(n, ray->dir), t = dot_f64(n, sub_f64(point, ray->org)) / along;
    vec3_f64 p = madd_f64(ray->org, along != 0 ? t : 0, ray->dir);
    p = madd_f64(p, dot_f64(n, sub_f64(point, p)) / dot_f64(n, n), n);
    *out = (local_hit){.p = p,
                       .n = unit_of(n),
                       .ns = plane->normal,
                       .self_hit = 16 * 0x1p-53 * (largest(point) + largest(p))};
}
