#include "trace/watertight/bodies.h"
#include "scene/mesh/closed.h"
#include "trace/search.h"

#include <stdlib.h>

/* Maximum number of pieces of one mesh, or spheres or quads of one run, that get their own bodies. Above it,
 * all of them are one vague body. */
#define PIECES_MOST 256
/* Maximum number of vertices of a mesh with duplicate vertices along seams: each is looked up by position, in
 * about 50 ns. */
#define DOUBLES_MOST ((uint32_t)1 << 20)

const float bodies_probes[BODIES_PROBES][3] = {{0.5773f, 0.2113f, 0.7886f},
                                               {-0.3187f, 0.8361f, 0.4464f},
                                               {0.1741f, -0.6327f, 0.7545f},
                                               {-0.7071f, -0.4937f, 0.5062f},
                                               {0.9129f, -0.1277f, -0.3877f}};

/* ---- points on surfaces ---- */

static vec3_f32 between_f32(vec3_f32 o, vec3_f32 a, vec3_f32 b, float s, float t) {
    return madd_f32(madd_f32(o, s, sub_f32(a, o)), t, sub_f32(b, o));
}

vec3_f32 finder_point(const world *w, const sample *at, unsigned k) {
    const world_geometry *g = &w->geometries.items[at->geometry];
    float s = fmodf(0.5f + 0.618f * (float)k, 1), t = ((float)k + 0.5f) / SAMPLES;
    if (g->kind == WORLD_SPHERES) {
        const world_sphere *sphere = &w->spheres.items[g->first + at->primitive];
        float sign = k < BODIES_PROBES ? 1 : -1;
        return madd_f32(sphere->center, sign * sphere->radius, load_f32(bodies_probes[k % BODIES_PROBES]));
    }
    vec3_f32 v[4];
    const bool quad = search_flat(w, g, at->primitive, v) == 4;
    if (s + t < 1) return between_f32(v[0], v[1], v[quad ? 3 : 2], s, t);
    return quad ? between_f32(v[2], v[3], v[1], 1 - s, 1 - t) : between_f32(v[0], v[1], v[2], 1 - s, 1 - t);
}

/* Samples at equal steps through the primitives. */
static void set_samples(finder *f, uint32_t geometry, uint32_t body, uint32_t first, uint32_t count) {
    for (uint32_t k = 0; k < SAMPLES; ++k)
        f->samples[body][k] = (sample){geometry, first + (uint32_t)((uint64_t)k * count / SAMPLES)};
}

/* Samples for every piece of a mesh, at equal steps through its triangles. */
static void set_piece_samples(finder *f, uint32_t geometry) {
    const geometry_bodies *of = &f->out->of[geometry];
    const fathom_mesh *mesh = world_mesh(f->world, geometry);
    uint32_t sizes[PIECES_MOST] = {0}, seen[PIECES_MOST] = {0};
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) ++sizes[pieces_of(of->of_vertex, mesh, i)];
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t piece = pieces_of(of->of_vertex, mesh, i), n = seen[piece]++;
        for (uint32_t k = 0; k < SAMPLES; ++k)
            if (n == (uint64_t)k * sizes[piece] / SAMPLES)
                f->samples[of->first + piece][k] = (sample){geometry, i};
    }
}

/* ---- finding bodies ---- */

/* Sets all fields of the geometry's bodies except `first`. False when out of memory. */
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

/* Numbers the bodies geometry by geometry. Geometries of a group that are only closed together form one
 * body. */
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
        if (of->of_vertex)
            set_piece_samples(f, g);
        else if (of->count == 1)
            set_samples(f, g, of->first, 0, f->world->geometries.items[g].count);
        else
            for (uint32_t k = 0; k < of->count; ++k) set_samples(f, g, of->first + k, k, 1);
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

/* ---- facing ---- */

/* Where the ray crosses the body first, it enters: 1, leaves: -1, or both: 0. Two sheets back to back in one
 * place enclose nothing, and rounding decides which of them comes first. 0 also if there is no crossing. */
static int first_crossing(const finder *f, uint32_t body) {
    float first[2] = {INFINITY, INFINITY};
    for (size_t i = 0; i < f->room.count; ++i) {
        const trace_crossing *c = &f->room.items[i];
        if (finder_body(f, c->geometry, c->primitive) != body) continue;
        first[c->entering] = fminf(first[c->entering], c->t);
    }
    return (first[1] * SEARCH_BACK < first[0]) - (first[0] * SEARCH_BACK < first[1]);
}

/* The first crossing of a ray from far outside enters the body: the majority of the probes decides its
 * facing. */
static bool find_facing(finder *f, uint32_t group, uint32_t body) {
    vec3_f32 lower, upper;
    int out = 0;
    f->retry->bounds(f->out->tracer->self, group, &lower, &upper);
    float size = length_f32(sub_f32(upper, lower));
    for (unsigned k = 0; k < BODIES_PROBES; ++k) {
        vec3_f32 dir = load_f32(bodies_probes[k]);
        vec3_f32 org = madd_f32(finder_point(f->world, &f->samples[body][k], k), -2 * size, dir);
        if (!f->retry->crossings(f->out->tracer->self, group, org, dir, &f->room)) return false;
        out += first_crossing(f, body);
    }
    f->out->all[body].facing = out > 0 ? FACING_OUT : (out < 0 ? FACING_IN : FACING_NONE);
    return true;
}

static bool find_facings(finder *f) {
    const world *w = f->world;
    for (uint32_t group = 0; group < w->groups.count; ++group) {
        uint32_t first = w->groups.items[group].first, end = first + w->groups.items[group].count;
        for (uint32_t g = first; g < end; ++g) {
            geometry_bodies *of = &f->out->of[g];
            if (f->closed[g] == CLOSED_NOT || !w->geometries.items[g].count) continue;
            for (uint32_t k = of->first; k < of->first + of->count; ++k) {
                if (f->out->all[k].facing == FACING_NONE && !find_facing(f, group, k)) return false;
                of->closed |= f->out->all[k].facing != FACING_NONE;
            }
        }
    }
    return true;
}

/* ---- around a point ---- */

int bodies_step_out(const bodies *b, const trace_crossing *c) {
    facing face = bodies_at(b, c->geometry, c->primitive)->facing;
    if (face == FACING_NONE) return 0;
    return c->entering == (face == FACING_OUT) ? -1 : 1;
}

body_counts bodies_around(const bodies *b, const trace_crossings *list) {
    body_counts counts = {0, 0};
    for (size_t i = 0; i < list->count; ++i) {
        const trace_crossing *c = &list->items[i];
        int *count = bodies_at(b, c->geometry, c->primitive)->casts ? &counts.casting : &counts.other;
        *count += bodies_step_out(b, c);
    }
    return counts;
}

/* ---- life ---- */

static bool any_closed(const finder *f) {
    for (size_t i = 0; i < f->world->geometries.count; ++i)
        if (f->closed[i] != CLOSED_NOT) return true;
    return false;
}

bool bodies_find(const trace_tracer *tracer, bodies *out) {
    const world *w = tracer->world;
    *out = (bodies){.tracer = tracer};
    finder f = {.out = out, .world = w, .retry = tracer->retry};
    const bool few = w->instances.count <= LOOKS_MOST;
    out->of = calloc(w->geometries.count + 1, sizeof *out->of);
    f.closed = calloc(w->geometries.count + 1, sizeof *f.closed);
    if (few) out->around = calloc(w->instances.count + 1, sizeof *out->around);
    bool fine = out->of && f.closed && (out->around || !few) && closed_find(w, f.closed);
    if (fine && any_closed(&f)) {
        fine = number_bodies(&f);
        if (fine) sample_bodies(&f), find_casts(&f);
        fine = fine && find_facings(&f) && finder_around(&f);
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
