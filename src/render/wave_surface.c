/* Hits become surface points: object, world, viewer's side. */
#include "render/surface_point.h"
#include "render/wave.h"
#include "shade/limit.h"

static fathom_id hit_material(const world *scene, const ray_hit *ray) {
    if (ray->geometry == TRACE_PLANE) return scene->planes.items[ray->primitive].material;
    return world_material(scene, ray->geometry, ray->primitive, ray->instance);
}

/* The misses among the lanes of a block. */
static void add_background(wave *w, const trace_block *block, const path_block *path, unsigned lanes) {
    const float *background = w->plan->scene->background;
    for (unsigned i = 0; i < lanes; ++i) {
        if (block->hits.geometry[i] != FATHOM_NONE) continue;
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

static fathom_id placed_by(const world *scene, const ray_hit *ray) {
    return ray->instance != FATHOM_NONE ? scene->instances.items[ray->instance].id
                                        : scene->geometries.items[ray->geometry].instance;
}

/* Of lane i of the gathered hits. */
static void keep_first(wave *w, unsigned i, uint32_t slot) {
    const world *scene = w->plan->world;
    const ray_hit *ray = &w->gather->hits[i];
    const local_block *b = &w->gather->local;
    const fathom_material *m = &w->plan->scene->materials.items[hit_material(scene, ray)].value;
    first_hits *f = w->first;
    bool plane = ray->geometry == TRACE_PLANE, specular = m->specular != FATHOM_SPECULAR_NONE;
    vec3_f64 p = {b->p[0][i], b->p[1][i], b->p[2][i]}, from_eye = sub_f64(p, widen(w->plan->camera.eye));
    vec3_f32 ng = {(float)b->n[0][i], (float)b->n[1][i], (float)b->n[2][i]};
    vec3_f32 ns = {b->ns[0][i], b->ns[1][i], b->ns[2][i]};
    if (!(dot_f32(ns, ng) * dot_f32(ng, ray->dir) < 0)) ns = neg_f32(ns);
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
    f->object[slot] = plane ? scene->planes.items[ray->primitive].object
                            : world_object(scene, ray->geometry, ray->primitive);
    f->primitive[slot] = plane ? 0 : ray->primitive;
    f->instance[slot] = plane ? FATHOM_NONE : placed_by(scene, ray);
}

/* Blocks of hits between asking for memory and reading it. */
#define FETCH 2

/* Only glass takes a path to the other side. */
static void note_depths(const wave *w, const trace_block *block, const path_block *path, size_t lane,
                        surface_block *s, unsigned i) {
    watertight_sides sides = {path->depth[lane], path->depth[lane]};
    if (w->plan->features & MATERIAL_REFRACT)
        sides = watertight_sides_of(w->plan->watertight, block, (unsigned)lane, path->depth[lane]);
    s->depth[i] = sides.before;
    s->depth_behind[i] = sides.behind;
}

/* A hit joins the block of surfaces that is being filled. */
static void add_hit(wave *w, const ray_hit *ray, const trace_block *block, const path_block *path,
                    size_t lane) {
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    unsigned i = w->gather->count;
    surface_gather_add(w->gather, w->plan->world, ray);
    for (int c = 0; c < 3; ++c) s->weight[c][i] = path->weight[c][lane];
    s->slot[i] = path->slot[lane];
    s->material[i] = hit_material(w->plan->world, ray);
    if (w->plan->watertight) note_depths(w, block, path, lane, s, i);
}

/* The rest of the last block repeats its last point, so that stages may compute all 16 lanes. */
static void pad(surface_block *s) {
    for (size_t last = s->count - 1, i = s->count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) s->weight[c][i] = s->weight[c][last];
        s->slot[i] = s->slot[last], s->material[i] = s->material[last];
    }
}

static void begin_block(wave *w) {
    surface_gather_begin(w->gather, w->plan->parts & FATHOM_PART_NORMALS,
                         w->plan->settings.keep & FATHOM_PART_NORMALS);
}

static void end_block(wave *w, bool first) {
    const render_plan *plan = w->plan;
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    if (!w->gather->count) return;
    s->count = w->gather->count;
    surface_gather_end(w->gather, plan->world, plan->kernels, plan->parts & FATHOM_PART_LIFTS,
                       !(plan->settings.epsilon > 0), s);
    pad(s);
    for (unsigned i = 0; first && w->first && i < s->count; ++i) keep_first(w, i, s->slot[i]);
    w->surface_count += s->count;
    begin_block(w);
}

static void add_hits(wave *w, const trace_block *block, const path_block *path, unsigned lanes, bool first) {
    for (unsigned i = 0; i < lanes; ++i) {
        if (block->hits.geometry[i] == FATHOM_NONE) continue;
        ray_hit ray = ray_hit_load(block, i);
        add_hit(w, &ray, block, path, i);
        if (w->gather->count == LANES) end_block(w, first);
    }
}

/* With coverage asked for, the image is to be laid over something else: colours are premultiplied, and the
 * background is not among them. Mirrors and glass still show it. */
static bool shows_background(const wave *w, bool first) {
    bool seen = !(first && w->plan->settings.aovs & FATHOM_AOV_ALPHA);
    return seen && w->plan->parts & FATHOM_PART_BACKGROUND;
}

static unsigned lanes_from(const wave *w, size_t done) {
    return w->now.count - done < LANES ? (unsigned)(w->now.count - done) : LANES;
}

/* In a mesh that no cache holds, the hits of a wave wait for memory three times each: fetched blocks ahead,
 * they wait together. */
static void fetch_ahead(const wave *w, size_t done) {
    const world *scene = w->plan->world;
    const bool normals = w->plan->parts & FATHOM_PART_NORMALS;
    size_t near = done + FETCH * LANES, far = done + 2 * FETCH * LANES;
    if (far < w->now.count)
        surface_fetch_indices(scene, &w->now.rays[far / LANES], lanes_from(w, far), normals);
    if (near < w->now.count)
        surface_fetch_corners(scene, &w->now.rays[near / LANES], lanes_from(w, near), normals);
}

bool wave_surfaces(wave *w, bool first) {
    const bool background = shows_background(w, first);
    w->surface_count = 0;
    if (!wave_reserve_surfaces(w, w->now.count)) return false;
    begin_block(w);
    for (size_t done = 0; done < w->now.count; done += LANES) {
        const trace_block *block = &w->now.rays[done / LANES];
        const path_block *path = &w->now.paths[done / LANES];
        unsigned lanes = lanes_from(w, done);
        fetch_ahead(w, done);
        if (background) add_background(w, block, path, lanes);
        for (unsigned i = 0; first && w->first && i < lanes; ++i) {
            if (block->hits.geometry[i] == FATHOM_NONE) keep_miss(w->first, path->slot[i]);
        }
        add_hits(w, block, path, lanes, first);
    }
    end_block(w, first);
    return true;
}
