#include "trace/bodies.h"

#include "scene/closed.h"
#include "scene/pieces.h"
#include "trace/search.h"

#include <stdlib.h>

/* Pieces of one mesh, spheres or quads of one run, that are told apart. Beyond, all are one body, around
 * which any number may lie. */
#define PIECES_MOST 256
/* Vertices of a mesh that shares none along its seams: each is looked up by position, at some 50 ns. */
#define DOUBLES_MOST ((uint32_t)1 << 20)
/* Bodies and instances whose surroundings are looked at, a few microseconds each. */
#define LOOKS_MOST 1024
/* Points on each. */
#define SAMPLES 8

const float bodies_probes[BODIES_PROBES][3] = {{0.5773f, 0.2113f, 0.7886f},
                                               {-0.3187f, 0.8361f, 0.4464f},
                                               {0.1741f, -0.6327f, 0.7545f},
                                               {-0.7071f, -0.4937f, 0.5062f},
                                               {0.9129f, -0.1277f, -0.3877f}};

static const depth_span anything = {0, BODIES_ANY};

/* ---- points on surfaces ---- */

typedef struct sample {
    uint32_t geometry, primitive;
} sample;

typedef struct owned_box {
    body_box box;
    uint32_t owner; /* a geometry, or an instance: these count on after all geometries */
} owned_box;

typedef struct finder {
    bodies *out;
    const world *world;
    const trace_retry *retry;
    closed_how *closed;         /* by geometry */
    sample (*samples)[SAMPLES]; /* by body */
    ARRAY(owned_box) boxes;     /* around closed bodies of the group at hand */
    unsigned looks;
    trace_crossings room;
} finder;

static vec3_f32 between_f32(vec3_f32 o, vec3_f32 a, vec3_f32 b, float s, float t) {
    return madd_f32(madd_f32(o, s, sub_f32(a, o)), t, sub_f32(b, o));
}

/* The k-th point on the sample's surface, spread over it. */
static vec3_f32 point_of(const world *w, const sample *at, unsigned k) {
    const world_geometry *g = &w->geometries.items[at->geometry];
    float s = fmodf(0.5f + 0.618f * (float)k, 1), t = ((float)k + 0.5f) / SAMPLES;
    switch (g->kind) {
    case WORLD_SPHERES: {
        const world_sphere *sphere = &w->spheres.items[g->first + at->primitive];
        float sign = k < BODIES_PROBES ? 1 : -1;
        return madd_f32(sphere->center, sign * sphere->radius, load_f32(bodies_probes[k % BODIES_PROBES]));
    }
    case WORLD_QUADS: {
        const vec3_f32 *c = w->quads.items[g->first + at->primitive].corner;
        return s + t < 1 ? between_f32(c[0], c[1], c[3], s, t) : between_f32(c[2], c[3], c[1], 1 - s, 1 - t);
    }
    case WORLD_MESH: break;
    }
    vec3_f32 v[3];
    search_corners(world_mesh(w, at->geometry), at->primitive, v);
    return s + t < 1 ? between_f32(v[0], v[1], v[2], s, t) : between_f32(v[0], v[1], v[2], 1 - s, 1 - t);
}

/* The same share of primitives between one sample and the next. */
static void set_samples(finder *f, uint32_t geometry, uint32_t body, uint32_t first, uint32_t count) {
    for (uint32_t k = 0; k < SAMPLES; ++k)
        f->samples[body][k] = (sample){geometry, first + (uint32_t)((uint64_t)k * count / SAMPLES)};
}

/* Triangles of every piece. */
static void set_piece_samples(finder *f, uint32_t geometry) {
    const geometry_bodies *of = &f->out->of[geometry];
    const fathom_mesh *mesh = world_mesh(f->world, geometry);
    uint32_t sizes[PIECES_MOST] = {0}, seen[PIECES_MOST] = {0};
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) ++sizes[pieces_of(of->of_vertex, mesh, i)];
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t piece = pieces_of(of->of_vertex, mesh, i), n = seen[piece]++;
        for (uint32_t k = 0; k < SAMPLES; ++k) {
            if (n == (uint64_t)k * sizes[piece] / SAMPLES)
                f->samples[of->first + piece][k] = (sample){geometry, i};
        }
    }
}

/* ---- what bodies there are ---- */

/* Sets of what but `first`. */
static bool split_geometry(finder *f, uint32_t geometry) {
    const world_geometry *g = &f->world->geometries.items[geometry];
    geometry_bodies *of = &f->out->of[geometry];
    of->count = 1;
    if (g->kind != WORLD_MESH) {
        of->vague = g->count > PIECES_MOST;
        if (!of->vague) of->count = g->count;
        return true;
    }
    of->vague = f->closed[geometry] == CLOSED_TOGETHER;
    if (f->closed[geometry] != CLOSED_ALONE) return true;
    pieces found;
    bool doubled = f->world->mesh_facts.items[g->first].boundary != 0;
    of->vague = doubled && world_mesh(f->world, geometry)->vertex_count > DOUBLES_MOST;
    if (of->vague) return true;
    unsigned threads = fathom_context_threads(f->world->scene->context);
    if (!pieces_find(threads, world_mesh(f->world, geometry), doubled, PIECES_MOST, &found)) return false;
    of->vague = !found.count;
    if (found.count) of->count = found.count;
    of->of_vertex = found.of_vertex;
    return true;
}

/* Bodies are numbered by geometry; those of a group that are closed together are one. */
static bool number_bodies(finder *f) {
    const world *w = f->world;
    bodies *b = f->out;
    for (uint32_t group = 0; group < w->groups.count; ++group) {
        uint32_t first = w->groups.items[group].first, end = first + w->groups.items[group].count;
        uint32_t together = FATHOM_NONE;
        for (uint32_t g = first; g < end; ++g) {
            if (!split_geometry(f, g)) return false;
            bool joins = f->closed[g] == CLOSED_TOGETHER && together != FATHOM_NONE;
            b->of[g].first = joins ? together : (uint32_t)b->count;
            if (f->closed[g] == CLOSED_TOGETHER) together = b->of[g].first;
            if (!joins) b->count += b->of[g].count;
        }
    }
    b->all = calloc(b->count + 1, sizeof *b->all);
    f->samples = calloc(b->count + 1, sizeof *f->samples);
    return b->all && f->samples;
}

static void sample_bodies(finder *f) {
    for (uint32_t g = 0; g < f->world->geometries.count; ++g) {
        const geometry_bodies *of = &f->out->of[g];
        if (of->of_vertex) {
            set_piece_samples(f, g);
        } else if (of->count == 1) {
            set_samples(f, g, of->first, 0, f->world->geometries.items[g].count);
        } else {
            for (uint32_t k = 0; k < of->count; ++k) set_samples(f, g, of->first + k, k, 1);
        }
    }
}

static void find_casts(finder *f) {
    for (size_t i = 0; i < f->out->count; ++i) f->out->all[i].casts = true;
    for (size_t g = 0; g < f->world->geometries.count; ++g) {
        const geometry_bodies *of = &f->out->of[g];
        if (!(f->world->geometries.items[g].flags & FATHOM_CASTS_NO_SHADOW)) continue;
        for (uint32_t k = 0; k < of->count; ++k) f->out->all[of->first + k].casts = false;
    }
}

/* ---- what faces out ---- */

static uint32_t body_of(const finder *f, uint32_t geometry, uint32_t primitive) {
    return (uint32_t)(bodies_at(f->out, geometry, primitive) - f->out->all);
}

/* The nearest crossing of the body; NULL: none. */
static const trace_crossing *first_crossing(const finder *f, uint32_t body) {
    const trace_crossing *first = NULL;
    for (size_t i = 0; i < f->room.count; ++i) {
        const trace_crossing *c = &f->room.items[i];
        if (body_of(f, c->geometry, c->primitive) == body && (!first || c->t < first->t)) first = c;
    }
    return first;
}

/* The first crossing from far outside goes in: most of the probes decide. */
static bool find_facing(finder *f, uint32_t group, uint32_t body) {
    vec3_f32 lower, upper;
    int out = 0;
    f->retry->bounds(f->out->tracer, group, &lower, &upper);
    float size = length_f32(sub_f32(upper, lower));
    for (unsigned k = 0; k < BODIES_PROBES; ++k) {
        vec3_f32 dir = load_f32(bodies_probes[k]);
        vec3_f32 org = madd_f32(point_of(f->world, &f->samples[body][k], k), -2 * size, dir);
        if (!f->retry->crossings(f->out->tracer, group, org, dir, &f->room)) return false;
        const trace_crossing *first = first_crossing(f, body);
        if (first) out += first->entering ? 1 : -1;
    }
    f->out->all[body].facing = out > 0 ? FACING_OUT : (out < 0 ? FACING_IN : FACING_NONE);
    return true;
}

static bool find_facings(finder *f) {
    const world *w = f->world;
    for (uint32_t group = 0; group < w->groups.count; ++group) {
        uint32_t first = w->groups.items[group].first, end = first + w->groups.items[group].count;
        for (uint32_t g = first; g < end; ++g) {
            const geometry_bodies *of = &f->out->of[g];
            if (f->closed[g] == CLOSED_NOT || !w->geometries.items[g].count) continue;
            for (uint32_t k = 0; k < of->count; ++k) {
                if (f->out->all[of->first + k].facing == FACING_NONE && !find_facing(f, group, of->first + k))
                    return false;
            }
        }
    }
    return true;
}

/* ---- what lies around them ---- */

static int step_out(const bodies *b, const trace_crossing *c) {
    facing face = bodies_at(b, c->geometry, c->primitive)->facing;
    if (face == FACING_NONE) return 0;
    return c->entering == (face == FACING_OUT) ? -1 : 1;
}

body_counts bodies_around(const bodies *b, const trace_crossings *list) {
    body_counts counts = {0, 0};
    for (size_t i = 0; i < list->count; ++i) {
        const trace_crossing *c = &list->items[i];
        int *count = bodies_at(b, c->geometry, c->primitive)->casts ? &counts.casting : &counts.other;
        *count += step_out(b, c);
    }
    return counts;
}

/* A surface whose surroundings are asked for: a body, or all that an instance places. */
typedef struct surface {
    uint32_t group, instance, body;
    vec3_f32 points[SAMPLES];
} surface;

static bool is_own(const finder *f, const surface *s, const trace_crossing *c) {
    if (s->instance != FATHOM_NONE) return c->instance == s->instance;
    return c->instance == FATHOM_NONE && body_of(f, c->geometry, c->primitive) == s->body;
}

static uint8_t clamp_depth(int depth) {
    return (uint8_t)(depth < 0 ? 0 : (depth < BODIES_ANY ? depth : BODIES_ANY));
}

/* Surfaces that all but touch the point, within 2^-10 of its body's size, may lie to either side. */
static bool look_at(finder *f, const surface *s, unsigned k, float touching, depth_span *out) {
    int low = 0, high = 0;
    vec3_f32 dir = load_f32(bodies_probes[k % BODIES_PROBES]);
    if (!f->retry->crossings(f->out->tracer, s->group, s->points[k], dir, &f->room)) return false;
    for (size_t i = 0; i < f->room.count; ++i) {
        const trace_crossing *c = &f->room.items[i];
        if (is_own(f, s, c)) continue;
        int step = step_out(f->out, c);
        if (c->t > touching || step < 0) low += step;
        if (c->t > touching || step > 0) high += step;
    }
    *out = (depth_span){clamp_depth(low), clamp_depth(high)};
    return true;
}

static bool look_around(finder *f, const surface *s, depth_span *out) {
    float size = 0;
    *out = anything;
    if (f->looks++ >= LOOKS_MOST) return true;
    for (unsigned k = 1; k < SAMPLES; ++k)
        size = fmaxf(size, length_f32(sub_f32(s->points[k], s->points[0])));
    for (unsigned k = 0; k < SAMPLES; ++k) {
        depth_span here;
        if (!look_at(f, s, k, size * 0x1p-10f, &here)) return false;
        if (k == 0) *out = here;
        out->low = here.low < out->low ? here.low : out->low;
        out->high = here.high > out->high ? here.high : out->high;
    }
    return true;
}

/* ---- boxes ---- */

static void box_add(body_box *box, vec3_f32 p) {
    box->lower = vec_f32(fminf(box->lower.x, p.x), fminf(box->lower.y, p.y), fminf(box->lower.z, p.z));
    box->upper = vec_f32(fmaxf(box->upper.x, p.x), fmaxf(box->upper.y, p.y), fmaxf(box->upper.z, p.z));
}

static body_box box_none(void) {
    return (body_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0};
}

static void box_join(body_box *box, const body_box *other) {
    box_add(box, other->lower), box_add(box, other->upper);
    box->count = clamp_depth(box->count + other->count);
}

/* A little wider: it only decides whether to look again. */
static void box_widen(body_box *box) {
    vec3_f32 margin = scale_f32(0x1p-10f, sub_f32(box->upper, box->lower));
    box->lower = sub_f32(box->lower, margin), box->upper = add_f32(box->upper, margin);
}

static bool boxes_meet(const body_box *a, const body_box *b) {
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

static vec3_f32 placed_point(const world_instance *instance, vec3_f32 p) {
    const float(*m)[4] = instance->to_world;
    return vec_f32(m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                   m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                   m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]);
}

static body_box mesh_box(const finder *f, uint32_t geometry) {
    const mesh_facts *facts = &f->world->mesh_facts.items[f->world->geometries.items[geometry].first];
    body_box box = {load_f32(facts->lower), load_f32(facts->upper), 0};
    box_widen(&box);
    return box;
}

static body_box instance_box(const finder *f, uint32_t k) {
    const world_instance *instance = &f->world->instances.items[k];
    vec3_f32 lower, upper;
    body_box box = box_none();
    f->retry->bounds(f->out->tracer, instance->group, &lower, &upper);
    if (lower.x > upper.x) return box;
    for (unsigned c = 0; c < 8; ++c) {
        box_add(&box, placed_point(instance, vec_f32(c & 1 ? lower.x : upper.x, c & 2 ? lower.y : upper.y,
                                                     c & 4 ? lower.z : upper.z)));
    }
    box_widen(&box);
    return box;
}

static uint8_t closed_bodies(const finder *f, uint32_t geometry) {
    const geometry_bodies *of = &f->out->of[geometry];
    if (f->out->all[of->first].facing == FACING_NONE) return 0;
    return of->vague ? BODIES_ANY : clamp_depth((int)of->count);
}

/* How many closed bodies a group places. */
static uint8_t group_bodies(const finder *f, uint32_t group) {
    const world_group *g = &f->world->groups.items[group];
    int count = 0;
    for (uint32_t i = g->first; i < g->first + g->count; ++i) count += closed_bodies(f, i);
    return clamp_depth(count);
}

static bool push_box(finder *f, body_box box, uint32_t owner, uint8_t count) {
    box.count = count;
    return !count || array_push(&f->boxes, ((owned_box){box, owner}));
}

/* Of the closed bodies in a group's own space. */
static bool find_boxes(finder *f, uint32_t group) {
    const world_group *g = &f->world->groups.items[group];
    const uint32_t geometries = (uint32_t)f->world->geometries.count;
    f->boxes.count = 0;
    for (uint32_t i = g->first; i < g->first + g->count; ++i) {
        if (closed_bodies(f, i) && !push_box(f, mesh_box(f, i), i, closed_bodies(f, i))) return false;
    }
    if (group || !f->out->around) return true;
    for (uint32_t k = 0; k < f->world->instances.count; ++k) {
        uint8_t count = group_bodies(f, f->world->instances.items[k].group);
        if (!push_box(f, instance_box(f, k), geometries + k, count)) return false;
    }
    return true;
}

/* Those that the root's are, for watertight.c. */
static void keep_boxes(finder *f) {
    bodies *b = f->out;
    body_box all = box_none();
    if (!b->around) {
        f->retry->bounds(b->tracer, 0, &all.lower, &all.upper);
        box_widen(&all);
        all.count = BODIES_ANY;
    }
    for (size_t i = 0; i < f->boxes.count; ++i) box_join(&all, &f->boxes.items[i].box);
    b->box_count = 1;
    b->boxes[0] = all;
    if (!b->around || f->boxes.count > BODIES_BOXES) return;
    b->box_count = (unsigned)f->boxes.count;
    for (unsigned i = 0; i < b->box_count; ++i) b->boxes[i] = f->boxes.items[i].box;
}

/* Whether closed bodies of another owner may be around it. */
static bool may_lie_in(const finder *f, const body_box *box, uint32_t owner) {
    for (size_t i = 0; i < f->boxes.count; ++i) {
        const owned_box *other = &f->boxes.items[i];
        if ((other->owner != owner || other->box.count > 1) && boxes_meet(box, &other->box)) return true;
    }
    return false;
}

/* ---- all surroundings ---- */

static body_box body_box_of(const finder *f, const sample *at) {
    const world_geometry *g = &f->world->geometries.items[at->geometry];
    body_box box = box_none();
    switch (g->kind) {
    case WORLD_MESH: return mesh_box(f, at->geometry);
    case WORLD_SPHERES: {
        const world_sphere *s = &f->world->spheres.items[g->first + at->primitive];
        const vec3_f32 r = {s->radius, s->radius, s->radius};
        box_add(&box, sub_f32(s->center, r)), box_add(&box, add_f32(s->center, r));
        break;
    }
    case WORLD_QUADS:
        for (unsigned c = 0; c < 4; ++c)
            box_add(&box, f->world->quads.items[g->first + at->primitive].corner[c]);
        break;
    }
    return box;
}

static bool find_around_body(finder *f, uint32_t group, uint32_t geometry, uint32_t k) {
    uint32_t body = f->out->of[geometry].first + k;
    const sample *samples = f->samples[body];
    surface s = {.group = group, .instance = FATHOM_NONE, .body = body};
    depth_span *around = &f->out->all[body].around;
    const body_box box = body_box_of(f, &samples[0]);
    if (!may_lie_in(f, &box, geometry)) return true; /* nothing is */
    for (unsigned i = 0; i < SAMPLES; ++i) s.points[i] = point_of(f->world, &samples[i], i);
    return look_around(f, &s, around);
}

static bool find_around_instance(finder *f, uint32_t k) {
    const world_instance *instance = &f->world->instances.items[k];
    const world_group *group = &f->world->groups.items[instance->group];
    surface s = {.instance = k};
    const body_box box = instance_box(f, k);
    if (!group->count || !may_lie_in(f, &box, (uint32_t)f->world->geometries.count + k)) return true;
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        const geometry_bodies *of = &f->out->of[group->first + i * group->count / SAMPLES];
        uint32_t body = of->first + (of->count > 1 ? i % of->count : 0);
        s.points[i] = placed_point(instance, point_of(f->world, &f->samples[body][i], i));
    }
    return look_around(f, &s, &f->out->around[k]);
}

static bool find_around(finder *f) {
    const world *w = f->world;
    bool fine = true;
    for (uint32_t group = (uint32_t)w->groups.count; group-- > 0 && fine;) {
        uint32_t first = w->groups.items[group].first, end = first + w->groups.items[group].count;
        fine = find_boxes(f, group);
        for (uint32_t g = first; g < end && fine; ++g) {
            const geometry_bodies *of = &f->out->of[g];
            if (of->vague) f->out->all[of->first].around = anything;
            for (uint32_t k = 0; k < of->count && !of->vague && w->geometries.items[g].count && fine; ++k)
                fine = find_around_body(f, group, g, k);
        }
    }
    for (uint32_t k = 0; f->out->around && k < w->instances.count && fine; ++k)
        fine = find_around_instance(f, k);
    if (fine) keep_boxes(f);
    return fine;
}

/* ---- life ---- */

static bool any_closed(const finder *f) {
    for (size_t i = 0; i < f->world->geometries.count; ++i) {
        if (f->closed[i] != CLOSED_NOT) return true;
    }
    return false;
}

bool bodies_find(const trace_tracer *tracer, bool always, bodies *out) {
    const world *w = tracer->world;
    *out = (bodies){.tracer = tracer};
    finder f = {.out = out, .world = w, .retry = tracer->retry};
    const bool few = w->instances.count <= LOOKS_MOST;
    out->of = calloc(w->geometries.count + 1, sizeof *out->of);
    f.closed = calloc(w->geometries.count + 1, sizeof *f.closed);
    if (few) out->around = calloc(w->instances.count + 1, sizeof *out->around);
    bool fine = out->of && f.closed && (out->around || !few) && closed_find(w, f.closed);
    if (fine && (always || any_closed(&f))) {
        fine = number_bodies(&f);
        if (fine) sample_bodies(&f), find_casts(&f);
        fine = fine && find_facings(&f) && find_around(&f);
    }
    free(f.closed);
    free(f.samples);
    array_free(&f.boxes);
    array_free(&f.room);
    return fine;
}

void bodies_release(bodies *b) {
    for (size_t i = 0; b->of && i < b->tracer->world->geometries.count; ++i) free(b->of[i].of_vertex);
    free(b->of);
    free(b->all);
    free(b->around);
}
