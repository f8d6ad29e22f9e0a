/* Points are computed in double, so that what is left of their error is a matter of how they are used: see
 * surface_point.c. `beside` is what an intersector itself may be wrong about. */
#include "render/local_hit.h"

#include "reference/reference.h"
#include "shade/local.h"

static double largest3(double a, double b, double c) { return fmax(fabs(a), fmax(fabs(b), fabs(c))); }

static double largest(vec3_f64 v) { return largest3(v.x, v.y, v.z); }

/* v / |v|: the squares of what is computed of floats stay in the range of double. */
static vec3_f64 unit_of(vec3_f64 v) {
    double square = dot_f64(v, v);
    return square > 0 ? scale_f64(1 / sqrt(square), v) : v;
}

/* Whether a ray starts inside is decided in double wherever float is in doubt, and for split spheres
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
    *out = (local_hit){
        .p = madd_f64(c, radius, n), .n = n, .ns = narrow(n), .beside = 16 * 0x1p-53 * (largest(c) + radius)};
}

static double clamp_unit(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* The corner-weighted point of a face, and how far from its plane a ray that starts there may seem to start.
 */
static void set_face(vec3_f64 a, vec3_f64 ab, vec3_f64 ac, double u, double v, local_hit *out) {
    vec3_f64 n = unit_of(cross_f64(ab, ac));
    double extent = fmax(largest(sub_f64(ac, ab)), fmax(largest(ab), largest(ac)));
    *out = (local_hit){.p = madd_f64(madd_f64(a, u, ab), v, ac),
                       .n = n,
                       .ns = narrow(n),
                       .beside = LOCAL_FACE_BESIDE * extent};
}

/* A half of the quad is a triangle of its own, with a plane of its own where rounding has bent the quad. */
void local_quad(const world_quad *quad, const local_ray *ray, local_hit *out) {
    vec3_f32 org = narrow(ray->org), dir = narrow(ray->dir);
    const vec3_f32 *c = quad->corner;
    reference_hit_f32 hit = {0};
    if (!quad_robust_f32(c[0], c[1], c[2], c[3], org, dir, ray->t_near, INFINITY, &hit) &&
        !quad_textbook_f32(c[0], c[1], c[2], c[3], org, dir, ray->t_near, INFINITY, &hit)) {
        hit.u = (float)clamp_unit((double)hit.u), hit.v = (float)clamp_unit((double)hit.v);
    }
    double u = (double)hit.u, v = (double)hit.v;
    bool second = hit.u + hit.v > 1;
    if (second) u = 1 - u, v = 1 - v;
    vec3_f64 a = widen(c[second ? 2 : 0]), b = widen(c[second ? 3 : 1]), d = widen(c[second ? 1 : 3]);
    set_face(a, sub_f64(b, a), sub_f64(d, a), u, v, out);
}

/* On which side of a plane a ray starts is decided in double wherever float is in doubt (quad_text.h). */
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double along = dot_f64(n, ray->dir), t = dot_f64(n, sub_f64(point, ray->org)) / along;
    vec3_f64 p = madd_f64(ray->org, along != 0 ? t : 0, ray->dir);
    p = madd_f64(p, dot_f64(n, sub_f64(point, p)) / dot_f64(n, n), n);
    *out = (local_hit){
        .p = p, .n = unit_of(n), .ns = plane->normal, .beside = 16 * 0x1p-53 * (largest(point) + largest(p))};
}
