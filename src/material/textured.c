#include "material/textured_inner.h"
#include "math/limit.h"
#include "scene/scene.h"

#include <stdlib.h>

/* ---- before rendering ---- */

static bool is_exact(int kind) { return kind == FATHOM_MAP_EMISSIVE || kind == FATHOM_MAP_OPACITY; }

/* Averages of colours are right. Averages of roughness, normals or films are other surfaces: puddles would
 * lose their reflections with distance, and bumps would become a mirror. Scattered rays take averages,
 * because their footprints are small against the lobes that they represent, and details would only be noise.
 */
static bool is_sharp(int kind) {
    return kind != FATHOM_MAP_COLOR && kind != FATHOM_MAP_SPECULAR && kind != FATHOM_MAP_SPECULAR_COLOR &&
           kind != FATHOM_MAP_DIFFUSE_TRANSMISSION && kind != FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR;
}

static bool same_lookup(const lookup *a, const lookup *b) {
    return a->texture == b->texture && a->uv_set == b->uv_set && a->exact == b->exact &&
           a->sharp == b->sharp && memcmp(a->m, b->m, sizeof a->m) == 0;
}

static void plan_map(material_plan *p, int kind) {
    const fathom_map *map = &p->material->maps[kind];
    lookup next = {
        .texture = map->texture, .uv_set = map->uv_set, .exact = is_exact(kind), .sharp = is_sharp(kind)};
    unsigned k = 0;
    p->of[kind] = NO_LOOKUP;
    if (map->texture == FATHOM_NONE) return;
    memcpy(next.m, map->transform, sizeof next.m);
    next.scale = sqrtf(fabsf(next.m[0] * next.m[4] - next.m[1] * next.m[3]));
    while (k < p->count && !same_lookup(&p->lookups[k], &next)) ++k;
    if (k == p->count) p->lookups[p->count++] = next;
    p->of[kind] = (uint8_t)k;
    p->sets |= 1u << map->uv_set;
}

/* The lookup that sets the opacity and nothing else. */
static uint8_t covering(const material_plan *p) {
    const uint8_t k = p->of[FATHOM_MAP_OPACITY];
    for (int kind = 0; kind < FATHOM_MAPS; ++kind)
        if (kind != FATHOM_MAP_OPACITY && p->of[kind] == k) return NO_LOOKUP;
    return k;
}

static bool any_colors(const world *w, unsigned channels) {
    for (size_t i = 0; i < w->meshes.count; ++i) {
        if (w->meshes.items[i].colors && w->meshes.items[i].color_channels >= channels) return true;
    }
    return false;
}
static bool any_directed(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->materials.count; ++i) {
        if (material_is_directed(&scene->materials.items[i].value)) return true;
    }
    return false;
}

fathom_status texturing_create(fathom_context *context, const world *w, uint64_t memory, texture_cache *cache,
                               texturing **out) {
    const fathom_scene *scene = w->scene;
    const bool colors = any_colors(w, 3);
    fathom_material between;
    *out = NULL;
    if (!scene->has_maps && !colors && !any_directed(scene)) return FATHOM_OK;
    const size_t bytes = sizeof **out + scene->materials.count * sizeof(material_plan);
    texturing *t = calloc(1, bytes);
    if (!t) {
        texture_cache_close(cache);
        return fail_memory(context, bytes);
    }
    t->cache = cache;
    t->w = w, t->colors = colors, t->alphas = any_colors(w, 4);
    for (size_t i = 0; i < scene->materials.count; ++i) {
        t->plans[i].material = &scene->materials.items[i].value;
        for (int k = 0; k < FATHOM_MAPS; ++k) plan_map(&t->plans[i], k);
        texturing_plan_parameters(&t->plans[i]);
        t->plans[i].covers = covering(&t->plans[i]);
        t->plans[i].directed = material_is_directed(t->plans[i].material);
        if (t->plans[i].directed) t->plans[i].sets |= 1;
        mapped_between(t->plans[i].material, &between);
        t->plans[i].coat_turns = shader_coat_has_normal(&between);
        t->plans[i].pane = material_is_pane(&between);
    }
    fathom_status status = texturing_make_tangents(context, t);
    if (status == FATHOM_OK && !cache) status = texture_cache_open(context, scene, memory, &t->cache);
    if (status == FATHOM_OK)
        *out = t;
    else
        texturing_destroy(t);
    return status;
}

void texturing_destroy(texturing *t) {
    if (!t) return;
    texture_cache_close(t->cache);
    for (size_t i = 0; t->tangents && i < 2 * t->w->meshes.count; ++i)
        surface_tangents_free(t->tangents[i / 2][i % 2]);
    free(t->tangents);
    for (size_t g = 0; t->passes && g < t->w->geometries.count; ++g) free(t->passes[g]);
    free(t->passes);
    free(t);
}

fathom_status texturing_check(const texturing *t, fathom_context *context) {
    return t ? texture_cache_check(t->cache, context) : FATHOM_OK;
}

uint64_t texturing_peak(const texturing *t) { return t ? texture_cache_peak(t->cache) : 0; }

/* ---- lookups ---- */
/* Its square is a fourth power of lengths, which float holds only from 2^-31 to 2^31. */
static double area_of(const surface_uv *at) { return length_f64(cross_f64(widen(at->du), widen(at->dv))); }

/* The longest footprint, in multiples of its width, that is not blurred across. */
#define LONGEST 16

/* A cone intersects the surface in an ellipse that is longer than wide by 1 / cosine. The samples of a pixel
 * average along it. So the footprint is as wide as the ellipse, and textures stay sharp across it. */
static float width_on(const surface_block *s, unsigned i, float width) {
    float cosine = 0;
    for (int c = 0; c < 3; ++c) cosine += s->ng[c][i] * s->v[c][i];
    return width * most(1, 1 / (LONGEST * most(cosine, 0x1p-10f)));
}

static void find_uvs(points *p, unsigned i, const surface_block *s, const float width[LANES]) {
    const float across = s ? width_on(s, i, width[i]) : 0;
    for (unsigned set = 0; set < 2; ++set) {
        if (!(p->plan[i]->sets >> set & 1)) continue;
        surface_uv_at(p->g, p->t->w, i, set, &p->uv[set][i]);
        const double area = area_of(&p->uv[set][i]);
        p->width[set][i] = area > 0 ? least(across / (float)sqrt(area), 1) : 0;
    }
}

/* Returns false if the lane's material is constant over the surface. */
static bool add_point(points *p, unsigned i, fathom_id material, const surface_block *s,
                      const float width[LANES]) {
    p->plan[i] = &p->t->plans[material];
    p->colored[i] = p->t->colors && surface_color_at(p->g, p->t->w, i, p->color[i]);
    if (!p->colored[i] && !p->plan[i]->count && !p->plan[i]->directed) return false;
    find_uvs(p, i, s, width);
    p->varies[i] = p->colored[i] || p->plan[i]->count;
    p->lanes |= 1u << i;
    return true;
}

static float finite_or_zero(float x) { return x - x == 0 ? x : 0; }

void texturing_place_lookup(const lookup *l, float u, float v, float width, texture_queries *q) {
    const unsigned at = q->count++;
    q->texture[at] = l->texture;
    q->u[at] = finite_or_zero(l->m[0] * u + l->m[1] * v + l->m[2]);
    q->v[at] = finite_or_zero(l->m[3] * u + l->m[4] * v + l->m[5]);
    q->width[at] = l->exact ? 0 : finite_or_zero(width * l->scale);
}

/* Does the k-th lookups of all lanes. False: no material has that many. */
static bool look_up(points *p, unsigned k) {
    texture_queries q = {.count = 0};
    float rgba[4][TEXTURE_BLOCK];
    unsigned from[LANES];
    bool any = false;
    for (uint32_t left = p->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        if (k >= p->plan[i]->count) continue;
        any = true;
        if (k == p->plan[i]->covers && texturing_is_opaque(p->t, p->g, i)) {
            const bool inverted = p->plan[i]->material->maps[FATHOM_MAP_OPACITY].inverted;
            for (int c = 0; c < 4; ++c) p->values[i][k][c] = inverted ? 0 : 1;
            continue;
        }
        const lookup *l = &p->plan[i]->lookups[k];
        const surface_uv *at = &p->uv[l->uv_set][i];
        from[q.count] = i;
        texturing_place_lookup(l, at->u, at->v, width_of_lookup(p, l, i), &q);
    }
    if (q.count) texture_lookup(p->t->cache, &q, rgba);
    for (unsigned j = 0; j < q.count; ++j) {
        for (int c = 0; c < 4; ++c) p->values[from[j]][k][c] = rgba[c][j];
    }
    return any;
}

/* ---- blocks ---- */

/* Lanes past the count repeat the last one. */
static void find_points(const texturing *t, const surface_gather *g, const float width[LANES], uint32_t seen,
                        surface_block *s, points *p) {
    p->t = t, p->g = g, p->lanes = 0, p->seen = seen;
    for (unsigned i = 0; i < s->count; ++i) add_point(p, i, s->material[i], s, width);
    for (unsigned k = 0; k < FATHOM_MAPS && look_up(p, k); ++k) continue;
    texturing_turn_normals(p, s);
    for (unsigned i = s->count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) s->ns[c][i] = s->ns[c][s->count - 1];
    }
}

static void repeat_last(surface_block *s, const shader *at[LANES]) {
    const unsigned last = s->count - 1;
    for (unsigned i = s->count; i < LANES; ++i) {
        at[i] = at[last];
        for (int c = 0; c < 3; ++c) s->along[c][i] = s->along[c][last];
        s->directed |= (s->directed >> last & 1) << i;
    }
}

void texturing_shade(const texturing *t, const surface_gather *g, const float width[LANES], uint32_t seen,
                     const float around[LANES], surface_block *s, shader made[LANES],
                     const shader *at[LANES]) {
    points p;
    find_points(t, g, width, seen, s, &p);
    for (uint32_t left = p.lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        fathom_material m;
        texturing_apply(p.plan[i], p.values[i], p.colored[i] ? p.color[i] : NULL, &m);
        if (p.plan[i]->directed) texturing_direct(&p, i, &m, s);
        if (!p.varies[i]) continue;
        if (around) m.ior /= around[i];
        shader_prepare(&m, &made[i]);
        at[i] = &made[i];
    }
    repeat_last(s, at);
}

void texturing_classic(const texturing *t, const surface_gather *g, surface_block *s, bsdf made[LANES],
                       const bsdf *at[LANES]) {
    static const float exact[LANES];
    points p;
    find_points(t, g, exact, ~0u, s, &p);
    for (uint32_t left = p.lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        fathom_material m, classic;
        if (!p.varies[i]) continue;
        texturing_apply(p.plan[i], p.values[i], p.colored[i] ? p.color[i] : NULL, &m);
        classic = m;
        if (is_classic(&m))
            texturing_dissolve(&classic);
        else
            metallic_to_classic(&m, &classic);
        bsdf_prepare(&classic, t->w->scene->ambient, &made[i]);
        at[i] = &made[i];
    }
    for (unsigned i = s->count; i < LANES; ++i) at[i] = at[s->count - 1];
}
