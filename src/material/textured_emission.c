/* Opacity and emission of a single point. */
#include "material/textured_inner.h"

static const float *mapped_value(const texturing *t, const material_plan *p, int kind, float u, float v,
                                 float width, float rgba[4][TEXTURE_BLOCK]) {
    texture_queries q = {.count = 0};
    lookup l = p->lookups[p->of[kind]];
    l.exact = !(width > 0);
    texturing_place_lookup(&l, u, v, width, &q);
    texture_lookup(t->cache, &q, rgba);
    for (int c = 1; c < 4; ++c) rgba[0][c] = rgba[c][0];
    return rgba[0];
}

bool texturing_may_cover(const texturing *t, fathom_id material) {
    const material_plan *p = &t->plans[material];
    return p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP || t->alphas;
}

float texturing_opacity(const texturing *t, const surface_gather *g, unsigned i, fathom_id material) {
    const material_plan *p = &t->plans[material];
    float value = 1, color[4] = {1, 1, 1, 1}, rgba[4][TEXTURE_BLOCK];
    if (texturing_is_opaque(t, g, i)) return 1;
    if (p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP) {
        const fathom_map *map = &p->material->maps[FATHOM_MAP_OPACITY];
        surface_uv at;
        surface_uv_at(g, t->w, i, map->uv_set, &at);
        value = mapped_value(t, p, FATHOM_MAP_OPACITY, at.u, at.v, 0, rgba)[map->channel];
    }
    if (t->alphas) surface_color_at(g, t->w, i, color);
    return texturing_cover(p, value, color[3]);
}

trace_passes texturing_passes_at(const void *user, uint32_t geometry, uint32_t triangle, uint32_t instance,
                                 float u, float v) {
    const texturing *t = user;
    const bool halves = t->w->geometries.items[geometry].kind == WORLD_QUADS;
    const uint32_t primitive = halves ? triangle / 2 : triangle;
    const fathom_id material = world_material(t->w, geometry, primitive, instance);
    const material_plan *p = &t->plans[material];
    const float weight[3] = {1 - u - v, u, v};
    float value = 1, color[4] = {1, 1, 1, 1}, rgba[4][TEXTURE_BLOCK];
    if (p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP) {
        const fathom_map *map = &p->material->maps[FATHOM_MAP_OPACITY];
        float uv[2];
        surface_uv_of(t->w, geometry, primitive, halves && triangle & 1, weight, map->uv_set, uv);
        value = mapped_value(t, p, FATHOM_MAP_OPACITY, uv[0], uv[1], 0, rgba)[map->channel];
    }
    if (t->alphas) surface_color_of(t->w, geometry, primitive, weight, color);
    const float opacity = texturing_cover(p, value, color[3]);
    if (opacity <= 0) return TRACE_PASSES_ALL;
    return opacity >= 1 && !p->pane ? TRACE_PASSES_NONE : TRACE_PASSES_SOME;
}

bool texturing_varies_emission(const texturing *t, fathom_id material) {
    const material_plan *p = &t->plans[material];
    return p->of[FATHOM_MAP_EMISSIVE] != NO_LOOKUP || p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP || t->alphas ||
           (t->colors && material_only_emits(p->material));
}

static void find_brightest_color(const world *w, float rgb[3]) {
    for (size_t i = 0; i < w->meshes.count; ++i) {
        const fathom_mesh *m = &w->meshes.items[i];
        for (uint32_t v = 0; m->colors && v < m->vertex_count; ++v) {
            const float *at = mesh_row(m->colors, m->color_stride, v);
            for (int c = 0; c < 3; ++c) rgb[c] = fmaxf(rgb[c], at[c]);
        }
    }
}

fathom_status texturing_brighten(const texturing *t, fathom_context *context, fathom_id material,
                                 float rgb[3]) {
    const material_plan *p = &t->plans[material];
    float image[3] = {1, 1, 1}, color[3] = {1, 1, 1};
    fathom_status status = FATHOM_OK;
    if (p->of[FATHOM_MAP_EMISSIVE] != NO_LOOKUP)
        status = texture_brightest(t->cache, context, p->material->maps[FATHOM_MAP_EMISSIVE].texture, image);
    if (t->colors && material_only_emits(p->material)) find_brightest_color(t->w, color);
    for (int c = 0; c < 3; ++c) rgb[c] *= image[c] * color[c];
    return status;
}

/* The square root of the area that the triangle or half quad covers in the image; 1 for a sphere. */
static float image_side(const texturing *t, const texturing_place *place, unsigned set) {
    float uv[3][2];
    if (t->w->geometries.items[place->geometry].kind == WORLD_SPHERES) return 1;
    for (int k = 0; k < 3; ++k) {
        const float corner[3] = {k == 0, k == 1, k == 2};
        surface_uv_of(t->w, place->geometry, place->primitive, place->second, corner, set, uv[k]);
    }
    const float bu = uv[1][0] - uv[0][0], bv = uv[1][1] - uv[0][1];
    const float cu = uv[2][0] - uv[0][0], cv = uv[2][1] - uv[0][1];
    return sqrtf(0.5f * fabsf(bu * cv - cu * bv));
}

static const int kinds[] = {FATHOM_MAP_EMISSIVE,
                            FATHOM_MAP_OPACITY}; /* the images that emission depends on */

float texturing_emission_texels(const texturing *t, const texturing_place *place) {
    const material_plan *p = &t->plans[place->material];
    float most = 0;
    for (size_t k = 0; k < 2; ++k) {
        uint32_t width, height;
        if (p->of[kinds[k]] == NO_LOOKUP) continue;
        const lookup *l = &p->lookups[p->of[kinds[k]]];
        texture_size(t->cache, l->texture, &width, &height);
        const float side = image_side(t, place, l->uv_set) * l->scale;
        most = fmaxf(most, side * sqrtf((float)width * (float)height));
    }
    return most;
}

/* Makes only the lookups that emission needs. */
void texturing_emission(const texturing *t, const texturing_place *place, float rgb[3]) {
    const material_plan *p = &t->plans[place->material];
    float color[4];
    fathom_material m;
    memcpy(&m, &p->even, offsetof(fathom_material, maps));
    for (size_t k = 0; k < 2; ++k) {
        const int kind = kinds[k];
        float rgba[4][TEXTURE_BLOCK], uv[2];
        if (p->of[kind] == NO_LOOKUP) continue;
        const fathom_map *map = &p->material->maps[kind];
        surface_uv_of(t->w, place->geometry, place->primitive, place->second, place->weight, map->uv_set, uv);
        const float width = place->width > 0 ? place->width * image_side(t, place, map->uv_set) : 0;
        const float *value = mapped_value(t, p, kind, uv[0], uv[1], width, rgba);
        texturing_multiply(&m, kind, kind == FATHOM_MAP_OPACITY ? &value[map->channel] : value,
                           map->inverted);
    }
    const bool colored = surface_color_of(t->w, place->geometry, place->primitive, place->weight, color);
    texturing_color(p, &m, colored ? color : NULL);
    shader_emission(&m, rgb);
}
