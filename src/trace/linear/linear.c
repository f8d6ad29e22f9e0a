/* The reference tracer: every ray against every primitive, in world order, robust and in float. Its answers
 * define closest hit and any hit. Nothing is culled before the intersectors: no cull could be trusted more
 * than they are. */
#include "trace/search.h"
#include "trace/tracer.h"

#include <stdlib.h>

/* Up to 16 rays in the space of the geometry at hand. Lanes that are not in use hold zeros. */
typedef struct linear_rays {
    vec3_f32 org[LANES], dir[LANES];
    float t_min[LANES], t_max[LANES];
    /* For the watertight test, whole and lane by lane: the origin turned, the shear. */
    triangle_ray_f32 ray[LANES];
    float ox[LANES], oy[LANES], oz[LANES], sx[LANES], sy[LANES];
    unsigned axis_lanes[3]; /* bit i: lane i has this axis */
} linear_rays;

/* ---- one primitive ----
 * Each function tests the lanes whose bits are set and returns the bits of those that meet the primitive,
 * with their hits. */

/* Fills what follows from org and dir. */
static void linear_rays_prepare(linear_rays *rays) {
    rays->axis_lanes[0] = rays->axis_lanes[1] = rays->axis_lanes[2] = 0;
    for (unsigned i = 0; i < LANES; ++i) {
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
    float near[LANES], far[LANES];
    int real[LANES], doubt[LANES];
    if (world_sphere_is_split(sphere)) return sphere_split(rays, lanes, sphere, hits);
    for (int i = 0; i < LANES; ++i) {
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
    for (unsigned i = 0; i < LANES; ++i) {
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
    int candidate[LANES], any = 0;
    for (int i = 0; i < LANES; ++i) {
        float ox = rays->ox[i], oy = rays->oy[i], oz = rays->oz[i], sx = rays->sx[i], sy = rays->sy[i];
        float az = p.z - oz, bz = q.z - oz, cz = r.z - oz;
        float ax = (p.x - ox) - sx * az, ay = (p.y - oy) - sy * az;
        float bx = (q.x - ox) - sx * bz, by = (q.y - oy) - sy * bz;
        float cx = (r.x - ox) - sx * cz, cy = (r.y - oy) - sy * cz;
        float e = cx * by - cy * bx, f = ax * cy - ay * cx, g = bx * ay - by * ax;
        int negative = (e < 0) | (f < 0) | (g < 0), positive = (e > 0) | (f > 0) | (g > 0);
        candidate[i] = !(negative & positive);
    }
    for (int i = 0; i < LANES; ++i) any |= candidate[i];
    if (!any) return 0;
    unsigned lanes = 0;
    for (unsigned i = 0; i < LANES; ++i) lanes |= (unsigned)candidate[i] << i;
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

/* ---- one block ---- */

/* One block on its way through the world. */
typedef struct linear_walk {
    const world *world;
    linear_rays rays;
    unsigned lanes;    /* still looking */
    trace_hits *hits;  /* NULL: any hit will do */
    uint32_t instance; /* at hand */
    uint32_t geometry;
} linear_walk;

static void record(linear_walk *walk, unsigned lane, uint32_t primitive, const reference_hit_f32 *hit,
                   vec3_f32 normal) {
    trace_hits *hits = walk->hits;
    walk->rays.t_max[lane] = hit->t;
    hits->ng_x[lane] = normal.x, hits->ng_y[lane] = normal.y, hits->ng_z[lane] = normal.z;
    hits->u[lane] = hit->u, hits->v[lane] = hit->v;
    hits->primitive[lane] = primitive;
    hits->geometry[lane] = walk->geometry;
    hits->instance[lane] = walk->instance;
}

/* Records lanes that met something: for closest hits the ray becomes shorter, so on equal t the first one
 * found stays; for any hit the lane is done. */
static void meet(linear_walk *walk, unsigned met, uint32_t primitive, const reference_hit_f32 *hits,
                 vec3_f32 normal) {
    if (walk->hits) {
        for (unsigned i = 0; met >> i; ++i) {
            if (met >> i & 1) record(walk, i, primitive, &hits[i], normal);
        }
    } else {
        walk->lanes &= ~met;
    }
}

static void walk_spheres(linear_walk *walk, const world_geometry *geometry) {
    reference_hit_f32 hits[LANES];
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        const world_sphere *sphere = &walk->world->spheres.items[geometry->first + k];
        unsigned met = sphere_robust(&walk->rays, walk->lanes, sphere, hits);
        for (unsigned i = 0; met >> i; ++i) {
            if (!(met >> i & 1)) continue;
            vec3_f32 p = madd_f32(walk->rays.org[i], hits[i].t, walk->rays.dir[i]);
            meet(walk, 1u << i, k, hits, sub_f32(p, sphere->center));
        }
    }
}

static vec3_f32 normal_of(vec3_f32 a, vec3_f32 b, vec3_f32 c) {
    return cross_f32(sub_f32(b, a), sub_f32(c, a));
}

static void walk_quads(linear_walk *walk, const world_geometry *geometry) {
    reference_hit_f32 hits[LANES];
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        const world_quad *quad = &walk->world->quads.items[geometry->first + k];
        unsigned met = quad_robust(&walk->rays, walk->lanes, quad, hits);
        const vec3_f32 *v = quad->corner;
        if (met) meet(walk, met, k, hits, normal_of(v[0], v[1], v[3]));
    }
}

static void walk_mesh(linear_walk *walk, const world_geometry *geometry) {
    reference_hit_f32 hits[LANES];
    const fathom_mesh *mesh = &walk->world->meshes.items[geometry->first];
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        vec3_f32 v[3];
        search_corners(mesh, k, v);
        unsigned met = triangle_robust(&walk->rays, walk->lanes, v, hits);
        if (met) meet(walk, met, k, hits, normal_of(v[0], v[1], v[2]));
    }
}

static void walk_group(linear_walk *walk, uint32_t group, uint32_t instance) {
    const world *w = walk->world;
    walk->instance = instance;
    for (uint32_t g = 0; g < w->groups.items[group].count && walk->lanes; ++g) {
        walk->geometry = w->groups.items[group].first + g;
        const world_geometry *geometry = &w->geometries.items[walk->geometry];
        if (!walk->hits && geometry->flags & FATHOM_CASTS_NO_SHADOW) continue;
        switch (geometry->kind) {
        case WORLD_SPHERES: walk_spheres(walk, geometry); break;
        case WORLD_QUADS: walk_quads(walk, geometry); break;
        case WORLD_MESH: walk_mesh(walk, geometry); break;
        }
    }
}

/* A row of the map applied to p and w, rounded once to float: the products of floats are exact in double. */
static float carried(const float row[4], vec3_f32 p, float w) {
    return (float)((double)row[0] * (double)p.x + (double)row[1] * (double)p.y +
                   (double)row[2] * (double)p.z + (double)row[3] * (double)w);
}

static vec3_f32 carried_all(const float m[3][4], vec3_f32 p, float w) {
    return vec_f32(carried(m[0], p, w), carried(m[1], p, w), carried(m[2], p, w));
}

/* Rays into the space of an instance, or as they are for NULL. Directions keep their length, so t keeps its
 * meaning. */
static void enter_space(linear_walk *walk, const trace_rays *rays, const world_instance *instance) {
    for (unsigned i = 0; i < LANES; ++i) {
        if (!(walk->lanes >> i & 1)) continue;
        vec3_f32 org = trace_org(rays, i), dir = trace_dir(rays, i);
        walk->rays.org[i] = instance ? carried_all(instance->to_object, org, 1) : org;
        walk->rays.dir[i] = instance ? carried_all(instance->to_object, dir, 0) : dir;
    }
    linear_rays_prepare(&walk->rays);
}

/* The first `count` lanes of one block; hits is NULL for any hit. */
static void walk_world(const world *w, trace_rays *rays, trace_hits *hits, size_t count) {
    linear_walk walk = {.world = w, .hits = hits};
    for (unsigned i = 0; i < LANES && i < count; ++i) {
        walk.rays.t_min[i] = rays->t_near[i], walk.rays.t_max[i] = rays->t_far[i];
        if (rays->t_near[i] < rays->t_far[i]) walk.lanes |= 1u << i;
        if (hits) hits->geometry[i] = FATHOM_NONE;
    }
    unsigned asked = walk.lanes;
    enter_space(&walk, rays, NULL);
    walk_group(&walk, 0, FATHOM_NONE);
    for (size_t k = 0; k < w->instances.count && walk.lanes; ++k) {
        enter_space(&walk, rays, &w->instances.items[k]);
        walk_group(&walk, w->instances.items[k].group, (uint32_t)k);
    }
    for (unsigned i = 0; i < LANES; ++i) {
        if (!(asked >> i & 1)) continue;
        if (hits)
            rays->t_far[i] = walk.rays.t_max[i];
        else if (!(walk.lanes >> i & 1))
            rays->t_far[i] = -INFINITY;
    }
}

static void linear_closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                           trace_coherence coherence) {
    (void)fine, (void)coherence;
    for (size_t first = 0; first < count; first += LANES) {
        trace_block *block = &blocks[first / LANES];
        walk_world(tracer->world, &block->rays, &block->hits, count - first);
    }
}

static void linear_any(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                       trace_coherence coherence) {
    (void)coherence;
    for (size_t first = 0; first < count; first += LANES) {
        walk_world(tracer->world, &blocks[first / LANES], NULL, count - first);
    }
}

static void linear_destroy(trace_tracer *tracer) { free(tracer); }

fathom_status linear_create(fathom_context *context, const world *w, trace_tracer **out) {
    static const trace_ops ops = {linear_destroy, linear_closest, linear_any, false, false};
    trace_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    *tracer = (trace_tracer){.ops = &ops, .world = w, .unit = 0x1p-24, .slow = true, .name = "reference"};
    *out = tracer;
    return FATHOM_OK;
}
