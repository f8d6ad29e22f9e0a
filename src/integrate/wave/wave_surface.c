/* Converts hits to path vertices: points, materials, and the state of the paths. */
#include "integrate/wave/wave.h"

#include <string.h>

/* The block of vertices that is currently filled. */
static vertex_block *open_block(const wave *w) {
    return &w->vertices[w->stages->leave ? 0 : w->vertex_count / LANES];
}

fathom_id wave_hit_material(const wave *w, unsigned i) {
    return surface_gather_material(w->gather, w->run.plan->world, i);
}

fathom_id wave_hit_object(const wave *w, unsigned i) {
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    if (g->geometry[i] == TRACE_PLANE) return scene->planes.items[g->primitive[i]].object;
    return world_object(scene, g->geometry[i], g->primitive[i]);
}

/* The camera sees what the ray in this slot hits: AOVs are of that hit. first: of the camera's rays. */
static bool in_view(const wave *w, uint32_t slot, bool first) {
    return first || (w->passing && w->stages->in_view(w, slot));
}

static void keep_miss(first_hits *f, uint32_t slot) {
    f->alpha[slot] = 0;
    f->z[slot] = INFINITY;
    for (int c = 0; c < 3; ++c) f->n[c][slot] = f->p[c][slot] = f->albedo[c][slot] = 0;
    for (int c = 0; c < 4; ++c) f->motion[c][slot] = 0;
    f->object[slot] = f->primitive[slot] = f->instance[slot] = FATHOM_NONE;
}

fathom_id wave_hit_instance(const wave *w, unsigned i) {
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    if (g->geometry[i] == TRACE_PLANE) return FATHOM_NONE;
    return g->instance[i] != FATHOM_NONE ? scene->instances.items[g->instance[i]].id
                                         : scene->geometries.items[g->geometry[i]].instance;
}

/* The shading normal of lane i of the gathered hits, facing the ray's origin. */
static vec3_f32 hit_normal(const wave *w, const vertex_block *v, unsigned i) {
    const local_block *b = &w->gather->local;
    const vec3_f32 dir = {b->ray[0][i], b->ray[1][i], b->ray[2][i]};
    const vec3_f32 ng = {(float)b->n[0][i], (float)b->n[1][i], (float)b->n[2][i]};
    vec3_f32 ns = {b->ns[0][i], b->ns[1][i], b->ns[2][i]};
    if (v->surface.mapped >> i & 1)
        ns = (vec3_f32){v->surface.ns[0][i], v->surface.ns[1][i], v->surface.ns[2][i]};
    return dot_f32(ns, ng) * dot_f32(ng, dir) < 0 ? ns : neg_f32(ns);
}

void wave_keep_features(wave *w, const vertex_block *v, unsigned i, const float tint[3]) {
    first_hits *f = w->run.samples.first;
    const bool path = w->run.plan->shaders != NULL;
    const uint32_t slot = v->path.slot[i];
    const vec3_f32 n = hit_normal(w, v, i);
    f->n[0][slot] = n.x, f->n[1][slot] = n.y, f->n[2][slot] = n.z;
    for (int c = 0; c < 3; ++c)
        f->albedo[c][slot] =
            tint[c] * (path ? v->shader.at[i]->albedo[c] : v->bsdf.k_d[c][i] + v->bsdf.k_s[c][i]);
}

/* Keeps lane i of the gathered hits for the AOVs. */
static void keep_first(wave *w, unsigned i, uint32_t slot) {
    static const float white[3] = {1, 1, 1};
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    const local_block *b = &g->local;
    first_hits *f = w->run.samples.first;
    const bool plane = g->geometry[i] == TRACE_PLANE;
    const vec3_f64 p = {b->p[0][i], b->p[1][i], b->p[2][i]},
                   from_eye = sub_f64(p, plan_eye(w->run.plan, &w->run.plan->camera));
    f->alpha[slot] = 1;
    f->z[slot] = (float)dot_f64(from_eye, w->run.plan->camera.view);
    f->p[0][slot] = (float)(p.x + scene->origin.x);
    f->p[1][slot] = (float)(p.y + scene->origin.y);
    f->p[2][slot] = (float)(p.z + scene->origin.z);
    wave_keep_features(w, open_block(w), i, white);
    for (int c = 0; c < 4; ++c) f->motion[c][slot] = 0;
    if (w->cameras) wave_keep_vectors(w, i, slot);
    f->object[slot] = wave_hit_object(w, i);
    f->primitive[slot] = plane ? 0 : world_primitive(scene, g->geometry[i], g->primitive[i]);
    f->instance[slot] = wave_hit_instance(w, i);
}

/* Transmission takes a path to the other side, as do the backs of one-sided surfaces in view. */
static bool may_cross(const wave *w, uint32_t slot) {
    return w->run.plan->crosses || (wave_looks_through(w) && w->stages->in_view(w, slot));
}

static void note_depths(const wave *w, const trace_block *block, const path_block *path, size_t lane,
                        vertex_block *v, unsigned i) {
    watertight_sides sides = {path->depth[lane], path->depth[lane]};
    if (may_cross(w, path->slot[lane]))
        sides = watertight_sides_of(w->run.plan->watertight, block, (unsigned)lane, path->depth[lane]);
    v->path.depth[i] = sides.before;
    v->depth_behind[i] = sides.behind;
}

static void note_all_depths(const wave *w, const trace_block *block, const path_block *path,
                            vertex_block *v) {
    if (w->run.plan->crosses || wave_looks_through(w)) {
        for (unsigned i = 0; i < LANES; ++i) note_depths(w, block, path, i, v, i);
    } else {
        memcpy(v->path.depth, path->depth, sizeof v->path.depth);
        memcpy(v->depth_behind, path->depth, sizeof v->depth_behind);
    }
}

/* Adds a hit to the block of vertices that is currently filled. */
static void add_hit(wave *w, const trace_block *block, const path_block *path, size_t lane) {
    vertex_block *v = open_block(w);
    unsigned i = w->gather->count;
    surface_gather_add(w->gather, w->run.plan->world, block, lane);
    for (int c = 0; c < 3; ++c) v->path.weight[c][i] = path->weight[c][lane];
    v->path.slot[i] = path->slot[lane];
    v->surface.material[i] = wave_hit_material(w, i);
    if (w->run.plan->watertight) note_depths(w, block, path, lane, v, i);
}

/* The unused lanes of the last block repeat its last point, so that stages may compute all 16. */
static void pad(vertex_block *v) {
    for (size_t last = v->surface.count - 1, i = v->surface.count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) v->path.weight[c][i] = v->path.weight[c][last];
        v->path.slot[i] = v->path.slot[last];
        v->surface.material[i] = v->surface.material[last];
    }
}

static void keep_view(wave *w, const vertex_block *v, bool first) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        if (!in_view(w, slot, first)) continue;
        if (w->run.samples.first) keep_first(w, i, slot);
        if (w->run.samples.mattes) wave_keep_mattes(w, slot, i);
    }
}

static void end_block(wave *w, bool first) {
    const render_plan *plan = w->run.plan;
    vertex_block *v = open_block(w);
    surface_block *s = &v->surface;
    if (!w->gather->count) return;
    s->count = w->gather->count;
    surface_gather_end(w->gather, plan->world, plan->surface_kernels, plan->lifts,
                       !(plan->settings.epsilon > 0), s);
    pad(v);
    w->stages->vertices(w, v);
    if (w->run.samples.first || w->run.samples.mattes) keep_view(w, v, first);
    if (w->stages->leave) w->stages->leave(w, v);
    w->vertex_count += s->count;
    surface_gather_begin(w->gather);
}

static void add_hits(wave *w, const trace_block *block, const path_block *path, uint32_t met, bool first) {
    for (; met; met &= met - 1) {
        add_hit(w, block, path, (size_t)__builtin_ctz(met));
        if (w->gather->count == LANES) end_block(w, first);
    }
}

static void find_materials(const wave *w, bool one, surface_block *s) {
    fathom_id first = wave_hit_material(w, 0);
    for (unsigned i = 0; i < LANES; ++i) s->material[i] = first;
    for (unsigned i = 1; !one && i < LANES; ++i) s->material[i] = wave_hit_material(w, i);
}

/* A block whose rays all hit something becomes a block of vertices directly. */
static void add_block(wave *w, const trace_block *block, const path_block *path, bool first) {
    vertex_block *v = open_block(w);
    bool one_object =
        surface_gather_block(w->gather, w->run.plan->world, w->run.plan->surface_kernels, block);
    memcpy(v->path.weight, path->weight, sizeof v->path.weight);
    memcpy(v->path.slot, path->slot, sizeof v->path.slot);
    find_materials(w, one_object, &v->surface);
    if (w->run.plan->watertight) note_all_depths(w, block, path, v);
    end_block(w, first);
}

static uint32_t lanes_in_view(const wave *w, const path_block *path, uint32_t lanes, bool first) {
    if (first) return lanes;
    uint32_t seen = 0;
    for (uint32_t left = w->passing ? lanes : 0; left; left &= left - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(left);
        if (in_view(w, path->slot[lane], first)) seen |= 1u << lane;
    }
    return seen;
}

/* An image with an alpha channel is composited later: its colours are premultiplied and exclude the
 * background. Mirrors and glass still show the background. */
static void add_misses(wave *w, const trace_block *block, const path_block *path, uint32_t missed,
                       bool first) {
    const bool alpha = w->run.plan->settings.aovs & FATHOM_AOV_ALPHA;
    const bool wanted = alpha || w->run.samples.first;
    uint32_t seen = wanted ? lanes_in_view(w, path, missed, first) : 0;
    const uint32_t shown = alpha ? missed & ~seen : missed;
    if (shown && w->run.plan->background) w->stages->misses(w, block, path, shown);
    for (; w->run.samples.first && seen; seen &= seen - 1) {
        const unsigned lane = (unsigned)__builtin_ctz(seen);
        keep_miss(w->run.samples.first, path->slot[lane]);
        if (w->cameras) wave_keep_far_vectors(w, trace_dir(&block->rays, lane), path->slot[lane]);
    }
}

/* Prefetch distance in blocks, from indices to vertices and from vertices to their use; bench/README.md has
 * times for other distances. */
#define ASK_AHEAD 4

static void ask_ahead(const wave *w, size_t done) {
    const trace_block *block = &w->now.rays[done / LANES];
    const size_t left = (w->now.count - done - 1) / LANES; /* blocks after this one */
    if (left >= 2 * ASK_AHEAD) surface_ask_indices(w->run.plan->world, &block[2 * ASK_AHEAD].hits);
    if (left >= ASK_AHEAD) surface_ask_corners(w->run.plan->world, &block[ASK_AHEAD].hits);
}

/* Whole blocks stay together. Partial blocks of camera rays are deferred, because each camera ray has a
 * sample of its own; for other rays the order is kept, because light is added in that order. */
bool wave_surfaces(wave *w, bool first) {
    const uint32_t whole = (1u << LANES) - 1;
    uint32_t partial = 0;
    w->vertex_count = 0;
    if (!wave_reserve_vertices(w, w->stages->leave ? LANES : w->now.count)) return false;
    surface_gather_begin(w->gather);
    for (size_t done = 0; done < w->now.count; done += LANES) {
        const trace_block *block = &w->now.rays[done / LANES];
        const path_block *path = &w->now.paths[done / LANES];
        uint32_t lanes = (1u << wave_lanes(w->now.count, done)) - 1,
                 met = w->run.plan->kernels->met(&block->hits) & lanes;
        ask_ahead(w, done);
        if (met != lanes) add_misses(w, block, path, lanes & ~met, first);
        if (met == whole && !w->gather->count)
            add_block(w, block, path, first);
        else if (met && first)
            w->partial[partial++] = (uint32_t)(done / LANES);
        else if (met)
            add_hits(w, block, path, met, first);
    }
    for (uint32_t i = 0; i < partial; ++i) {
        const trace_block *block = &w->now.rays[w->partial[i]];
        uint32_t lanes = (1u << wave_lanes(w->now.count, w->partial[i] * (size_t)LANES)) - 1;
        add_hits(w, block, &w->now.paths[w->partial[i]], w->run.plan->kernels->met(&block->hits) & lanes,
                 first);
    }
    end_block(w, first);
    return true;
}
