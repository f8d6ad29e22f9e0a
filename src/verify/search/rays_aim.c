#include "math/mix.h"
#include "trace/trace.h"
#include "verify/search/rays.h"
#include "verify/search/search.h"

#include <stdlib.h>

rays_random rays_random_of(uint64_t seed, uint64_t family, uint64_t index) {
    uint64_t key = mix_bits(seed + 0x9e3779b97f4a7c15u);
    return (rays_random){mix_bits(mix_bits(key + family * 0xd1342543de82ef95u) + index * 0x9e3779b97f4a7c15u),
                         index};
}

double rays_unit(rays_random *r) {
    return (double)(mix_bits(r->counter += 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53;
}
double rays_between(rays_random *r, double low, double high) { return low + (high - low) * rays_unit(r); }
double rays_power(rays_random *r, double low, double high) { return pow(10, rays_between(r, low, high)); }

vec3_f64 rays_direction(rays_random *r) {
    double z = rays_between(r, -1, 1), phi = rays_between(r, 0, 6.283185307179586), s = sqrt(1 - z * z);
    return vec_f64(s * cos(phi), s * sin(phi), z);
}

vec3_f64 rays_in_ball(rays_random *r, vec3_f64 center, double radius) {
    double out = radius * cbrt(rays_unit(r));
    return madd_f64(center, out, rays_direction(r));
}

vec3_f64 rays_perpendicular(rays_random *r, vec3_f64 to) {
    vec3_f64 axis = normalize_f64(to), across;
    do {
        vec3_f64 any = rays_direction(r);
        across = madd_f64(any, -dot_f64(any, axis), axis);
    } while (dot_f64(across, across) < 1e-4);
    return normalize_f64(across);
}

static vec3_f64 placed(const world_instance *instance, vec3_f64 p) {
    if (!instance) return p;
    const affine_f64 to_world = affine_widen(instance->to_world);
    return affine_point(&to_world, p);
}

/* A uniform point in the triangle. */
static vec3_f64 in_triangle(rays_random *r, vec3_f64 a, vec3_f64 b, vec3_f64 c) {
    double u = rays_unit(r), v = rays_unit(r);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    return madd_f64(madd_f64(a, u, sub_f64(b, a)), v, sub_f64(c, a));
}

static void aim_at_sphere(const oracle_primitive *p, rays_random *r, rays_target *out) {
    vec3_f64 n = rays_direction(r), center = oracle_center(p);
    out->point = placed(p->instance, madd_f64(center, oracle_radius(p), n));
    vec3_f64 u = rays_perpendicular(r, n), v = cross_f64(n, u), origin = placed(p->instance, center);
    u = sub_f64(placed(p->instance, add_f64(center, u)), origin);
    v = sub_f64(placed(p->instance, add_f64(center, v)), origin);
    out->normal = normalize_f64(cross_f64(u, v));
}

static void aim_at_corners(const oracle_primitive *p, rays_random *r, rays_target *out) {
    out->corners = oracle_corners(p);
    vec3_f64 *c = out->corner;
    for (unsigned k = 0; k < out->corners; ++k) c[k] = placed(p->instance, widen(p->v[k]));
    vec3_f64 last = c[out->corners - 1];
    bool second = out->corners == 4 && rays_unit(r) < 0.5;
    out->point = second ? in_triangle(r, c[2], c[3], c[1]) : in_triangle(r, c[0], c[1], last);
    out->normal = normalize_f64(cross_f64(sub_f64(c[1], c[0]), sub_f64(last, c[0])));
}

static void aim_at_plane(const rays_source *s, const world_plane *plane, rays_random *r, rays_target *out) {
    double u = rays_between(r, -s->radius, s->radius), v = rays_between(r, -s->radius, s->radius);
    vec3_f64 along = madd_f64(scale_f64(u, widen(plane->u)), v, widen(plane->v));
    out->point = add_f64(widen(plane->point), along);
    out->normal = widen(plane->normal);
}

/* A random index. One in eight is the first, one of the last, or next to a power of two, at the limits of
 * small counters. */
static uint32_t pick_index(uint32_t count, rays_random *r) {
    uint32_t any = (uint32_t)(rays_unit(r) * (double)count);
    if (rays_unit(r) < 0.875) return any;
    double kind = rays_unit(r), power = exp2(floor(rays_unit(r) * log2(count)));
    if (kind < 0.25) return 0;
    if (kind < 0.5) return count - 1;
    if (kind < 0.75) return count - 1 - (any & 7) % count;
    return count > 1 ? (uint32_t)power - (any & 1) : 0;
}

rays_target rays_pick(const rays_source *source, rays_random *r) {
    rays_target target = {.corners = 0};
    target.run = &source->runs.items[(size_t)(rays_unit(r) * (double)source->runs.count)];
    uint32_t index = pick_index(target.run->count, r);
    oracle_primitive p = search_primitive(source->world, target.run->geometry, index, target.run->instance);
    target.shape = p.shape;
    switch (p.shape) {
    case ORACLE_SPHERE: aim_at_sphere(&p, r, &target); break;
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD: aim_at_corners(&p, r, &target); break;
    case ORACLE_PLANE: aim_at_plane(source, &source->world->planes.items[index], r, &target); break;
    }
    return target;
}

/* ---- the world's contents ---- */

static void add_primitive(scene_bounds *box, const oracle_primitive *p) {
    if (p->shape == ORACLE_SPHERE) {
        vec3_f64 c = widen(p->v[0]);
        for (int k = 0; k < 8; ++k) {
            double r = (double)p->radius, x = k & 1 ? r : -r, y = k & 2 ? r : -r, z = k & 4 ? r : -r;
            bounds_add(box, placed(p->instance, add_f64(c, vec_f64(x, y, z))));
        }
        return;
    }
    for (int k = 0; k < (p->shape == ORACLE_QUAD ? 4 : 3); ++k) {
        if (finite_f32(p->v[k])) bounds_add(box, placed(p->instance, widen(p->v[k])));
    }
}

static bool add_run(rays_source *source, uint32_t geometry, uint32_t instance, scene_bounds *whole) {
    rays_run run = {.geometry = geometry, .instance = instance};
    run.count = source->world->geometries.items[geometry].count;
    scene_bounds box = bounds_empty();
    for (uint32_t k = 0; k < run.count; ++k) {
        oracle_primitive p = search_primitive(source->world, geometry, k, instance);
        add_primitive(&box, &p);
    }
    if (bounds_is_empty(&box)) return true;
    run.center = bounds_center(&box), run.radius = bounds_radius(&box);
    bounds_join(whole, &box);
    return array_push(&source->runs, run);
}

static bool add_group(rays_source *source, uint32_t group, uint32_t instance, scene_bounds *whole) {
    const world_group *g = &source->world->groups.items[group];
    for (uint32_t k = 0; k < g->count; ++k) {
        if (!add_run(source, g->first + k, instance, whole)) return false;
    }
    return true;
}

static bool add_all(rays_source *source) {
    const world *w = source->world;
    scene_bounds whole = bounds_empty();
    if (w->groups.count && !add_group(source, 0, FATHOM_NONE, &whole)) return false;
    for (uint32_t k = 0; k < w->instances.count; ++k) {
        if (!add_group(source, w->instances.items[k].group, k, &whole)) return false;
    }
    bool empty = bounds_is_empty(&whole);
    source->center = empty ? vec_f64(0, 0, 0) : bounds_center(&whole);
    source->radius = empty ? 1 : fmax(bounds_radius(&whole), 1e-30);
    rays_run planes = {.geometry = TRACE_PLANE, .instance = FATHOM_NONE, .center = source->center};
    planes.count = (uint32_t)w->planes.count, planes.radius = source->radius;
    return planes.count == 0 || array_push(&source->runs, planes);
}

/* Uses the Frobenius norm. */
static void set_stretch(rays_source *source) {
    source->stretch = 1;
    for (size_t k = 0; k < source->world->instances.count; ++k) {
        const float(*m)[4] = source->world->instances.items[k].to_object;
        double sum = 0, shift = 0;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) sum += (double)m[i][j] * (double)m[i][j];
            shift += fabs((double)m[i][3]);
        }
        source->stretch = fmax(source->stretch, sqrt(sum));
        source->shift = fmax(source->shift, shift);
    }
}

fathom_status rays_create(fathom_context *context, const world *w, rays_source **out) {
    *out = NULL;
    rays_source *source = calloc(1, sizeof *source);
    if (!source) return fail_memory(context, sizeof *source);
    source->world = w;
    set_stretch(source);
    fathom_status status = FATHOM_OK;
    if (!add_all(source))
        status = fail_memory(context, sizeof *source->runs.items);
    else if (!source->runs.count)
        status = fail(context, FATHOM_BAD_INPUT, "nothing to aim rays at: the scene is empty");
    if (status != FATHOM_OK) {
        rays_destroy(source);
        return status;
    }
    *out = source;
    return FATHOM_OK;
}

void rays_destroy(rays_source *source) {
    if (!source) return;
    array_free(&source->runs);
    free(source);
}
