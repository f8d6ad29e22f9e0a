/* Groups of rays: slivers, grazing and tangent rays, one sphere from near and far, a small part of a planet.
 */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0, 0, 0};

/* ---- slivers ---- */

#define STRIP 16u

/* A curved strip of slivers that share their long sides, and the same number of separate ones. */
void sliver_make(judged_scene *c, double aspect) {
    case_say(c, "triangles %g times as long as wide, in a strip and alone", aspect);
    vec3_f64 strip[STRIP + 2], alone[3 * STRIP];
    uint32_t indices[3 * STRIP];
    for (unsigned i = 0; i < STRIP + 2; ++i) {
        double along = i % 2 ? 1 : -1, across = ((double)i - STRIP / 2.0) / aspect;
        strip[i] = vec_f64(along, across, 0.3 * along + 0.2 * across * case_scattered(i, 0, -1, 1));
    }
    for (unsigned i = 0; i < STRIP; ++i) {
        vec3_f64 a = case_scattered_point(i, 1, 1), b = case_scattered_point(i, 4, 1);
        vec3_f64 side = normalize_f64(cross_f64(sub_f64(b, a), vec_f64(0.3, 0.5, -0.8)));
        alone[3 * i] = a, alone[3 * i + 1] = b;
        alone[3 * i + 2] = madd_f64(b, length_f64(sub_f64(b, a)) / aspect, side);
        indices[3 * i] = i, indices[3 * i + 1] = i + 1, indices[3 * i + 2] = i + 2;
    }
    build_triangles(&c->b, middle, strip, STRIP + 2, indices, STRIP, 0);
    case_triangles(c, middle, alone, STRIP);
}

/* ---- grazing ---- */

/* A ray at a fixed angle to the surface, from either side. */
static rays_draft grazing_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    rays_target target = rays_pick(c->source, r);
    double tilt = tan(c->number[0]) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = madd_f64(rays_perpendicular(r, target.normal), tilt, target.normal);
    double away = target.run->radius * rays_power(r, -2, 1);
    return (rays_draft){madd_f64(target.point, -away, dir), dir, 0, (double)INFINITY};
}

void grazing_make(judged_scene *c, double angle) {
    static const char *const words[] = {"spheres", "quads", "the triangles of a closed mesh", "planes"};
    case_say(c, "rays %g radians off %s", angle, words[c->shape]);
    c->number[0] = angle;
    c->maker = grazing_ray;
    if (c->shape != CASE_PLANES) {
        case_shapes(c, 1);
        return;
    }
    build_plane(&c->b, vec_f64(0, -0.7, 0), vec_f64(0, 1, 0), 0);
    build_plane(&c->b, vec_f64(1.3, 0.2, 0.1), vec_f64(0.3, -0.2, 2), 0);
}

/* ---- tangent ---- */

/* A ray that passes the silhouette outside or inside, by a fraction of the radius. */
static rays_draft tangent_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    uint32_t sphere = (uint32_t)(rays_unit(r) * (double)c->world->spheres.count);
    vec3_f64 center = widen(c->world->spheres.items[sphere].center), n = rays_direction(r);
    double radius = (double)c->world->spheres.items[sphere].radius, off = c->number[0];
    vec3_f64 dir = rays_perpendicular(r, n);
    vec3_f64 point = madd_f64(center, radius * (1 + (r->index % 2 ? off : -off)), n);
    return (rays_draft){madd_f64(point, -radius * rays_power(r, 0, 2), dir), dir, 0, (double)INFINITY};
}

/* A ray along an axis that touches the sphere exactly, also in float: all numbers are multiples of the
 * radius, which is a power of two. */
static rays_draft touching_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    uint32_t sphere = (uint32_t)(rays_unit(r) * (double)c->world->spheres.count);
    vec3_f64 center = widen(c->world->spheres.items[sphere].center);
    double radius = (double)c->world->spheres.items[sphere].radius, org[3], dir[3] = {0, 0, 0};
    unsigned axis = (unsigned)(rays_unit(r) * 3), side = (axis + 1 + (unsigned)(r->index % 2)) % 3;
    store_f64(org, center);
    org[side] += rays_unit(r) < 0.5 ? radius : -radius;
    dir[axis] = rays_unit(r) < 0.5 ? 1 : -1;
    org[axis] -= dir[axis] * radius * (1 + floor(64 * rays_unit(r)));
    return (rays_draft){load_f64(org), load_f64(dir), 0, (double)INFINITY};
}

void tangent_make(judged_scene *c, double off) {
    c->number[0] = off;
    c->maker = off > 0 ? tangent_ray : touching_ray;
    if (off > 0) {
        case_say(c, "rays past the rims of spheres by %g of the radius, inside and outside", off);
        case_spheres(c, middle, 1);
        return;
    }
    case_say(c, "rays that touch spheres in one point exactly");
    for (int k = 0; k < 8; ++k) build_sphere(&c->b, vec_f64(8 * k, 4 * (k % 3), k), ldexp(1, k % 4 - 2), 0);
}

/* ---- one sphere seen from near and far: radius divided by distance ---- */

static const vec3_f64 unit_center = {0.37, -0.21, 0.13};

/* Direction from `org` that passes the sphere's centre at distance `by`. */
static vec3_f64 aimed_past(rays_random *r, vec3_f64 org, vec3_f64 center, double by) {
    vec3_f64 to = sub_f64(center, org);
    double far = length_f64(to), sine = by < far ? by / far : 1, cosine = sqrt((1 - sine) * (1 + sine));
    return add_f64(scale_f64(cosine, normalize_f64(to)), scale_f64(sine, rays_perpendicular(r, to)));
}

/* Every second ray passes near the silhouette, by 1e-7 to 1e-1 of the radius; the others anywhere up to it
 * and a little beyond. */
static double distance_past(rays_random *r) {
    if (r->index % 2) return sqrt(rays_unit(r)) * 1.05;
    double off = rays_power(r, -7, -1);
    return rays_unit(r) < 0.5 ? 1 - off : 1 + off;
}

static rays_draft outer_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    vec3_f64 org = madd_f64(unit_center, 1 + c->number[0], rays_direction(r));
    return (rays_draft){org, aimed_past(r, org, unit_center, distance_past(r)), 0, (double)INFINITY};
}

/* Adds a unit sphere; number[0]: distance to its surface. */
static void near_unit(judged_scene *c, const char *side, double ratio, rays_maker maker) {
    case_say(c, "a sphere from %s, its radius %g times the distance to its surface", side, ratio);
    build_sphere(&c->b, unit_center, 1, 0);
    c->number[0] = 1 / ratio;
    c->maker = maker;
}

void ratio_outside(judged_scene *c, double ratio) { near_unit(c, "outside", ratio, outer_ray); }

static rays_draft inner_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    vec3_f64 n = rays_direction(r), org = madd_f64(unit_center, 1 - c->number[0], n);
    vec3_f64 dir =
        r->index % 2 ? rays_direction(r) : madd_f64(rays_perpendicular(r, n), rays_power(r, -7, 0), n);
    return (rays_draft){org, dir, 0, (double)INFINITY};
}

void ratio_inside(judged_scene *c, double ratio) { near_unit(c, "inside", ratio, inner_ray); }

/* A ray from the surface, rounded to float; every second ray is nearly tangent. */
static rays_draft surface_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    const world_sphere *sphere = &c->world->spheres.items[0];
    vec3_f64 n = rays_direction(r), org = madd_f64(widen(sphere->center), (double)sphere->radius, n);
    double tilt = rays_power(r, -7, 0) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = r->index % 2 ? rays_direction(r) : madd_f64(rays_perpendicular(r, n), tilt, n);
    return (rays_draft){org, dir, 0, (double)INFINITY};
}

/* The world's origin moves to a sphere only if the sphere is small compared to its distance. Here it must not
 * move, so the patch sets the centre directly. */
static void push_away(judged_scene *c) {
    c->world->spheres.items[0].center = narrow(normalize_f64(unit_center));
}

void ratio_surface(judged_scene *c, double ratio) {
    case_say(c, "rays from the surface of a sphere, its radius %g times its distance from the origin", ratio);
    build_sphere(&c->b, vec_f64(0, 0, 0), ratio, 0);
    c->patch = push_away;
    c->maker = surface_ray;
}

/* ---- a small part next to a planet ---- */

static const double earth = 6.371e6;

/* A ray from around the part, aimed at the part or past it at the ground. */
static rays_draft part_ray(const void *user, rays_random *r) {
    const judged_scene *c = user;
    vec3_f64 at =
        sub_f64(load_f64((const double[3]){c->number[1], c->number[2], c->number[3]}), c->world->origin);
    vec3_f64 org = rays_in_ball(r, at, 10 * c->number[0]);
    vec3_f64 target = rays_in_ball(r, at, (r->index % 2 ? 1.05 : 3) * c->number[0]);
    return (rays_draft){org, sub_f64(target, org), 0, (double)INFINITY};
}

/* The part floats above the planet; its centre is two of its own radii above the ground. */
static void put_part(judged_scene *c, double size) {
    vec3_f64 up = vec_f64(0.48, 0.6, 0.64), at = scale_f64(earth + 2 * size, up);
    build_sphere(&c->b, vec_f64(0, 0, 0), earth, 0);
    case_ball(c, at, size);
    build_sphere(&c->b, madd_f64(at, 2.5 * size, vec_f64(0.8, 0, -0.6)), size, 0);
    build_camera(&c->b, build_view(madd_f64(at, 8 * size, vec_f64(0.64, 0.48, 0.6)), at, 0.7));
    c->number[0] = size, c->number[1] = at.x, c->number[2] = at.y, c->number[3] = at.z;
}

void planet_make(judged_scene *c, double size) {
    case_say(c, "a part of radius %g m over a planet of 6371 km, seen from close by", size);
    put_part(c, size);
    c->maker = part_ray;
}

/* All families of rays in a scene in which one object is many orders of magnitude larger than the other. */
void planet_outer(judged_scene *c, double size) {
    case_say(c, "the same part of %g m and planet by rays from anywhere", size);
    put_part(c, size);
    c->families |= 1u << RAYS_CAMERA;
}
