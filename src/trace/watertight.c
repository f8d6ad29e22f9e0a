#include "trace/watertight.h"

#include "scene/closed.h"
#include "trace/search.h"
#include "trace/tracer.h"

#include <stdlib.h>
#include <string.h>

/* Which side of a closed mesh is out, by the way its corners go round. */
typedef enum facing { FACING_NONE, FACING_OUT, FACING_IN } facing;

struct watertight {
    const trace_tracer *tracer;
    bool (*any_back)(const watertight *w, const trace_block *block, unsigned lanes);
    facing *facings;       /* by geometry; FACING_NONE: not closed */
    bool inward;           /* some face in */
    bool turned;           /* some are placed by maps that turn, mirror or skew */
    bool shadows;          /* every closed mesh casts shadows */
    vec3_f32 lower, upper; /* all there is but planes lies in here */
};

/* Directions without a pattern that scenes share. A line meets an edge or a vertex with a probability of some
 * 10^-5, so of five it is never most. */
#define PROBES 5
static const float probe_directions[PROBES][3] = {{0.5773f, 0.2113f, 0.7886f},
                                                  {-0.3187f, 0.8361f, 0.4464f},
                                                  {0.1741f, -0.6327f, 0.7545f},
                                                  {-0.7071f, -0.4937f, 0.5062f},
                                                  {0.9129f, -0.1277f, -0.3877f}};

/* ---- what faces out ---- */

static vec3_f32 triangle_middle(const world *w, uint32_t geometry, size_t triangle) {
    vec3_f32 v[3];
    search_corners(world_mesh(w, geometry), (uint32_t)triangle, v);
    return scale_f32(1.0f / 3, add_f32(v[0], add_f32(v[1], v[2])));
}

/* The nearest crossing of the geometry, or of those closed together with it; NULL: none. */
static const trace_crossing *first_crossing(const trace_crossings *list, const closed_how *closed,
                                            uint32_t geometry) {
    const trace_crossing *first = NULL;
    for (size_t i = 0; i < list->count; ++i) {
        const trace_crossing *c = &list->items[i];
        bool counts = c->geometry == geometry ||
                      (closed[geometry] == CLOSED_TOGETHER && closed[c->geometry] == CLOSED_TOGETHER);
        if (counts && (!first || c->t < first->t)) first = c;
    }
    return first;
}

/* The first crossing from far outside goes in: most of the probes decide. */
static bool find_facing(watertight *w, uint32_t group, uint32_t geometry, const closed_how *closed,
                        trace_crossings *room) {
    const world *scene = w->tracer->world;
    const trace_retry *retry = w->tracer->retry;
    size_t count = scene->geometries.items[geometry].count;
    vec3_f32 lower, upper;
    int out = 0;
    retry->bounds(w->tracer, group, &lower, &upper);
    float size = length_f32(sub_f32(upper, lower));
    for (size_t k = 0; k < PROBES && count; ++k) {
        vec3_f32 dir = load_f32(probe_directions[k]);
        vec3_f32 org = madd_f32(triangle_middle(scene, geometry, k * count / PROBES), -2 * size, dir);
        if (!retry->crossings(w->tracer, group, org, dir, room)) return false;
        const trace_crossing *first = first_crossing(room, closed, geometry);
        if (first) out += first->entering ? 1 : -1;
    }
    w->facings[geometry] = out > 0 ? FACING_OUT : (out < 0 ? FACING_IN : FACING_NONE);
    return true;
}

static bool find_facings(watertight *w, const closed_how *closed) {
    const world *scene = w->tracer->world;
    trace_crossings room = {0};
    bool fine = true;
    for (uint32_t g = 0; g < scene->groups.count; ++g) {
        uint32_t first = scene->groups.items[g].first, end = first + scene->groups.items[g].count;
        for (uint32_t i = first; i < end && fine; ++i) {
            if (closed[i] != CLOSED_NOT) fine = find_facing(w, g, i, closed, &room);
        }
    }
    array_free(&room);
    return fine;
}

/* ---- how deep a point lies ---- */

/* Ways out less ways in, along one direction; -1: out of memory. */
static int depth_along(const watertight *w, vec3_f32 p, vec3_f32 dir, trace_crossings *room) {
    if (!w->tracer->retry->crossings(w->tracer, 0, p, dir, room)) return -1;
    int depth = 0;
    for (size_t i = 0; i < room->count; ++i) {
        facing f = w->facings[room->items[i].geometry];
        if (f == FACING_NONE) continue;
        depth += room->items[i].entering == (f == FACING_OUT) ? -1 : 1;
    }
    return depth < 0 ? 0 : (depth < WATERTIGHT_DEEPEST ? depth : WATERTIGHT_DEEPEST);
}

uint8_t watertight_depth(const watertight *w, vec3_f32 p) {
    int depths[PROBES], best = 0, votes = 0;
    trace_crossings room = {0};
    for (int k = 0; k < PROBES; ++k) depths[k] = depth_along(w, p, load_f32(probe_directions[k]), &room);
    array_free(&room);
    for (int k = 0; k < PROBES; ++k) {
        int same = 0;
        for (int j = 0; j < PROBES; ++j) same += depths[j] == depths[k];
        if (same > votes) best = depths[k], votes = same;
    }
    return (uint8_t)(best > 0 ? best : 0);
}

/* ---- answers that cannot be ---- */

/* d·n of each lane, n the geometric normal, both in the space of the instance. */
static inline __attribute__((always_inline)) void along_in(const world *w, uint32_t instance,
                                                           const trace_block *block, float out[TRACE_WIDTH]) {
    static const float identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const float(*m)[4] = instance == FATHOM_NONE ? identity : w->instances.items[instance].to_object;
    const trace_rays *r = &block->rays;
    const trace_hits *h = &block->hits;
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
        float x = m[0][0] * r->dir_x[i] + m[0][1] * r->dir_y[i] + m[0][2] * r->dir_z[i];
        float y = m[1][0] * r->dir_x[i] + m[1][1] * r->dir_y[i] + m[1][2] * r->dir_z[i];
        float z = m[2][0] * r->dir_x[i] + m[2][1] * r->dir_y[i] + m[2][2] * r->dir_z[i];
        out[i] = h->ng_x[i] * x + h->ng_y[i] * y + h->ng_z[i] * z;
    }
}

/* Whether the lane's ray goes through its hit to the outside of the mesh; the mesh is closed. */
static bool leaves(const watertight *w, const trace_block *block, unsigned lane) {
    float along[TRACE_WIDTH];
    along_in(w->tracer->world, block->hits.instance[lane], block, along);
    return (along[lane] > 0) == (w->facings[block->hits.geometry[lane]] == FACING_OUT);
}

static bool is_closed(const watertight *w, const trace_block *block, unsigned lane) {
    uint32_t geometry = block->hits.geometry[lane];
    return geometry < TRACE_PLANE && w->facings[geometry] != FACING_NONE;
}

watertight_sides watertight_sides_of(const watertight *w, const trace_block *block, unsigned lane,
                                     uint8_t depth) {
    watertight_sides sides = {depth, depth};
    if (!is_closed(w, block, lane)) return sides;
    if (!leaves(w, block, lane)) {
        sides.behind = (uint8_t)(depth < WATERTIGHT_DEEPEST ? depth + 1 : depth);
    } else {
        sides.before = depth > 0 ? depth : 1;
        sides.behind = (uint8_t)(sides.before - 1);
    }
    return sides;
}

/* Whether any lane's ray meets the back of what it meets, closed or not; loops that vectorise. */
static inline __attribute__((always_inline)) bool any_back_body(const watertight *w, const trace_block *block,
                                                                unsigned lanes) {
    const trace_rays *r = &block->rays;
    const trace_hits *h = &block->hits;
    int placed = 0, back = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float along = h->ng_x[i] * r->dir_x[i] + h->ng_y[i] * r->dir_y[i] + h->ng_z[i] * r->dir_z[i];
        int met = h->geometry[i] != FATHOM_NONE, moved = h->instance[i] != FATHOM_NONE;
        placed |= met & moved;
        back |= met & !(moved & w->turned) & (along > 0);
    }
    if (back || !placed || !w->turned) return back != 0;
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t instance = h->instance[i];
        if (h->geometry[i] == FATHOM_NONE || instance == FATHOM_NONE) continue;
        if (i && instance == h->instance[i - 1]) continue; /* neighbours meet the same one as a rule */
        float along[TRACE_WIDTH];
        along_in(w->tracer->world, instance, block, along);
        for (unsigned k = 0; k < TRACE_WIDTH; ++k) back |= (h->instance[k] == instance) & (along[k] > 0);
    }
    return back != 0;
}

static bool any_back(const watertight *w, const trace_block *block, unsigned lanes) {
    return lanes == TRACE_WIDTH ? any_back_body(w, block, TRACE_WIDTH) : any_back_body(w, block, lanes);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) static bool any_back_avx2(const watertight *w, const trace_block *block,
                                                          unsigned lanes) {
    return lanes == TRACE_WIDTH ? any_back_body(w, block, TRACE_WIDTH) : any_back_body(w, block, lanes);
}
__attribute__((target("avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512"))) static bool
any_back_avx512(const watertight *w, const trace_block *block, unsigned lanes) {
    return lanes == TRACE_WIDTH ? any_back_body(w, block, TRACE_WIDTH) : any_back_body(w, block, lanes);
}
#endif

/* It only decides whether to look closer, so that instructions differ changes nothing. */
static void choose_any_back(watertight *w) {
#if defined(__x86_64__)
    bool wide = __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                __builtin_cpu_supports("avx512vl");
    w->any_back = wide ? any_back_avx512 : (__builtin_cpu_supports("avx2") ? any_back_avx2 : any_back);
#else
    w->any_back = any_back;
#endif
}

/* From outside, no ray meets the back of a closed mesh first. */
static unsigned backs(const watertight *w, const trace_block *block, unsigned lanes) {
    unsigned found = 0;
    if (!w->inward && !w->any_back(w, block, lanes)) return 0;
    for (unsigned i = 0; i < lanes; ++i) {
        if (is_closed(w, block, i)) found |= (unsigned)leaves(w, block, i) << i;
    }
    return found;
}

/* From inside, every ray meets something in the box. */
static unsigned escapes(const watertight *w, const trace_block *block, unsigned lanes) {
    const trace_rays *r = &block->rays;
    unsigned found = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float t = r->t_far[i], x = r->org_x[i] + t * r->dir_x[i], y = r->org_y[i] + t * r->dir_y[i],
              z = r->org_z[i] + t * r->dir_z[i];
        int in_box = (x >= w->lower.x) & (x <= w->upper.x) & (y >= w->lower.y) & (y <= w->upper.y) &
                     (z >= w->lower.z) & (z <= w->upper.z);
        found |= (unsigned)!((block->hits.geometry[i] != FATHOM_NONE) & in_box) << i;
    }
    return found;
}

/* The lanes, as bits, whose answer cannot be right. */
static unsigned wrong_lanes(const watertight *w, const trace_block *block, const uint8_t *depth,
                            unsigned lanes) {
    static const uint8_t outside[TRACE_WIDTH];
    if (memcmp(depth, outside, lanes) == 0) return backs(w, block, lanes);
    unsigned inside = 0;
    for (unsigned i = 0; i < lanes; ++i) inside |= (unsigned)(depth[i] != 0) << i;
    return (escapes(w, block, lanes) & inside) | (backs(w, block, lanes) & ~inside);
}

/* Rounds of looking around a ray, at 2^-20 to 2^-6 of the distance. Where the back of a mesh was met from
 * outside and the first few find nothing nearer, it may be right after all: the mesh has parts that face
 * different ways. */
#define ROUNDS 8
#define ROUNDS_OUTSIDE 4

unsigned watertight_closest(const watertight *w, trace_block *block, const uint8_t depth[TRACE_WIDTH],
                            unsigned lanes) {
    unsigned changed = 0, wrong = wrong_lanes(w, block, depth, lanes);
    for (unsigned k = 0; wrong && k < ROUNDS; ++k) {
        for (unsigned i = 0; i < lanes; ++i) {
            bool again = wrong >> i & 1 && (depth[i] || k < ROUNDS_OUTSIDE);
            if (again && w->tracer->retry->closest(w->tracer, block, i, k)) changed |= 1u << i;
        }
        wrong &= wrong_lanes(w, block, depth, lanes);
    }
    return (unsigned)__builtin_popcount(changed);
}

unsigned watertight_any(const watertight *w, trace_rays *rays, const uint8_t depth[TRACE_WIDTH],
                        uint8_t there, unsigned lanes) {
    unsigned changed = 0;
    if (!w->shadows) return 0;
    for (unsigned i = 0; i < lanes; ++i) {
        if (depth[i] == there || rays->t_far[i] < 0) continue;
        unsigned k = 0;
        while (k < ROUNDS && !w->tracer->retry->any(w->tracer, rays, i, k)) ++k;
        changed += k < ROUNDS;
    }
    return changed;
}

/* ---- life ---- */

/* Whether normals in the instance's space stand to the world's rays as they do to its own. */
static bool is_straight(const world_instance *instance) {
    const float(*m)[4] = instance->to_object;
    bool diagonal =
        m[0][1] == 0 && m[0][2] == 0 && m[1][0] == 0 && m[1][2] == 0 && m[2][0] == 0 && m[2][1] == 0;
    return diagonal && m[0][0] > 0 && m[1][1] == m[0][0] && m[2][2] == m[0][0];
}

static bool is_turned(const watertight *w, const world_instance *instance) {
    const world_group *group = &w->tracer->world->groups.items[instance->group];
    bool closed = false;
    for (uint32_t i = 0; i < group->count; ++i) closed |= w->facings[group->first + i] != FACING_NONE;
    return closed && !is_straight(instance);
}

static bool any_facing(watertight *w) {
    const world *scene = w->tracer->world;
    bool any = false;
    w->shadows = true;
    for (size_t i = 0; i < scene->geometries.count; ++i) {
        if (w->facings[i] == FACING_NONE) continue;
        any = true;
        w->inward |= w->facings[i] == FACING_IN;
        w->shadows &= !(scene->geometries.items[i].flags & FATHOM_CASTS_NO_SHADOW);
    }
    for (size_t k = 0; k < scene->instances.count && !w->turned; ++k)
        w->turned = is_turned(w, &scene->instances.items[k]);
    return any;
}

/* A little wider: it only decides whether to look again. */
static void set_box(watertight *w) {
    w->tracer->retry->bounds(w->tracer, 0, &w->lower, &w->upper);
    vec3_f32 margin = scale_f32(0x1p-10f, sub_f32(w->upper, w->lower));
    w->lower = sub_f32(w->lower, margin), w->upper = add_f32(w->upper, margin);
}

static bool has_mesh(const world *w) {
    for (size_t i = 0; i < w->geometries.count; ++i) {
        if (w->geometries.items[i].kind == WORLD_MESH) return true;
    }
    return false;
}

fathom_status watertight_create(fathom_context *context, const trace_tracer *tracer, bool always,
                                watertight **out) {
    const world *scene = tracer->world;
    *out = NULL;
    if (!tracer->retry || !(always || has_mesh(scene))) return FATHOM_OK;
    watertight *w = calloc(1, sizeof *w);
    closed_how *closed = calloc(scene->geometries.count + 1, sizeof *closed);
    facing *facings = calloc(scene->geometries.count + 1, sizeof *facings);
    bool fine = w && closed && facings;
    if (fine) {
        *w = (watertight){.tracer = tracer, .facings = facings};
        fine = closed_find(scene, closed) && find_facings(w, closed);
    }
    free(closed);
    if (fine && (any_facing(w) || always)) {
        set_box(w);
        choose_any_back(w);
        *out = w;
        return FATHOM_OK;
    }
    free(facings);
    free(w);
    return fine ? FATHOM_OK : fail_memory(context, scene->geometries.count * sizeof *facings);
}

void watertight_destroy(watertight *w) {
    if (!w) return;
    free(w->facings);
    free(w);
}
