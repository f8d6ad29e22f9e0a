/* One sphere seen from near and far: the radius over the distance. */
#include "verify/extremes/case.h"

static const vec3_f64 middle = {0.37, -0.21, 0.13};

/* A line past the sphere's centre at distance `by` from it, from `org`. */
static vec3_f64 aimed_past(rays_random *r, vec3_f64 org, vec3_f64 center, double by) {
    vec3_f64 to = sub_f64(center, org);
    double far = length_f64(to), sine = by < far ? by / far : 1, cosine = sqrt((1 - sine) * (1 + sine));
    return add_f64(scale_f64(cosine, normalize_f64(to)), scale_f64(sine, rays_perpendicular(r, to)));
}

/* Every other ray near the rim, by 1e-7 to 1e-1 of the radius; the others anywhere up to it and a little
 * beyond. */
static double distance_past(rays_random *r, uint64_t index, double radius) {
    if (index % 2) return radius * sqrt(rays_unit(r)) * 1.05;
    double off = rays_power(r, -7, -1);
    return radius * (rays_unit(r) < 0.5 ? 1 - off : 1 + off);
}

static rays_draft outer_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    vec3_f64 org = madd_f64(middle, 1 + c->number[0], rays_direction(r));
    return (rays_draft){org, aimed_past(r, org, middle, distance_past(r, index, 1)), 0, (double)INFINITY};
}

/* A unit sphere; number[0]: the distance to its surface. */
static void near_unit(extremes_case *c, const char *side, double ratio, rays_maker maker) {
    case_say(c, "a sphere from %s, its radius %g times the distance to its surface", side, ratio);
    put_sphere(c, FATHOM_ROOT, middle, 1);
    c->number[0] = 1 / ratio;
    c->maker = maker;
}

void ratio_outside(extremes_case *c, double ratio) { near_unit(c, "outside", ratio, outer_ray); }

static rays_draft inner_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    vec3_f64 n = rays_direction(r), org = madd_f64(middle, 1 - c->number[0], n);
    vec3_f64 dir =
        index % 2 ? rays_direction(r) : madd_f64(rays_perpendicular(r, n), rays_power(r, -7, 0), n);
    return (rays_draft){org, dir, 0, (double)INFINITY};
}

void ratio_inside(extremes_case *c, double ratio) { near_unit(c, "inside", ratio, inner_ray); }

/* From the surface, as float rounds it, every other ray nearly along it. */
static rays_draft surface_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    const world_sphere *sphere = &c->world->spheres.items[0];
    vec3_f64 n = rays_direction(r), org = madd_f64(widen(sphere->center), (double)sphere->radius, n);
    double tilt = rays_power(r, -7, 0) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = index % 2 ? rays_direction(r) : madd_f64(rays_perpendicular(r, n), tilt, n);
    return (rays_draft){org, dir, 0, (double)INFINITY};
}

/* The world is not moved to the sphere unless it is small beside its distance: then this one is. */
static void push_away(extremes_case *c) { c->world->spheres.items[0].center = narrow(normalize_f64(middle)); }

void ratio_surface(extremes_case *c, double ratio) {
    case_say(c, "rays from the surface of a sphere, its radius %g times its distance from the origin", ratio);
    put_sphere(c, FATHOM_ROOT, vec_f64(0, 0, 0), ratio);
    c->patch = push_away;
    c->maker = surface_ray;
}
