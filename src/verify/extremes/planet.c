/* A small part beside a planet. */
#include "verify/extremes/case.h"

static const double earth = 6.371e6;

/* From around the part, at it, or past it at the ground. */
static rays_draft part_ray(const void *user, rays_random *r, uint64_t index) {
    const extremes_case *c = user;
    vec3_f64 at =
        sub_f64(load_f64((const double[3]){c->number[1], c->number[2], c->number[3]}), c->world->origin);
    vec3_f64 org = rays_in_ball(r, at, 10 * c->number[0]);
    vec3_f64 target = rays_in_ball(r, at, (index % 2 ? 1.05 : 3) * c->number[0]);
    return (rays_draft){org, sub_f64(target, org), 0, (double)INFINITY};
}

/* The part floats over the planet at twice its radius. */
static void put_part(extremes_case *c, double size) {
    vec3_f64 up = vec_f64(0.48, 0.6, 0.64), at = scale_f64(earth + 2 * size, up);
    put_sphere(c, FATHOM_ROOT, vec_f64(0, 0, 0), earth);
    put_ball(c, FATHOM_ROOT, at, size);
    put_sphere(c, FATHOM_ROOT, madd_f64(at, 2.5 * size, vec_f64(0.8, 0, -0.6)), size);
    put_camera(c, madd_f64(at, 8 * size, vec_f64(0.64, 0.48, 0.6)), at);
    c->number[0] = size, c->number[1] = at.x, c->number[2] = at.y, c->number[3] = at.z;
}

void planet_make(extremes_case *c, double size) {
    case_say(c, "a part of radius %g m over a planet of 6371 km, seen from beside it", size);
    put_part(c, size);
    c->maker = part_ray;
}

/* All that families of rays do where one thing is ten orders larger than the other. */
void planet_outer(extremes_case *c, double size) {
    case_say(c, "the same part of %g m and planet by rays from anywhere", size);
    put_part(c, size);
    c->families |= 1u << RAYS_CAMERA;
}
