/* The reference tracer: every ray against every primitive, in world order. What it answers is the definition
 * of closest hit and any hit. No cull stands before the primitives: none could be trusted more than they are.
 */
#include "trace/linear/linear.h"
#include "trace/tracer.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct linear_tracer {
    trace_tracer base;
    const linear_form *form;
} linear_tracer;

/* One block on its way through the world. */
typedef struct linear_walk {
    const linear_tracer *tracer;
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

/* Lanes that met something: the closest hit goes on with a shorter ray, so on equal t the first one found
 * stays; any hit is done. */
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
    reference_hit_f32 hits[TRACE_WIDTH];
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        const world_sphere *sphere = &walk->world->spheres.items[geometry->first + k];
        unsigned met = walk->tracer->form->sphere(&walk->rays, walk->lanes, sphere, hits);
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
    reference_hit_f32 hits[TRACE_WIDTH];
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        const world_quad *quad = &walk->world->quads.items[geometry->first + k];
        unsigned met = walk->tracer->form->quad(&walk->rays, walk->lanes, quad, hits);
        const vec3_f32 *v = quad->corner;
        if (met) meet(walk, met, k, hits, normal_of(v[0], v[1], v[3]));
    }
}

static void walk_mesh(linear_walk *walk, const world_geometry *geometry) {
    reference_hit_f32 hits[TRACE_WIDTH];
    const fathom_mesh *mesh = &walk->world->meshes.items[geometry->first];
    const char *positions = (const char *)mesh->positions;
    size_t stride = mesh->position_stride ? mesh->position_stride : 3 * sizeof(float);
    for (uint32_t k = 0; k < geometry->count && walk->lanes; ++k) {
        vec3_f32 v[3];
        for (unsigned c = 0; c < 3; ++c) {
            v[c] = load_f32(
                (const float *)(const void *)(positions + mesh->indices[3 * (size_t)k + c] * stride));
        }
        unsigned met = walk->tracer->form->triangle(&walk->rays, walk->lanes, v, hits);
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
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
        if (!(walk->lanes >> i & 1)) continue;
        vec3_f32 org = {rays->org_x[i], rays->org_y[i], rays->org_z[i]};
        vec3_f32 dir = {rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]};
        walk->rays.org[i] = instance ? carried_all(instance->to_object, org, 1) : org;
        walk->rays.dir[i] = instance ? carried_all(instance->to_object, dir, 0) : dir;
    }
    linear_rays_prepare(&walk->rays);
}

/* The first `count` lanes of one block; hits is NULL for any hit. */
static void walk_world(const linear_tracer *tracer, trace_rays *rays, trace_hits *hits, size_t count) {
    const world *w = tracer->base.world;
    linear_walk walk = {.tracer = tracer, .world = w, .hits = hits};
    for (unsigned i = 0; i < TRACE_WIDTH && i < count; ++i) {
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
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
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
    for (size_t first = 0; first < count; first += TRACE_WIDTH) {
        trace_block *block = &blocks[first / TRACE_WIDTH];
        walk_world((const linear_tracer *)tracer, &block->rays, &block->hits, count - first);
    }
}

static void linear_any(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                       trace_coherence coherence) {
    (void)coherence;
    for (size_t first = 0; first < count; first += TRACE_WIDTH) {
        walk_world((const linear_tracer *)tracer, &blocks[first / TRACE_WIDTH], NULL, count - first);
    }
}

static void linear_destroy(trace_tracer *tracer) { free(tracer); }

fathom_status linear_create(fathom_context *context, const world *w, trace_tracer **out) {
    static const trace_ops ops = {linear_destroy, linear_closest, linear_any, false, false};
    linear_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = &ops;
    tracer->base.world = w;
    tracer->base.unit = 0x1p-24;
    tracer->form = &linear_robust_f32;
    snprintf(tracer->base.name, sizeof tracer->base.name, "%s", tracer->form->name);
    *out = &tracer->base;
    return FATHOM_OK;
}
