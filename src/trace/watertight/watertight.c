#include "trace/watertight/watertight.h"

#include "base/kernel.h"
#include "trace/watertight/bodies.h"

#include <stdlib.h>
#include <string.h>

KERNEL_BEST(watertight_kernels)

struct watertight {
    const trace_tracer *tracer;
    const watertight_kernels *kernels;
    bodies bodies;
    bool inward; /* some bodies have FACING_IN */
    bool nested; /* something lies inside a body */
    bool turned; /* some instances with closed bodies are rotated, mirrored or skewed */
};

/* ---- depth of a point ---- */

/* A depth code: the number of bodies that cast shadows in the low bits, the number of others in the high
 * bits. */
#define DEPTH_BITS 4
#define COUNT_MOST ((1 << DEPTH_BITS) - 1) /* larger counts are clamped to this */

static int clamp_count(int count) { return count < 0 ? 0 : (count < COUNT_MOST ? count : COUNT_MOST); }

static uint8_t depth_of(body_counts counts) {
    return (uint8_t)(clamp_count(counts.casting) | clamp_count(counts.other) << DEPTH_BITS);
}

static body_counts counts_of(uint8_t depth) { return (body_counts){depth & COUNT_MOST, depth >> DEPTH_BITS}; }

static int total_of(uint8_t depth) { return counts_of(depth).casting + counts_of(depth).other; }

/* Depth of p, counted along one direction. False when out of memory. */
static bool depth_along(const watertight *w, vec3_f32 p, vec3_f32 dir, uint8_t *depth) {
    trace_crossings room = {0};
    bool fine = w->tracer->retry->crossings(w->tracer->self, 0, p, dir, &room);
    *depth = fine ? depth_of(bodies_around(&w->bodies, &room)) : 0;
    array_free(&room);
    return fine;
}

uint8_t watertight_depth(const watertight *w, vec3_f32 p) {
    uint8_t depths[BODIES_PROBES], best = 0;
    int votes = 0;
    for (int k = 0; k < BODIES_PROBES; ++k) depth_along(w, p, load_f32(bodies_probes[k]), &depths[k]);
    for (int k = 0; k < BODIES_PROBES; ++k) {
        int same = 0;
        for (int j = 0; j < BODIES_PROBES; ++j) same += depths[j] == depths[k];
        if (same > votes) best = depths[k], votes = same;
    }
    return best;
}

/* ---- impossible hits ---- */

/* The body that the lane's ray hits; NULL: none, or a plane. */
static const trace_body *body_met(const watertight *w, const trace_block *block, unsigned lane) {
    uint32_t geometry = block->hits.geometry[lane];
    if (geometry >= TRACE_PLANE) return NULL;
    return bodies_at(&w->bodies, geometry, block->hits.primitive[lane]);
}

/* True if the lane's ray leaves the closed body at its hit. The hit's normal is in the space of the
 * instance. */
static bool leaves(const watertight *w, const trace_block *block, unsigned lane, facing face) {
    const trace_hits *h = &block->hits;
    vec3_f32 d = trace_dir(&block->rays, lane);
    vec3_f32 n = {h->ng_x[lane], h->ng_y[lane], h->ng_z[lane]};
    if (h->instance[lane] != FATHOM_NONE) {
        const float(*m)[4] = w->tracer->world->instances.items[h->instance[lane]].to_object;
        d = vec_f32(m[0][0] * d.x + m[0][1] * d.y + m[0][2] * d.z,
                    m[1][0] * d.x + m[1][1] * d.y + m[1][2] * d.z,
                    m[2][0] * d.x + m[2][1] * d.y + m[2][2] * d.z);
    }
    return (dot_f32(n, d) > 0) == (face == FACING_OUT);
}

/* Upper bound of the number of closed bodies around the lane's hit, from their boxes. */
static int most_around(const watertight *w, const trace_block *block, unsigned lane) {
    const trace_rays *r = &block->rays;
    int most = 0;
    float t = r->t_far[lane], x = r->org_x[lane] + t * r->dir_x[lane],
          y = r->org_y[lane] + t * r->dir_y[lane], z = r->org_z[lane] + t * r->dir_z[lane];
    for (unsigned i = 0; i < w->bodies.box_count; ++i) {
        const body_box *b = &w->bodies.boxes[i];
        bool inside = (x >= b->lower.x) & (x <= b->upper.x) & (y >= b->lower.y) & (y <= b->upper.y) &
                      (z >= b->lower.z) & (z <= b->upper.z);
        most += inside ? b->count : 0;
    }
    return most;
}

/* True if the lane's hit is possible for a ray that starts inside `depth` bodies: the same number must lie
 * around the point just before the hit. */
static bool is_possible(const watertight *w, const trace_block *block, unsigned lane, int depth) {
    const trace_hits *h = &block->hits;
    if (h->geometry[lane] == FATHOM_NONE) return depth == 0;
    const trace_body *met = body_met(w, block, lane);
    int low = 0, high = BODIES_ANY;
    if (met) {
        low = met->around.low, high = met->around.high;
        if (h->instance[lane] != FATHOM_NONE && w->bodies.around) {
            low += w->bodies.around[h->instance[lane]].low;
            high += w->bodies.around[h->instance[lane]].high;
        } else if (h->instance[lane] != FATHOM_NONE) {
            high = BODIES_ANY;
        }
        bool out = met->facing != FACING_NONE && leaves(w, block, lane, met->facing);
        low += out, high += out;
    }
    if (depth < low || depth > high) return false;
    return depth == 0 || low == high || depth <= most_around(w, block, lane);
}

/* True if any lane hits something inside a body, or (if `back`) something closed. */
static bool any_in_doubt(const watertight *w, const trace_block *block, unsigned lanes, bool back) {
    const trace_hits *h = &block->hits;
    const bodies *b = &w->bodies;
    const size_t count = w->tracer->world->geometries.count;
    unsigned found = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        if (h->geometry[i] >= count) continue; /* a miss, or a plane */
        const geometry_bodies *of = &b->of[h->geometry[i]];
        found |= of->nested | (of->closed & back);
        if (b->around && h->instance[i] != FATHOM_NONE) found |= b->around[h->instance[i]].low;
    }
    return found;
}

/* A ray from outside hits bodies that are not nested from the front, so one test covers all lanes. */
static bool are_possible_from_outside(const watertight *w, const trace_block *block, unsigned lanes) {
    bool back = w->inward || w->kernels->any_back(w->tracer->world, w->turned, block, lanes);
    return !(back || w->nested) || !any_in_doubt(w, block, lanes, back);
}

/* The lanes with an impossible hit, as bits. */
static unsigned wrong_lanes(const watertight *w, const trace_block *block, const uint8_t *depth,
                            unsigned lanes) {
    static const uint8_t outside[LANES];
    unsigned found = 0;
    if (memcmp(depth, outside, lanes) == 0 && are_possible_from_outside(w, block, lanes)) return 0;
    for (unsigned i = 0; i < lanes; ++i)
        found |= (unsigned)!is_possible(w, block, i, total_of(depth[i])) << i;
    return found;
}

watertight_sides watertight_sides_of(const watertight *w, const trace_block *block, unsigned lane,
                                     uint8_t depth) {
    watertight_sides sides = {depth, depth};
    const trace_body *met = body_met(w, block, lane);
    if (!met || met->facing == FACING_NONE) return sides;
    body_counts counts = counts_of(depth);
    int *count = met->casts ? &counts.casting : &counts.other;
    if (!leaves(w, block, lane, met->facing)) {
        ++*count;
    } else {
        if (*count == 0) ++*count;
        sides.before = depth_of(counts);
        --*count;
    }
    sides.behind = depth_of(counts);
    return sides;
}

/* ---- tracing again ---- */

/* True if the crossings along the lane's ray agree with its depth. Then the hit may be right after all: if
 * bodies cross or touch, the number of bodies around a surface varies. */
static bool is_explained(const watertight *w, const trace_block *block, unsigned lane, uint8_t depth) {
    const trace_rays *r = &block->rays;
    uint8_t found;
    if (block->hits.geometry[lane] == FATHOM_NONE) return false;
    if (!depth_along(w, trace_org(r, lane), trace_dir(r, lane), &found)) return false;
    return total_of(found) == total_of(depth);
}

/* Rounds of retries around a ray, at 2^-20 to 2^-6 of the distance. If the first ROUNDS_FIRST find nothing,
 * is_explained() is tried. */
#define ROUNDS 8
#define ROUNDS_FIRST 2

static unsigned explained_lanes(const watertight *w, const trace_block *block, const uint8_t *depth,
                                unsigned lanes) {
    unsigned found = 0;
    for (; lanes; lanes &= lanes - 1) {
        unsigned i = (unsigned)__builtin_ctz(lanes);
        found |= (unsigned)is_explained(w, block, i, depth[i]) << i;
    }
    return found;
}

unsigned watertight_closest(const watertight *w, trace_block *block, const uint8_t depth[LANES],
                            unsigned lanes) {
    unsigned changed = 0, wrong = wrong_lanes(w, block, depth, lanes);
    for (unsigned k = 0; wrong && k < ROUNDS; ++k) {
        if (k == ROUNDS_FIRST) wrong &= ~explained_lanes(w, block, depth, wrong);
        for (unsigned i = 0; i < lanes; ++i)
            if (wrong >> i & 1 && w->tracer->retry->closest(w->tracer->self, block, i, k)) changed |= 1u << i;
        wrong &= wrong_lanes(w, block, depth, lanes);
    }
    return (unsigned)__builtin_popcount(changed);
}

unsigned watertight_any(const watertight *w, trace_rays *rays, const uint8_t depth[LANES],
                        const uint8_t end_depth[LANES], unsigned lanes) {
    unsigned changed = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        if (end_depth[i] == WATERTIGHT_UNSURE) continue;
        bool apart = counts_of(depth[i]).casting != counts_of(end_depth[i]).casting;
        if (!apart || rays->t_far[i] < 0) continue;
        if (w->tracer->tells_opaque && rays->flags[i]) { /* it may have left a body through a hole */
            rays->t_far[i] = TRACE_NOT_OPAQUE;
            continue;
        }
        unsigned k = 0;
        while (k < ROUNDS && !w->tracer->retry->any(w->tracer->self, rays, i, k)) ++k;
        if (k == ROUNDS) continue;
        if (w->tracer->tells_opaque) rays->t_far[i] = TRACE_NOT_OPAQUE; /* the surface is not known */
        ++changed;
    }
    return changed;
}

/* ---- life ---- */

/* True if d·n has the same sign with the ray in world space and in the instance's space. */
static bool is_straight(const world_instance *instance) {
    const float(*m)[4] = instance->to_object;
    bool diagonal =
        m[0][1] == 0 && m[0][2] == 0 && m[1][0] == 0 && m[1][2] == 0 && m[2][0] == 0 && m[2][1] == 0;
    return diagonal && m[0][0] > 0 && m[1][1] == m[0][0] && m[2][2] == m[0][0];
}

static bool is_turned(const watertight *w, const world_instance *instance) {
    const world_group *group = &w->tracer->world->groups.items[instance->group];
    bool closed = false;
    for (uint32_t i = 0; i < group->count; ++i) closed |= w->bodies.of[group->first + i].closed;
    return closed && !is_straight(instance);
}

/* Returns true if anything is closed. */
static bool survey(watertight *w) {
    const world *scene = w->tracer->world;
    bool any = false;
    for (size_t i = 0; i < w->bodies.count; ++i) {
        const trace_body *b = &w->bodies.all[i];
        any |= b->facing != FACING_NONE;
        w->inward |= b->facing == FACING_IN;
        w->nested |= b->around.low > 0;
    }
    for (size_t k = 0; any && k < scene->instances.count; ++k) {
        w->turned = w->turned || is_turned(w, &scene->instances.items[k]);
        w->nested |= w->bodies.around && w->bodies.around[k].low > 0;
    }
    return any;
}

static bool has_mesh(const world *w) {
    for (size_t i = 0; i < w->geometries.count; ++i)
        if (w->geometries.items[i].kind == WORLD_MESH) return true;
    return false;
}

fathom_status watertight_create(fathom_context *context, const trace_tracer *tracer, watertight **out) {
    const world *scene = tracer->world;
    *out = NULL;
    if (!tracer->retry || !has_mesh(scene)) return FATHOM_OK;
    watertight *w = calloc(1, sizeof *w);
    if (!w) return fail_memory(context, sizeof *w);
    w->tracer = tracer;
    w->kernels = watertight_kernels_best();
    bool fine = bodies_find(tracer, &w->bodies);
    if (fine && survey(w)) {
        *out = w;
        return FATHOM_OK;
    }
    watertight_destroy(w);
    return fine ? FATHOM_OK : fail_memory(context, scene->geometries.count * sizeof(trace_body));
}

void watertight_destroy(watertight *w) {
    if (!w) return;
    bodies_release(&w->bodies);
    free(w);
}
