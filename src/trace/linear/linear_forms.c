#include "trace/linear/linear.h"
#include "trace/search.h"

void linear_rays_prepare(linear_rays *rays) {
    rays->axis_lanes[0] = rays->axis_lanes[1] = rays->axis_lanes[2] = 0;
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
        triangle_ray_f32 ray = triangle_ray_make_f32(rays->org[i], rays->dir[i]);
        vec3_f32 org = turned_f32(ray.org, ray.axis);
        rays->ray[i] = ray;
        rays->ox[i] = org.x, rays->oy[i] = org.y, rays->oz[i] = org.z;
        rays->sx[i] = ray.sx, rays->sy[i] = ray.sy;
        rays->axis_lanes[ray.axis] |= 1u << i;
    }
}

static unsigned sphere_split(const linear_rays *rays, unsigned lanes, const world_sphere *sphere,
                             reference_hit_f32 *hits) {
    unsigned met = 0;
    for (unsigned i = 0; lanes >> i; ++i) {
        if (!(lanes >> i & 1)) continue;
        hits[i].u = hits[i].v = 0;
        met |= (unsigned)search_sphere_robust_f32(sphere, rays->org[i], rays->dir[i], rays->t_min[i],
                                                  rays->t_max[i], &hits[i].t)
               << i;
    }
    return met;
}

/* sphere_robust_f32() for 16 lanes: plain arithmetic for all, the wider precision for those in doubt. */
static unsigned sphere_robust(const linear_rays *rays, unsigned lanes, const world_sphere *sphere,
                              reference_hit_f32 *hits) {
    float near[TRACE_WIDTH], far[TRACE_WIDTH];
    int real[TRACE_WIDTH], doubt[TRACE_WIDTH];
    if (world_sphere_is_split(sphere)) return sphere_split(rays, lanes, sphere, hits);
    for (int i = 0; i < TRACE_WIDTH; ++i) {
        float roots[2];
        bool sure;
        real[i] = sphere_plain_f32(sphere->center, sphere->radius, rays->org[i], rays->dir[i], roots, &sure);
        doubt[i] = !sure;
        near[i] = roots[0], far[i] = roots[1];
    }
    unsigned met = 0;
    for (unsigned i = 0; lanes >> i; ++i) {
        if (!(lanes >> i & 1)) continue;
        float roots[2] = {near[i], far[i]};
        if (doubt[i])
            real[i] =
                sphere_roots_wide_f32(sphere->center, sphere->radius, rays->org[i], rays->dir[i], roots);
        bool hit = real[i] && sphere_choose_f32(roots, rays->t_min[i], rays->t_max[i], &hits[i].t);
        hits[i].u = hits[i].v = 0;
        met |= (unsigned)hit << i;
    }
    return met;
}

static unsigned quad_robust(const linear_rays *rays, unsigned lanes, const world_quad *quad,
                            reference_hit_f32 *hits) {
    const vec3_f32 *v = quad->corner;
    unsigned met = 0;
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
        if (!(lanes >> i & 1)) continue;
        bool hit = quad_robust_f32(v[0], v[1], v[2], v[3], rays->org[i], rays->dir[i], rays->t_min[i],
                                   rays->t_max[i], &hits[i]);
        met |= (unsigned)hit << i;
    }
    return met;
}

/* The lanes whose edge functions do not differ in sign: triangle_sheared_f32() up to its first return, the
 * same operations in the same order, but for all 16 lanes at once as if they all had this axis. */
static unsigned triangle_candidates(const linear_rays *rays, int axis, const vec3_f32 v[3]) {
    vec3_f32 p = turned_f32(v[0], axis), q = turned_f32(v[1], axis), r = turned_f32(v[2], axis);
    int candidate[TRACE_WIDTH], any = 0;
    for (int i = 0; i < TRACE_WIDTH; ++i) {
        float ox = rays->ox[i], oy = rays->oy[i], oz = rays->oz[i], sx = rays->sx[i], sy = rays->sy[i];
        float az = p.z - oz, bz = q.z - oz, cz = r.z - oz;
        float ax = (p.x - ox) - sx * az, ay = (p.y - oy) - sy * az;
        float bx = (q.x - ox) - sx * bz, by = (q.y - oy) - sy * bz;
        float cx = (r.x - ox) - sx * cz, cy = (r.y - oy) - sy * cz;
        float e = cx * by - cy * bx, f = ax * cy - ay * cx, g = bx * ay - by * ax;
        int negative = (e < 0) | (f < 0) | (g < 0), positive = (e > 0) | (f > 0) | (g > 0);
        candidate[i] = !(negative & positive);
    }
    for (int i = 0; i < TRACE_WIDTH; ++i) any |= candidate[i];
    if (!any) return 0;
    unsigned lanes = 0;
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) lanes |= (unsigned)candidate[i] << i;
    return lanes;
}

static unsigned triangle_robust(const linear_rays *rays, unsigned lanes, const vec3_f32 v[3],
                                reference_hit_f32 *hits) {
    unsigned met = 0;
    for (int axis = 0; axis < 3; ++axis) {
        unsigned turned = lanes & rays->axis_lanes[axis];
        if (turned) turned &= triangle_candidates(rays, axis, v);
        for (unsigned i = 0; turned >> i; ++i) {
            if (!(turned >> i & 1)) continue;
            bool hit = triangle_robust_ray_f32(v[0], v[1], v[2], &rays->ray[i], rays->t_min[i],
                                               rays->t_max[i], &hits[i]);
            met |= (unsigned)hit << i;
        }
    }
    return met;
}

const linear_form linear_robust_f32 = {"reference", sphere_robust, quad_robust, triangle_robust};
