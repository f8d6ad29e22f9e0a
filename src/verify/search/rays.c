#include "verify/search/rays.h"

#include <float.h>

typedef rays_draft draft;
typedef draft (*maker)(const rays_source *s, rays_random *r);

static draft towards(vec3_f64 org, vec3_f64 target) {
    return (draft){org, sub_f64(target, org), 0, (double)INFINITY};
}

static vec3_f64 around(const rays_source *s, rays_random *r) {
    return rays_in_ball(r, s->center, 2 * s->radius);
}

static draft make_camera(const rays_source *s, rays_random *r) {
    const fathom_camera *c = &s->world->scene->camera;
    double u = rays_unit(r) - 0.5, v = rays_unit(r) - 0.5, w = c->w > 0 ? c->w : c->h * 16 / 9;
    vec3_f64 dir = scale_f64(u * w, load_f64(c->x));
    dir = madd_f64(dir, v * c->h, load_f64(c->y));
    dir = madd_f64(dir, -c->d, load_f64(c->z));
    vec3_f64 org = sub_f64(load_f64(c->origin), s->world->origin);
    return (draft){org, normalize_f64(dir), 0, (double)INFINITY};
}

static draft make_uniform(const rays_source *s, rays_random *r) {
    vec3_f64 org = around(s, r);
    return towards(org, rays_pick(s, r).point);
}

/* Every second ray starts near the centre of its target run: inside, if that is closed. */
static vec3_f64 viewpoint(const rays_source *s, rays_random *r, const rays_target *target) {
    return r->index % 2 ? around(s, r) : rays_in_ball(r, target->run->center, 0.2 * target->run->radius);
}

static vec3_f64 some_corner(const rays_target *target, rays_random *r) {
    return target->corners ? target->corner[(unsigned)(rays_unit(r) * target->corners)] : target->point;
}

static draft make_edge(const rays_source *s, rays_random *r) {
    rays_target target = rays_pick(s, r);
    vec3_f64 point = target.point;
    if (target.corners) {
        unsigned k = (unsigned)(rays_unit(r) * target.corners);
        vec3_f64 a = target.corner[k], b = target.corner[(k + 1) % target.corners];
        point = madd_f64(a, rays_unit(r), sub_f64(b, a));
    }
    return towards(viewpoint(s, r, &target), point);
}

static draft make_vertex(const rays_source *s, rays_random *r) {
    rays_target target = rays_pick(s, r);
    const vec3_f64 point = some_corner(&target, r);
    return towards(viewpoint(s, r, &target), point);
}

static draft make_grazing(const rays_source *s, rays_random *r) {
    rays_target target = rays_pick(s, r);
    double tilt = rays_power(r, -6, 0) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = madd_f64(rays_perpendicular(r, target.normal), tilt, target.normal);
    double away = target.run->radius * rays_power(r, -2, 1);
    return (draft){madd_f64(target.point, -away, dir), dir, 0, (double)INFINITY};
}

/* For a sphere: perpendicular to the normal, offset from the surface by a fraction of the radius, down to
 * 1e-8. */
static draft make_tangent(const rays_source *s, rays_random *r) {
    rays_target target = rays_pick(s, r);
    double away = target.run->radius * rays_power(r, -1, 1);
    double off = rays_power(r, -8, -1) * (rays_unit(r) < 0.5 ? -1 : 1);
    vec3_f64 dir = rays_perpendicular(r, target.normal), point = target.point;
    if (target.corners) {
        unsigned k = (unsigned)(rays_unit(r) * target.corners);
        vec3_f64 a = target.corner[k], edge = sub_f64(target.corner[(k + 1) % target.corners], a);
        point = madd_f64(a, rays_unit(r), edge);
        dir = normalize_f64(madd_f64(normalize_f64(edge), off, target.normal));
    } else {
        point = madd_f64(point, off * target.run->radius, target.normal);
    }
    return (draft){madd_f64(point, -away, dir), dir, 0, (double)INFINITY};
}

static draft make_surface(const rays_source *s, rays_random *r) {
    vec3_f64 org = rays_pick(s, r).point;
    return (draft){org, rays_direction(r), 0, (double)INFINITY};
}

static draft make_far(const rays_source *s, rays_random *r) {
    vec3_f64 target = rays_pick(s, r).point;
    return towards(madd_f64(target, s->radius * rays_power(r, 1, 6), rays_direction(r)), target);
}

static draft make_axis(const rays_source *s, rays_random *r) {
    vec3_f64 target = rays_pick(s, r).point;
    vec3_f64 dir = rays_direction(r);
    double zero = r->index % 2 ? -0.0 : 0.0, *parts[3] = {&dir.x, &dir.y, &dir.z};
    unsigned axis = (unsigned)(rays_unit(r) * 3);
    *parts[axis] = zero;
    if (rays_unit(r) < 0.5) *parts[(axis + 1) % 3] = zero;
    return (draft){madd_f64(target, -2 * s->radius, dir), dir, 0, (double)INFINITY};
}

/* Intervals that end far behind the target, at half its t and at twice its t. */
static draft make_scaled(const rays_source *s, rays_random *r) {
    draft ray = make_uniform(s, r);
    double size = r->index % 8 ? rays_power(r, -20, 36) : rays_power(r, -31, -30),
           t = length_f64(ray.dir) / size;
    ray.dir = scale_f64(size, normalize_f64(ray.dir));
    if (r->index % 2) ray.t_far = rays_power(r, 30, 38.5);
    if (r->index % 8 == 3) ray.t_far = t / 2;
    if (r->index % 8 == 7) ray.t_far = 2 * t;
    return ray;
}

/* The target has t = 1, up to rounding. */
static draft make_interval(const rays_source *s, rays_random *r) {
    draft ray = make_uniform(s, r);
    double width = rays_power(r, -8, 0);
    switch (r->index % 5) {
    case 0: ray.t_near = 1 - width, ray.t_far = 1 + width; break;
    case 1: ray.t_near = 1; break;
    case 2: ray.t_far = 1; break;
    case 3: ray.t_far = rays_power(r, -37, 0); break;
    default: ray.t_near = rays_power(r, 0, 37), ray.t_far = FLT_MAX; break;
    }
    return ray;
}

static draft make_tiny(const rays_source *s, rays_random *r) {
    vec3_f64 target = rays_pick(s, r).point, dir = rays_direction(r);
    double *parts[3] = {&dir.x, &dir.y, &dir.z};
    unsigned axis = (unsigned)(rays_unit(r) * 3);
    *parts[axis] = copysign(rays_power(r, -36, -12), *parts[axis]);
    if (rays_unit(r) < 0.5)
        *parts[(axis + 1) % 3] = copysign(rays_power(r, -36, -12), *parts[(axis + 1) % 3]);
    return (draft){madd_f64(target, -2 * s->radius, dir), dir, 0, (double)INFINITY};
}

static draft make_bundle(const rays_source *s, rays_random *r) {
    rays_random all = rays_random_of(1, RAYS_BUNDLE, r->index / 16);
    vec3_f64 target = rays_pick(s, &all).point, dir = rays_direction(&all);
    double *parts[3] = {&dir.x, &dir.y, &dir.z}, spread = rays_power(&all, -6, -0.5);
    if (rays_unit(&all) < 0.6) *parts[(unsigned)(rays_unit(&all) * 3)] = 0;
    vec3_f64 org = madd_f64(target, -2 * s->radius, dir);
    if (rays_unit(&all) < 0.5) org = rays_in_ball(r, org, spread * s->radius);
    return (draft){org, madd_f64(dir, spread, rays_direction(r)), 0, (double)INFINITY};
}

/* A corner, a point on a side or inside, in multiples of an eighth. */
static vec3_f64 eighths(const rays_target *target, rays_random *r) {
    if (!target->corners) {
        vec3_f64 p = target->point;
        return vec_f64(round(8 * p.x) / 8, round(8 * p.y) / 8, round(8 * p.z) / 8);
    }
    double u = floor(9 * rays_unit(r)) / 8, v = floor((9 - 8 * u) * rays_unit(r)) / 8;
    vec3_f64 a = target->corner[0], b = target->corner[1], c = target->corner[target->corners - 1];
    return madd_f64(madd_f64(a, u, sub_f64(b, a)), v, sub_f64(c, a));
}

static double largest_part(vec3_f64 v) { return fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z))); }

/* A power of two along the axis closest to v, with random sign. */
static vec3_f64 along_axis(vec3_f64 v, rays_random *r) {
    double most = largest_part(v), length = exp2(floor(rays_between(r, -2, 3)));
    if (rays_unit(r) < 0.5) length = -length;
    if (fabs(v.x) == most) return vec_f64(length, 0, 0);
    return fabs(v.y) == most ? vec_f64(0, length, 0) : vec_f64(0, 0, length);
}

/* Sets some coordinates of the origin to those of a corner, so that it lies on planes of boxes. */
static vec3_f64 on_planes(const rays_target *target, rays_random *r, vec3_f64 org) {
    const vec3_f64 corner = some_corner(target, r);
    if (rays_unit(r) < 0.6) org.x = corner.x;
    if (rays_unit(r) < 0.6) org.y = corner.y;
    if (rays_unit(r) < 0.6) org.z = corner.z;
    return org;
}

static draft make_lattice(const rays_source *s, rays_random *r) {
    rays_target target = rays_pick(s, r);
    vec3_f64 point = eighths(&target, r), dir = along_axis(target.normal, r);
    double t = 1 + floor(4 * rays_unit(r)) / 2;
    draft ray = {madd_f64(point, -t, dir), dir, 0, (double)INFINITY};
    switch (r->index % 6) {
    case 0: ray.t_far = t; break;
    case 1: ray.t_near = t; break;
    case 2: ray.org = on_planes(&target, r, around(s, r)), ray.dir = along_axis(rays_direction(r), r); break;
    case 3: ray.org = on_planes(&target, r, around(s, r)), ray.dir = sub_f64(point, ray.org); break;
    default: break;
    }
    return ray;
}

static draft make_ends(const rays_source *s, rays_random *r) {
    return r->index % 2 ? make_surface(s, r) : make_uniform(s, r);
}

static const struct {
    const char *name;
    maker make;
} families[RAYS_FAMILIES] = {
    [RAYS_CAMERA] = {"camera", make_camera},
    [RAYS_UNIFORM] = {"uniform", make_uniform},
    [RAYS_EDGE] = {"edge", make_edge},
    [RAYS_VERTEX] = {"vertex", make_vertex},
    [RAYS_GRAZING] = {"grazing", make_grazing},
    [RAYS_TANGENT] = {"tangent", make_tangent},
    [RAYS_SURFACE] = {"surface", make_surface},
    [RAYS_FAR] = {"far", make_far},
    [RAYS_AXIS] = {"axis", make_axis},
    [RAYS_SCALED] = {"scaled", make_scaled},
    [RAYS_INTERVAL] = {"interval", make_interval},
    [RAYS_TINY] = {"tiny", make_tiny},
    [RAYS_BUNDLE] = {"bundle", make_bundle},
    [RAYS_LATTICE] = {"lattice", make_lattice},
    [RAYS_ENDS] = {"ends", make_ends},
    [RAYS_RENDERED] = {"rendered", NULL},
};

const char *rays_family_name(rays_family family) { return families[family].name; }

float rays_normal(double x) { return fabs(x) < (double)FLT_MIN ? (float)copysign(0, x) : (float)x; }

static vec3_f32 rounded(vec3_f64 v) { return vec_f32(rays_normal(v.x), rays_normal(v.y), rays_normal(v.z)); }

bool rays_allowed(const rays_source *source, const oracle_ray *ray) {
    bool moves = ray->dir.x != 0 || ray->dir.y != 0 || ray->dir.z != 0;
    bool in_range = source->stretch * length_f64(widen(ray->dir)) <= RAYS_LONGEST &&
                    source->stretch * length_f64(widen(ray->org)) + source->shift <= RAYS_LARGEST;
    return in_range && moves && ray->t_near >= 0 && isfinite(ray->t_near) && ray->t_near <= ray->t_far;
}

oracle_ray rays_make(const rays_source *source, rays_family family, uint64_t seed, uint64_t index) {
    rays_random r = rays_random_of(seed, (uint64_t)family, index);
    oracle_ray ray;
    for (int attempt = 0; attempt < 64; ++attempt) {
        draft d = source->own ? source->own(source->own_user, &r) : families[family].make(source, &r);
        ray = (oracle_ray){rounded(d.org), rounded(d.dir), rays_normal(d.t_near), rays_normal(d.t_far)};
        if (rays_allowed(source, &ray)) return ray;
    }
    /* Float cannot represent a ray to any target in this world. */
    return (oracle_ray){{0, 0, 0}, {0, 0, 1}, 0, INFINITY};
}
