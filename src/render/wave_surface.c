/* Hits become surface points: object, world, viewer's side. */
#include "render/surface_point.h"
#include "render/wave.h"
#include "shade/limit.h"

#include <string.h>

/* Of lane i of the gathered hits. */
static fathom_id hit_material(const world *scene, const surface_gather *g, unsigned i) {
    if (g->geometry[i] == TRACE_PLANE) return scene->planes.items[g->primitive[i]].material;
    return world_material(scene, g->geometry[i], g->primitive[i], g->instance[i]);
}

static void add_background(wave *w, const path_block *path, uint32_t missed) {
    const float *background = w->plan->scene->background;
    for (; missed; missed &= missed - 1) {
        int i = __builtin_ctz(missed);
        uint32_t slot = path->slot[i];
        w->radiance[0][slot] += limited(path->weight[0][i] * background[0]);
        w->radiance[1][slot] += limited(path->weight[1][i] * background[1]);
        w->radiance[2][slot] += limited(path->weight[2][i] * background[2]);
    }
}

static void keep_miss(first_hits *f, uint32_t slot) {
    f->alpha[slot] = 0;
    f->z[slot] = INFINITY;
    for (int c = 0; c < 3; ++c) f->n[c][slot] = f->p[c][slot] = f->albedo[c][slot] = 0;
    f->object[slot] = f->primitive[slot] = f->instance[slot] = FATHOM_NONE;
}

static fathom_id placed_by(const world *scene, const surface_gather *g, unsigned i) {
    return g->instance[i] != FATHOM_NONE ? scene->instances.items[g->instance[i]].id
                                         : scene->geometries.items[g->geometry[i]].instance;
}

/* Of lane i of the gathered hits. */
static void keep_first(wave *w, unsigned i, uint32_t slot) {
    const world *scene = w->plan->world;
    const surface_gather *g = w->gather;
    const local_block *b = &g->local;
    const fathom_material *m = &w->plan->scene->materials.items[hit_material(scene, g, i)].value;
    first_hits *f = w->first;
    vec3_f32 dir = {b->ray[0][i], b->ray[1][i], b->ray[2][i]};
    bool plane = g->geometry[i] == TRACE_PLANE, specular = m->specular != FATHOM_SPECULAR_NONE;
    vec3_f64 p = {b->p[0][i], b->p[1][i], b->p[2][i]}, from_eye = sub_f64(p, widen(w->plan->camera.eye));
    vec3_f32 ng = {(float)b->n[0][i], (float)b->n[1][i], (float)b->n[2][i]};
    vec3_f32 ns = {b->ns[0][i], b->ns[1][i], b->ns[2][i]};
    if (!(dot_f32(ns, ng) * dot_f32(ng, dir) < 0)) ns = neg_f32(ns);
    const float world_p[3] = {(float)(p.x + scene->origin.x), (float)(p.y + scene->origin.y),
                              (float)(p.z + scene->origin.z)};
    const float normal[3] = {ns.x, ns.y, ns.z};
    f->alpha[slot] = 1;
    f->z[slot] = (float)dot_f64(from_eye, w->plan->camera.view);
    for (int c = 0; c < 3; ++c) {
        f->p[c][slot] = world_p[c];
        f->n[c][slot] = normal[c];
        f->albedo[c][slot] = m->k_d[c] + (specular ? m->k_s[c] : 0);
    }
    f->object[slot] = plane ? scene->planes.items[g->primitive[i]].object
                            : world_object(scene, g->geometry[i], g->primitive[i]);
    f->primitive[slot] = plane ? 0 : world_primitive(scene, g->geometry[i], g->primitive[i]);
    f->instance[slot] = plane ? FATHOM_NONE : placed_by(scene, g, i);
}

/* Only glass takes a path to the other side. */
static void note_depths(const wave *w, const trace_block *block, const path_block *path, size_t lane,
                        surface_block *s, unsigned i) {
    watertight_sides sides = {path->depth[lane], path->depth[lane]};
    if (w->plan->features & MATERIAL_REFRACT)
        sides = watertight_sides_of(w->plan->watertight, block, (unsigned)lane, path->depth[lane]);
    s->depth[i] = sides.before;
    s->depth_behind[i] = sides.behind;
}

static void note_all_depths(const wave *w, const trace_block *block, const path_block *path,
                            surface_block *s) {
    if (w->plan->features & MATERIAL_REFRACT) {
        for (unsigned i = 0; i < LANES; ++i) note_depths(w, block, path, i, s, i);
    } else {
        memcpy(s->depth, path->depth, sizeof s->depth);
        memcpy(s->depth_behind, path->depth, sizeof s->depth_behind);
    }
}

/* A hit joins the block of surfaces that is being filled. */
static void add_hit(wave *w, const trace_block *block, const path_block *path, size_t lane) {
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    unsigned i = w->gather->count;
    surface_gather_add(w->gather, w->plan->world, block, lane);
    for (int c = 0; c < 3; ++c) s->weight[c][i] = path->weight[c][lane];
    s->slot[i] = path->slot[lane];
    s->material[i] = hit_material(w->plan->world, w->gather, i);
    if (w->plan->watertight) note_depths(w, block, path, lane, s, i);
}

/* The rest of the last block repeats its last point, so that stages may compute all 16 lanes. */
static void pad(surface_block *s) {
    for (size_t last = s->count - 1, i = s->count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) s->weight[c][i] = s->weight[c][last];
        s->slot[i] = s->slot[last], s->material[i] = s->material[last];
    }
}

static void end_block(wave *w, bool first) {
    const render_plan *plan = w->plan;
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    if (!w->gather->count) return;
    s->count = w->gather->count;
    surface_gather_end(w->gather, plan->world, plan->kernels, plan->settings.terminator_fix,
                       !(plan->settings.epsilon > 0), s);
    pad(s);
    for (unsigned i = 0; first && w->first && i < s->count; ++i) keep_first(w, i, s->slot[i]);
    w->surface_count += s->count;
    surface_gather_begin(w->gather);
}

static void add_hits(wave *w, const trace_block *block, const path_block *path, uint32_t met, bool first) {
    for (; met; met &= met - 1) {
        add_hit(w, block, path, (size_t)__builtin_ctz(met));
        if (w->gather->count == LANES) end_block(w, first);
    }
}

static void find_materials(const wave *w, bool one, surface_block *s) {
    fathom_id first = hit_material(w->plan->world, w->gather, 0);
    for (unsigned i = 0; i < LANES; ++i) s->material[i] = first;
    for (unsigned i = 1; !one && i < LANES; ++i) s->material[i] = hit_material(w->plan->world, w->gather, i);
}

/* A block whose rays all met something is a block of surfaces as it is. */
static void add_block(wave *w, const trace_block *block, const path_block *path, bool first) {
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    bool one_object = surface_gather_block(w->gather, w->plan->world, w->plan->kernels, block);
    memcpy(s->weight, path->weight, sizeof s->weight);
    memcpy(s->slot, path->slot, sizeof s->slot);
    find_materials(w, one_object, s);
    if (w->plan->watertight) note_all_depths(w, block, path, s);
    end_block(w, first);
}

/* With coverage asked for, the image is to be laid over something else: colours are premultiplied, and the
 * background is not among them. Mirrors and glass still show it. */
static bool shows_background(const wave *w, bool first) {
    bool seen = !(first && w->plan->settings.aovs & FATHOM_AOV_ALPHA);
    return seen && w->plan->background;
}

static unsigned lanes_from(const wave *w, size_t done) {
    return w->now.count - done < LANES ? (unsigned)(w->now.count - done) : LANES;
}

static void add_misses(wave *w, const path_block *path, uint32_t missed, bool background, bool first) {
    if (background) add_background(w, path, missed);
    for (; first && w->first && missed; missed &= missed - 1)
        keep_miss(w->first, path->slot[__builtin_ctz(missed)]);
}

/* Blocks between asking for indices, asking for corners, and reading these: bench/README.md has what others
 * take. */
#define ASK_AHEAD 4

static void ask_ahead(const wave *w, size_t done) {
    const trace_block *block = &w->now.rays[done / LANES];
    const size_t left = (w->now.count - done - 1) / LANES; /* blocks after this one */
    if (left >= 2 * ASK_AHEAD) surface_ask_indices(w->plan->world, &block[2 * ASK_AHEAD].hits);
    if (left >= ASK_AHEAD) surface_ask_corners(w->plan->world, &block[ASK_AHEAD].hits);
}

/* Whole blocks stay together, of camera rays in any order, since each has a sample of its own; the order of
 * others is that in which their light is added. */
bool wave_surfaces(wave *w, bool first) {
    const bool background = shows_background(w, first);
    const uint32_t whole = (1u << LANES) - 1;
    uint32_t partial = 0;
    w->surface_count = 0;
    if (!wave_reserve_surfaces(w, w->now.count)) return false;
    surface_gather_begin(w->gather);
    for (size_t done = 0; done < w->now.count; done += LANES) {
        const trace_block *block = &w->now.rays[done / LANES];
        const path_block *path = &w->now.paths[done / LANES];
        uint32_t lanes = (1u << lanes_from(w, done)) - 1, met = w->plan->blocks->met(&block->hits) & lanes;
        ask_ahead(w, done);
        if (met != lanes) add_misses(w, path, lanes & ~met, background, first);
        if (met == whole && !w->gather->count)
            add_block(w, block, path, first);
        else if (met && first)
            w->partial[partial++] = (uint32_t)(done / LANES);
        else if (met)
            add_hits(w, block, path, met, first);
    }
    for (uint32_t i = 0; i < partial; ++i) {
        const trace_block *block = &w->now.rays[w->partial[i]];
        uint32_t lanes = (1u << lanes_from(w, w->partial[i] * (size_t)LANES)) - 1;
        add_hits(w, block, &w->now.paths[w->partial[i]], w->plan->blocks->met(&block->hits) & lanes, first);
    }
    end_block(w, first);
    return true;
}
