/* Opacity of whole triangles. Bounds of the image over a triangle's texture coordinates, and the alpha of its
 * corners, decide it once: any-hit queries then stop there, or skip the triangle, without a lookup. */
#include "base/threads.h"
#include "material/textured_inner.h"
#include "texture/ranges.h"

#include <stdlib.h>

float texturing_cover(const material_plan *p, float image, float alpha) {
    fathom_material m = {.model = p->material->model, .opacity = p->material->opacity};
    m.opacity_cutoff = p->material->opacity_cutoff;
    if (p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP)
        texturing_multiply(&m, FATHOM_MAP_OPACITY, &image, p->material->maps[FATHOM_MAP_OPACITY].inverted);
    texturing_multiply(&m, FATHOM_MAP_OPACITY, &alpha, false);
    return material_opacity(&m);
}

/* ---- ranges of images ---- */

typedef struct sorting {
    const texturing *t;
    texture_ranges **ranges; /* by material: of its image of opacity; NULL: none, or not known */
    const fathom_mesh *mesh;
    uint32_t geometry;
    fathom_id materials[2]; /* that the geometry has */
    uint8_t *passes;        /* of its triangles */
} sorting;

/* The material that all instances of a group have which have one of their own. */
typedef struct other_material {
    fathom_id material; /* FATHOM_NONE: none has */
    bool several;       /* they differ */
} other_material;

static const fathom_map *cover_of(const texturing *t, size_t material) {
    const fathom_map *map = &t->plans[material].material->maps[FATHOM_MAP_OPACITY];
    return map->texture != FATHOM_NONE ? map : NULL;
}

/* The first material with the same channel of the same texture. */
static size_t first_with(const texturing *t, size_t material) {
    const fathom_map *map = cover_of(t, material);
    for (size_t i = 0; i < material; ++i) {
        const fathom_map *other = cover_of(t, i);
        if (other && other->texture == map->texture && other->channel == map->channel) return i;
    }
    return material;
}

/* Images are decoded in parallel. */
static void decode(void *user, size_t begin, size_t end) {
    const texturing *t = user;
    for (size_t i = begin; i < end; ++i) {
        const fathom_map *map = cover_of(t, i);
        texture_queries q = {.count = 1};
        float rgba[4][TEXTURE_BLOCK];
        if (!map) continue;
        q.texture[0] = map->texture;
        texture_lookup(t->cache, &q, rgba);
    }
}

static fathom_status find_ranges(sorting *s, fathom_context *context) {
    const texturing *t = s->t;
    const size_t count = t->w->scene->materials.count;
    fathom_status status = FATHOM_OK;
    loop_parallel(fathom_context_threads(context), count, 1, decode, (void *)(uintptr_t)t);
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) {
        const fathom_map *map = cover_of(t, i);
        if (!map) continue;
        const size_t first = first_with(t, i);
        if (first < i)
            s->ranges[i] = s->ranges[first];
        else
            status = texture_ranges_find(t->cache, context, map->texture, map->channel, &s->ranges[i]);
    }
    return status;
}

static void free_ranges(sorting *s) {
    for (size_t i = 0; s->ranges && i < s->t->w->scene->materials.count; ++i)
        if (s->ranges[i] && first_with(s->t, i) == i) texture_ranges_free(s->ranges[i]);
    free(s->ranges);
}

/* ---- triangles ---- */

/* Lookups and interpolation round by less than this; not where all values are the same. */
#define ROUNDED 0x1p-20f

static texture_range rounded(texture_range r) {
    if (r.least == r.most) return r;
    return (texture_range){r.least * (r.least > 0 ? 1 - ROUNDED : 1 + ROUNDED),
                           r.most * (r.most > 0 ? 1 + ROUNDED : 1 - ROUNDED)};
}

/* False: not known. */
static bool image_over(const sorting *s, fathom_id material, uint32_t triangle, texture_range *out) {
    const material_plan *p = &s->t->plans[material];
    const fathom_map *map = cover_of(s->t, material);
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    *out = (texture_range){1, 1};
    if (!map) return true;
    if (!s->ranges[material]) return false;
    for (int k = 0; k < 3; ++k) {
        const float corner[3] = {k == 0, k == 1, k == 2}, *m = p->lookups[p->of[FATHOM_MAP_OPACITY]].m;
        float uv[2];
        surface_uv_of(s->t->w, s->geometry, triangle, false, corner, map->uv_set, uv);
        for (int c = 0; c < 2; ++c) {
            const float at = m[3 * c] * uv[0] + m[3 * c + 1] * uv[1] + m[3 * c + 2];
            low[c] = fminf(low[c], at), high[c] = fmaxf(high[c], at);
            if (!(at - at == 0)) low[c] = -INFINITY;
        }
    }
    *out = rounded(texture_range_over(s->ranges[material], low, high));
    return true;
}

static texture_range alpha_over(const sorting *s, uint32_t triangle) {
    const fathom_mesh *m = s->mesh;
    texture_range out = {INFINITY, -INFINITY};
    if (!m->colors || m->color_channels < 4) return (texture_range){1, 1};
    for (size_t k = 0; k < 3; ++k) {
        const float alpha = mesh_row(m->colors, m->color_stride, m->indices[3 * (size_t)triangle + k])[3];
        out.least = fminf(out.least, alpha), out.most = fmaxf(out.most, alpha);
    }
    return rounded(out);
}

static uint8_t passes_of(const sorting *s, fathom_id material, uint32_t triangle) {
    const material_plan *p = &s->t->plans[material];
    const texture_range alpha = alpha_over(s, triangle);
    texture_range image;
    if (!image_over(s, material, triangle, &image)) return TRACE_PASSES_SOME;
    const float a = texturing_cover(p, image.least, alpha.least),
                b = texturing_cover(p, image.most, alpha.least),
                c = texturing_cover(p, image.least, alpha.most),
                d = texturing_cover(p, image.most, alpha.most);
    if (fmaxf(c, d) <= 0) return TRACE_PASSES_ALL;
    return fminf(a, b) >= 1 && !p->pane ? TRACE_PASSES_NONE : TRACE_PASSES_SOME;
}

static void sort_triangles(void *user, size_t begin, size_t end) {
    const sorting *s = user;
    for (size_t i = begin; i < end; ++i) {
        const uint8_t first = passes_of(s, s->materials[0], (uint32_t)i);
        s->passes[i] = first;
        if (s->materials[1] == FATHOM_NONE || first == TRACE_PASSES_SOME) continue;
        if (passes_of(s, s->materials[1], (uint32_t)i) != first) s->passes[i] = TRACE_PASSES_SOME;
    }
}

/* ---- meshes ---- */

/* Finds the materials that instances give to their groups. */
static void find_others(const world *w, other_material *others) {
    for (size_t g = 0; g < w->groups.count; ++g) others[g] = (other_material){FATHOM_NONE, false};
    for (size_t k = 0; k < w->instances.count; ++k) {
        const fathom_id material = w->instances.items[k].material;
        other_material *other = &others[w->instances.items[k].group];
        if (material == FATHOM_NONE) continue;
        other->several |= other->material != FATHOM_NONE && other->material != material;
        other->material = material;
    }
}

/* False: not all triangles may pass some light. */
static bool is_sorted(const sorting *s, uint32_t count) {
    return memchr(s->passes, TRACE_PASSES_NONE, count) || memchr(s->passes, TRACE_PASSES_ALL, count);
}

static fathom_status sort_mesh(sorting *s, fathom_context *context, uint8_t **out) {
    const uint32_t count = s->t->w->geometries.items[s->geometry].count;
    s->mesh = world_mesh(s->t->w, s->geometry);
    s->passes = malloc(count);
    if (!s->passes) return fail_memory(context, count);
    loop_parallel(fathom_context_threads(context), count, 4096, sort_triangles, s);
    if (is_sorted(s, count))
        *out = s->passes;
    else
        free(s->passes);
    return FATHOM_OK;
}

static fathom_status sort_group(sorting *s, fathom_context *context, const world_group *group,
                                const other_material *other, const uint8_t *passing) {
    const world *w = s->t->w;
    fathom_status status = FATHOM_OK;
    for (uint32_t g = group->first; g < group->first + group->count && status == FATHOM_OK; ++g) {
        if (!passing[g] || w->geometries.items[g].kind != WORLD_MESH || !w->geometries.items[g].count)
            continue;
        s->geometry = g;
        s->materials[0] = world_material(w, g, 0, FATHOM_NONE), s->materials[1] = other->material;
        if (!other->several) status = sort_mesh(s, context, &s->t->passes[g]);
    }
    return status;
}

static fathom_status sort_groups(sorting *s, fathom_context *context, const uint8_t *passing) {
    const world *w = s->t->w;
    other_material *others = malloc((w->groups.count + 1) * sizeof *others);
    fathom_status status = others ? FATHOM_OK : fail_memory(context, w->groups.count * sizeof *others);
    if (others) find_others(w, others);
    for (size_t k = 0; k < w->groups.count && status == FATHOM_OK; ++k)
        status = sort_group(s, context, &w->groups.items[k], &others[k], passing);
    free(others);
    return status;
}

fathom_status texturing_find_passing(texturing *t, fathom_context *context, trace_passing *out) {
    const size_t geometries = t->w->geometries.count, materials = t->w->scene->materials.count;
    sorting s = {.t = t, .ranges = calloc(materials + 1, sizeof *s.ranges)};
    uint8_t *passing = world_passing(t->w);
    t->passes = calloc(geometries + 1, sizeof *t->passes);
    fathom_status status = s.ranges && passing && t->passes
                               ? find_ranges(&s, context)
                               : fail_memory(context, (materials + geometries) * sizeof(void *));
    if (status == FATHOM_OK) status = sort_groups(&s, context, passing);
    free_ranges(&s);
    free(passing);
    *out = (trace_passing){(const uint8_t *const *)t->passes, texturing_passes_at, t};
    return status;
}
