/* Long triangles, grazing rays, tangent rays. */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0, 0, 0};

/* ---- slivers ---- */

#define STRIP 16u

/* A strip of slivers that share their long sides, curved, and as many scattered alone. */
void sliver_make(extremes_case *c, double aspect) {
    case_say(c, "triangles %g times as long as wide, in a strip and alone", aspect);
    vec3_f64 strip[STRIP + 2], alone[3 * STRIP];
    uint32_t indices[3 * STRIP];
    for (unsigned i = 0; i < STRIP + 2; ++i) {
        double along = i % 2 ? 1 : -1, across = ((double)i - STRIP / 2.0) / aspect;
        strip[i] = vec_f64(along, across, 0.3 * along + 0.2 * across * scattered(i, 0, -1, 1));
    }
    for (unsigned i = 0; i < STRIP; ++i) {
        vec3_f64 a = vec_f64(scattered(i, 1, -1, 1), scattered(i, 2, -1, 1), scattered(i, 3, -1, 1));
        vec3_f64 b = vec_f64(scattered(i, 4, -1, 1), scattered(i, 5, -1, 1), scattered(i, 6, -1, 1));
        vec3_f64 side = normalize_f64(cross_f64(sub_f64(b, a), vec_f64(0.3, 0.5, -0.8)));
        alone[3 * i] = a, alone[3 * i + 1] = b;
        alone[3 * i + 2] = madd_f64(b, length_f64(sub_f64(b, a)) / aspect, side);
        indices[3 * i] = i, indices[3 * i + 1] = i + 1, indices[3 * i + 2] = i + 2;
    }
    put_mesh(c, FATHOM_ROOT, middle, strip, STRIP + 2, indices, STRIP);
    put_triangles(c, FATHOM_ROOT, middle, alone, STRIP);
}

/* ---- grazing ---- */

/* At a fixed angle off the surface, towards it from either side. */
static rays_draft grazing_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    (void)index;
    rays_target target = rays_pick(c->source, r);
    double tilt = tan(c->number[0]) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = madd_f64(rays_perpendicular(r, target.normal), tilt, target.normal);
    double away = target.run->radius * rays_power(r, -2, 1);
    return (rays_draft){madd_f64(target.point, -away, dir), dir, 0, (double)INFINITY};
}

static void graze(extremes_case *c, double angle, const char *what) {
    case_say(c, "rays %g radians off %s", angle, what);
    c->number[0] = angle;
    c->maker = grazing_ray;
}

void grazing_triangles(extremes_case *c, double angle) {
    put_ball(c, FATHOM_ROOT, middle, 1);
    graze(c, angle, "the triangles of a closed mesh");
}

void grazing_quads(extremes_case *c, double angle) {
    put_quads(c, FATHOM_ROOT, middle, 1);
    graze(c, angle, "quads");
}

void grazing_spheres(extremes_case *c, double angle) {
    put_spheres(c, FATHOM_ROOT, middle, 1);
    graze(c, angle, "spheres");
}

void grazing_planes(extremes_case *c, double angle) {
    put_plane(c, vec_f64(0, -0.7, 0), vec_f64(0, 1, 0));
    put_plane(c, vec_f64(1.3, 0.2, 0.1), vec_f64(0.3, -0.2, 2));
    graze(c, angle, "planes");
}

/* ---- tangent ---- */

/* Past the rim by a fraction of the radius, or short of it. */
static rays_draft tangent_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    uint32_t sphere = (uint32_t)(rays_unit(r) * (double)c->world->spheres.count);
    vec3_f64 center = widen(c->world->spheres.items[sphere].center), n = rays_direction(r);
    double radius = (double)c->world->spheres.items[sphere].radius, off = c->number[0];
    vec3_f64 dir = rays_perpendicular(r, n);
    vec3_f64 point = madd_f64(center, radius * (1 + (index % 2 ? off : -off)), n);
    return (rays_draft){madd_f64(point, -radius * rays_power(r, 0, 2), dir), dir, 0, (double)INFINITY};
}

/* Along an axis, all numbers whole multiples of the radius, a power of two: exactly on the rim in float. */
static rays_draft touching_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    uint32_t sphere = (uint32_t)(rays_unit(r) * (double)c->world->spheres.count);
    vec3_f64 center = widen(c->world->spheres.items[sphere].center);
    double radius = (double)c->world->spheres.items[sphere].radius, org[3], dir[3] = {0, 0, 0};
    unsigned axis = (unsigned)(rays_unit(r) * 3), side = (axis + 1 + (unsigned)(index % 2)) % 3;
    store_f64(org, center);
    org[side] += rays_unit(r) < 0.5 ? radius : -radius;
    dir[axis] = rays_unit(r) < 0.5 ? 1 : -1;
    org[axis] -= dir[axis] * radius * (1 + floor(64 * rays_unit(r)));
    return (rays_draft){load_f64(org), load_f64(dir), 0, (double)INFINITY};
}

void tangent_make(extremes_case *c, double off) {
    c->number[0] = off;
    c->maker = off > 0 ? tangent_ray : touching_ray;
    if (off > 0) {
        case_say(c, "rays past the rims of spheres by %g of the radius, inside and outside", off);
        put_spheres(c, FATHOM_ROOT, middle, 1);
        return;
    }
    case_say(c, "rays that touch spheres in one point exactly");
    for (int k = 0; k < 8; ++k)
        put_sphere(c, FATHOM_ROOT, vec_f64(8 * k, 4 * (k % 3), k), ldexp(1, k % 4 - 2));
}
