/* One hit in object space, for shapes without a 16-lane kernel: see surface/local.h. Inline, because passing
 * the ray through memory (stored as single numbers, loaded as pairs) stalls on store forwarding.
 *
 * Points are computed in double, so their remaining error depends on how they are used: see gather.c.
 * `self_hit` is the error of the intersector itself. */
#pragma once

#include "reference/reference.h"
#include "scene/world/world.h"

/* One lane of local_block. */
typedef struct local_hit {
    vec3_f64 p, n;
    vec3_f32 ns;
    double self_hit;
} local_hit;

typedef struct local_ray {
    vec3_f64 org, dir;
    float t_near;
} local_ray;

static inline double local_extent(vec3_f64 v) { return fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z))); }

/* v / |v|. The squares of numbers computed from floats stay in the range of double. */
static inline vec3_f64 local_unit(vec3_f64 v) {
    double square = dot_f64(v, v);
    return square > 0 ? scale_f64(1 / sqrt(square), v) : v;
}

/* Intersectors decide in double whether a ray starts inside if float is in doubt, and always for split
 * spheres (sphere_text.h). They use c = |f|² - R²: near the surface its error is 6 (|f|² + R²) 2^-53, which
 * is 6 R 2^-53 of distance. f and the point here add an error of a few 2^-53 of |C| + R. */
static inline local_hit local_sphere(const world_sphere *sphere, const local_ray *ray) {
    vec3_f64 c = world_sphere_center(sphere);
    double radius = world_sphere_radius(sphere), roots[2];
    bool sure;
    vec3_f64 from = sub_f64(ray->org, c);
    /* For a ray that just misses when recomputed: the point nearest to the centre. */
    double t = -dot_f64(from, ray->dir) / dot_f64(ray->dir, ray->dir);
    if (sphere_plain_f64(c, radius, ray->org, ray->dir, roots, &sure)) {
        t = roots[0] > (double)ray->t_near ? roots[0] : roots[1];
    }
    vec3_f64 n = local_unit(madd_f64(from, t, ray->dir));
    return (local_hit){.p = madd_f64(c, radius, n),
                       .n = n,
                       .ns = narrow(n),
                       .self_hit = 16 * 0x1p-53 * (local_extent(c) + radius)};
}

/* Intersectors decide in double on which side of a plane a ray starts if float is in doubt (quad_text.h). */
static inline local_hit local_plane(const world_plane *plane, const local_ray *ray) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double along = dot_f64(n, ray->dir), t = dot_f64(n, sub_f64(point, ray->org)) / along;
    vec3_f64 p = madd_f64(ray->org, along != 0 ? t : 0, ray->dir);
    p = madd_f64(p, dot_f64(n, sub_f64(point, p)) / plane->square, n);
    return (local_hit){.p = p,
                       .n = plane->unit,
                       .ns = plane->normal,
                       .self_hit = 16 * 0x1p-53 * (local_extent(point) + local_extent(p))};
}
