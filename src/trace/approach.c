#include "trace/approach.h"

#include "scene/scene.h"

#include <math.h>

/* A start that leaves out less than this many radii would gain too little accuracy. */
static const double far_ratio = 4;

fathom_status trace_approach_find(const world *w, trace_approach *out) {
    scene_bounds bounds;
    const fathom_status status = scene_world_bounds(w->scene, &bounds);
    if (status != FATHOM_OK) return status;
    *out = (trace_approach){.world = w,
                            .center = sub_f64(bounds_center(&bounds), w->origin),
                            .radius = bounds_is_empty(&bounds) ? (double)INFINITY : bounds_radius(&bounds)};
    return FATHOM_OK;
}

/* The radius of a sphere around the scene: 1 % covers the rounding of its coordinates to float, 2^-40 the
 * rounding of the way to it in double. */
static double reach_of(const trace_approach *a, vec3_f64 to) {
    return 1.01 * a->radius + 0x1p-40 * length_f64(to);
}

bool trace_approach_is_far(const trace_approach *a, vec3_f64 org) {
    const vec3_f64 to = sub_f64(a->center, org);
    const double reach = reach_of(a, to);
    return length_f64(to) - reach > far_ratio * reach;
}

/* Before the nearest plane, too. With u = 2^-53, n the plane's unit normal and f the way to its point,
 * t = f·n / d·n has an error of at most 12 u |f| (1 + |d| / |d·n|) / |d·n|; 2^-20 keeps the start before it
 * in float, too. */
double trace_approach_start(const trace_approach *a, vec3_f64 org, vec3_f64 dir, double least) {
    const double length = length_f64(dir);
    const vec3_f64 to = sub_f64(a->center, org);
    const double reach = reach_of(a, to) / length;
    double start = dot_f64(to, dir) / (length * length) - reach;
    if (!(start > least + far_ratio * reach)) return least;
    for (size_t p = 0; p < a->world->planes.count; ++p) {
        const world_plane *plane = &a->world->planes.items[p];
        const vec3_f64 f = sub_f64(widen(plane->point), org), n = widen(plane->normal);
        const double along = dot_f64(dir, n), t = dot_f64(f, n) / along;
        const double slack = (0x1p-49 * length_f64(f) * (1 + length / fabs(along)) +
                              0x1p-20 * length_f64(madd_f64(org, t, dir))) /
                             fabs(along);
        if (t + slack > least) start = fmin(start, t - slack);
    }
    return fmax(start, least);
}
