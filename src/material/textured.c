#include "material/textured.h"

#include "math/limit.h"
#include "scene/metallic.h"
#include "surface/attributes.h"
#include "texture/texture.h"

#include <stdlib.h>
#include <string.h>

enum { NO_LOOKUP = 0xff };

/* One image in one place of the surface, for one or several parameters. */
typedef struct lookup {
    fathom_id texture;
    uint32_t uv_set;
    bool exact;  /* without a footprint */
    float m[6];  /* fathom_map.transform */
    float scale; /* by which it stretches lengths, as the root of areas */
} lookup;

typedef struct material_plan {
    const fathom_material *material;
    unsigned count;
    lookup lookups[FATHOM_MAPS];
    uint8_t of[FATHOM_MAPS]; /* which of them serves a parameter, or NO_LOOKUP */
    unsigned sets;           /* uv sets that are needed, as bits */
} material_plan;

struct texturing {
    const world *w;
    texture_cache *cache;
    bool colors;                 /* some mesh has vertex colours, */
    bool alphas;                 /* and some with alpha */
    surface_tangents **tangents; /* by mesh of the world; NULL: it has its own, or needs none */
    material_plan plans[];
};

/* ---- before rendering ---- */

static bool is_exact(int kind) { return kind == FATHOM_MAP_EMISSIVE || kind == FATHOM_MAP_OPACITY; }

static bool same_lookup(const lookup *a, const lookup *b) {
    return a->texture == b->texture && a->uv_set == b->uv_set && a->exact == b->exact &&
           memcmp(a->m, b->m, sizeof a->m) == 0;
}

static void plan_map(material_plan *p, int kind) {
    const fathom_map *map = &p->material->maps[kind];
    lookup next = {.texture = map->texture, .uv_set = map->uv_set, .exact = is_exact(kind)};
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

static bool any_colors(const world *w, unsigned channels) {
    for (size_t i = 0; i < w->meshes.count; ++i) {
        if (w->meshes.items[i].colors && w->meshes.items[i].color_channels >= channels) return true;
    }
    return false;
}

static const fathom_mesh *mesh_of(const world *w, uint32_t geometry) {
    const bool mesh = geometry < w->geometries.count && w->geometries.items[geometry].kind == WORLD_MESH;
    return mesh ? world_mesh(w, geometry) : NULL;
}

/* Of meshes whose own material has a normal map; those that an instance gives one get the frames of their
 * triangles. */
static fathom_status make_tangents(fathom_context *context, texturing *t) {
    const world *w = t->w;
    fathom_status status = FATHOM_OK;
    t->tangents = calloc(w->meshes.count + 1, sizeof *t->tangents);
    if (!t->tangents) return fail_memory(context, w->meshes.count * sizeof *t->tangents);
    for (size_t i = 0; i < w->meshes.count && status == FATHOM_OK; ++i) {
        const fathom_mesh *m = &w->meshes.items[i];
        const fathom_map *map = &t->plans[m->material].material->maps[FATHOM_MAP_NORMAL];
        if (map->texture == FATHOM_NONE || (m->tangents && map->uv_set == 0)) continue;
        status = surface_tangents_make(context, m, map->uv_set, &t->tangents[i]);
    }
    return status;
}

fathom_status texturing_create(fathom_context *context, const world *w, uint64_t memory, texturing **out) {
    const fathom_scene *scene = w->scene;
    const bool colors = any_colors(w, 3);
    *out = NULL;
    if (!scene->has_maps && !colors) return FATHOM_OK;
    const size_t bytes = sizeof **out + scene->materials.count * sizeof(material_plan);
    texturing *t = calloc(1, bytes);
    if (!t) return fail_memory(context, bytes);
    t->w = w, t->colors = colors, t->alphas = any_colors(w, 4);
    for (size_t i = 0; i < scene->materials.count; ++i) {
        t->plans[i].material = &scene->materials.items[i].value;
        for (int k = 0; k < FATHOM_MAPS; ++k) plan_map(&t->plans[i], k);
    }
    fathom_status status = make_tangents(context, t);
    if (status == FATHOM_OK) status = texture_cache_open(context, scene, memory, &t->cache);
    if (status == FATHOM_OK)
        *out = t;
    else
        texturing_destroy(t);
    return status;
}

void texturing_destroy(texturing *t) {
    if (!t) return;
    texture_cache_close(t->cache);
    for (size_t i = 0; t->tangents && i < t->w->meshes.count; ++i) surface_tangents_free(t->tangents[i]);
    free(t->tangents);
    free(t);
}

fathom_status texturing_check(const texturing *t, fathom_context *context) {
    return t ? texture_cache_check(t->cache, context) : FATHOM_OK;
}

/* ---- parameters ---- */

#define NONE ((size_t)-1)

/* Members of fathom_material by kind, of each model. */
static const struct {
    size_t metallic, classic;
    int count;
    bool bounded; /* by 1 */
} members[FATHOM_MAPS] = {
    [FATHOM_MAP_COLOR] = {offsetof(fathom_material, base_color), offsetof(fathom_material, k_d), 3, true},
    [FATHOM_MAP_OPACITY] = {offsetof(fathom_material, opacity), offsetof(fathom_material, opacity), 1, true},
    [FATHOM_MAP_METALLIC] = {offsetof(fathom_material, metallic), NONE, 1, true},
    [FATHOM_MAP_ROUGHNESS] = {offsetof(fathom_material, roughness), NONE, 1, true},
    [FATHOM_MAP_EMISSIVE] = {offsetof(fathom_material, emissive), offsetof(fathom_material, k_e), 3, false},
    [FATHOM_MAP_NORMAL] = {NONE, NONE, 0, false},
    [FATHOM_MAP_TRANSMISSION] = {offsetof(fathom_material, transmission), NONE, 1, true},
    [FATHOM_MAP_SPECULAR] = {offsetof(fathom_material, specular_factor), NONE, 1, true},
    [FATHOM_MAP_SPECULAR_COLOR] = {offsetof(fathom_material, specular_color), offsetof(fathom_material, k_s),
                                   3, false},
    [FATHOM_MAP_CLEARCOAT] = {offsetof(fathom_material, clearcoat), NONE, 1, true},
    [FATHOM_MAP_CLEARCOAT_ROUGHNESS] = {offsetof(fathom_material, clearcoat_roughness), NONE, 1, true},
    [FATHOM_MAP_SHININESS] = {NONE, offsetof(fathom_material, shininess), 1, false},
};

static bool is_classic(const fathom_material *m) { return m->model == FATHOM_MODEL_CLASSIC; }

static float *member(fathom_material *m, int kind) {
    const size_t offset = is_classic(m) ? members[kind].classic : members[kind].metallic;
    return offset == NONE ? NULL : (float *)(void *)((char *)m + offset);
}

static void multiply(fathom_material *m, int kind, const float *factor, bool inverted) {
    float *to = member(m, kind);
    for (int c = 0; to && c < members[kind].count; ++c) {
        float value = inverted ? 1 - (1 - to[c]) * factor[c] : to[c] * factor[c];
        value = value > 0 ? value : 0;
        to[c] = members[kind].bounded && value > 1 ? 1 : value;
    }
}

/* For the classic integrator: light passes straight through the part of the surface that is not there. */
static void dissolve(fathom_material *m) {
    const float left = m->opacity;
    float *const colours[] = {m->k_a, m->k_d, m->k_s, m->k_r, m->k_e};
    if (left >= 1) return;
    if (!(m->k_t[0] > 0 || m->k_t[1] > 0 || m->k_t[2] > 0)) m->ior = 1, m->fresnel = false;
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < sizeof colours / sizeof *colours; ++i) colours[i][c] *= left;
        m->k_t[c] = m->k_t[c] * left + (1 - left);
    }
}

/* An unlit material: the colours of vertices are those of its emission. */
static bool sends_alone(const fathom_material *m) {
    const float *b = m->base_color;
    return !is_classic(m) && !(b[0] > 0 || b[1] > 0 || b[2] > 0) && !(m->specular_factor > 0);
}

/* values: of the lookups. The material's parameters become those of the point. */
static void apply(const material_plan *p, const float (*values)[4], const float color[4],
                  fathom_material *m) {
    *m = *p->material;
    for (int kind = 0; kind < FATHOM_MAPS; ++kind) {
        if (p->of[kind] == NO_LOOKUP) continue;
        const fathom_map *map = &p->material->maps[kind];
        const float *rgba = values[p->of[kind]];
        multiply(m, kind, members[kind].count == 1 ? &rgba[map->channel] : rgba, map->inverted);
    }
    multiply(m, sends_alone(m) ? FATHOM_MAP_EMISSIVE : FATHOM_MAP_COLOR, color, false);
    multiply(m, FATHOM_MAP_OPACITY, &color[3], false);
    m->opacity = material_opacity(m), m->opacity_cutoff = 0;
}

/* ---- lookups ---- */

/* The points of a block that vary. */
typedef struct points {
    const texturing *t;
    const surface_gather *g;
    uint32_t lanes; /* bits */
    const material_plan *plan[LANES];
    surface_uv uv[2][LANES];
    float width[2][LANES]; /* of the footprint, in u and v */
    float color[LANES][4];
    float values[LANES][FATHOM_MAPS][4];
} points;

static float area_of(const surface_uv *at) {
    const vec3_f32 n = cross_f32(at->du, at->dv);
    return sqrtf(dot_f32(n, n));
}

/* A cone of width w meets the surface in an ellipse of the area of a disc w / sqrt(cosine) wide. */
static void find_uvs(points *p, unsigned i, const surface_block *s, const float width[LANES]) {
    float cosine = 0;
    for (int c = 0; s && c < 3; ++c) cosine += s->ng[c][i] * s->v[c][i];
    for (unsigned set = 0; set < 2; ++set) {
        if (!(p->plan[i]->sets >> set & 1)) continue;
        surface_uv_at(p->g, p->t->w, i, set, &p->uv[set][i]);
        const float area = s ? area_of(&p->uv[set][i]) * fmaxf(cosine, 0x1p-10f) : 0;
        p->width[set][i] = area > 0 ? fminf(width[i] / sqrtf(area), 1) : 0;
    }
}

/* False: the lane's material is the same everywhere. */
static bool add_point(points *p, unsigned i, fathom_id material, const surface_block *s,
                      const float width[LANES]) {
    static const float white[4] = {1, 1, 1, 1};
    p->plan[i] = &p->t->plans[material];
    memcpy(p->color[i], white, sizeof white);
    const bool coloured = p->t->colors && surface_color_at(p->g, p->t->w, i, p->color[i]);
    if (!coloured && !p->plan[i]->count) return false;
    find_uvs(p, i, s, width);
    p->lanes |= 1u << i;
    return true;
}

static float finite_or_zero(float x) { return x - x == 0 ? x : 0; }

static void place_lookup(const lookup *l, float u, float v, float width, texture_queries *q) {
    const unsigned at = q->count++;
    q->texture[at] = l->texture;
    q->u[at] = finite_or_zero(l->m[0] * u + l->m[1] * v + l->m[2]);
    q->v[at] = finite_or_zero(l->m[3] * u + l->m[4] * v + l->m[5]);
    q->width[at] = l->exact ? 0 : finite_or_zero(width * l->scale);
}

/* The k-th lookups of all lanes. False: there are none. */
static bool look_up(points *p, unsigned k) {
    texture_queries q = {.count = 0};
    float rgba[4][TEXTURE_BLOCK];
    unsigned from[LANES];
    for (uint32_t left = p->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        if (k >= p->plan[i]->count) continue;
        const lookup *l = &p->plan[i]->lookups[k];
        const surface_uv *at = &p->uv[l->uv_set][i];
        from[q.count] = i;
        place_lookup(l, at->u, at->v, p->width[l->uv_set][i], &q);
    }
    if (!q.count) return false;
    texture_lookup(p->t->cache, &q, rgba);
    for (unsigned j = 0; j < q.count; ++j) {
        for (int c = 0; c < 4; ++c) p->values[from[j]][k][c] = rgba[c][j];
    }
    return true;
}

/* ---- normals ---- */

static vec3_f32 lane(const lanes3 from, unsigned i) { return (vec3_f32){from[0][i], from[1][i], from[2][i]}; }

static bool make_unit(vec3_f32 *v) {
    const float square = dot_f32(*v, *v);
    if (!(square > 0x1p-100f) || !(square < 0x1p100f)) return false;
    *v = scale_f32(1 / sqrtf(square), *v);
    return true;
}

/* The way of u on the triangle, for maps that do not turn the image; else that of the image itself. */
static bool made_tangent(const points *p, unsigned i, const lookup *l, vec3_f32 *t) {
    const world *w = p->t->w;
    if (l->m[1] != 0 || l->m[3] != 0 || !(l->m[0] > 0) || !mesh_of(w, p->g->geometry[i])) return false;
    const surface_tangents *made = p->t->tangents[w->geometries.items[p->g->geometry[i]].first];
    return made && surface_made_tangent_at(p->g, w, i, made, t);
}

/* The image's frame about the outside normal n. False: the image does not lie on the surface. */
static bool find_frame(const points *p, unsigned i, vec3_f32 n, vec3_f32 *t, vec3_f32 *b) {
    const lookup *l = &p->plan[i]->lookups[p->plan[i]->of[FATHOM_MAP_NORMAL]];
    const surface_uv *at = &p->uv[l->uv_set][i];
    const float turn = l->m[0] * l->m[4] - l->m[1] * l->m[3] < 0 ? -1 : 1;
    float sign;
    if (l->uv_set != 0 || !surface_tangent_at(p->g, p->t->w, i, t, &sign)) {
        const vec3_f32 up = scale_f32(turn, sub_f32(scale_f32(l->m[1], at->du), scale_f32(l->m[0], at->dv)));
        *t = scale_f32(turn, sub_f32(scale_f32(l->m[4], at->du), scale_f32(l->m[3], at->dv)));
        sign = dot_f32(cross_f32(n, *t), up) < 0 ? -1 : 1;
        made_tangent(p, i, l, t);
    }
    if (!make_unit(t)) return false;
    *t = sub_f32(*t, scale_f32(dot_f32(n, *t), n));
    if (!make_unit(t)) return false;
    *b = scale_f32(sign, cross_f32(n, *t));
    return true;
}

/* The normal is seen under no more than this cosine from its horizon. */
#define FACES_VIEWER 0x1p-6f

static void turn_normal(const points *p, unsigned i, surface_block *s) {
    const material_plan *plan = p->plan[i];
    const float *rgb = p->values[i][plan->of[FATHOM_MAP_NORMAL]], scale = plan->material->normal_scale;
    vec3_f32 outside = lane(p->g->local.ns, i), t, b;
    if (!find_frame(p, i, outside, &t, &b)) return;
    const float side = dot_f32(outside, lane(s->ns, i)) < 0 ? -1 : 1, z = 2 * rgb[2] - 1;
    vec3_f32 n = scale_f32(z > 0x1p-6f ? z : 0x1p-6f, outside);
    n = madd_f32(madd_f32(n, scale * (2 * rgb[0] - 1), t), scale * (2 * rgb[1] - 1), b);
    if (!make_unit(&n)) return;
    n = scale_f32(side, n);
    const float facing = dot_f32(n, lane(s->v, i));
    if (facing < FACES_VIEWER) {
        n = madd_f32(n, FACES_VIEWER - facing, lane(s->v, i));
        if (!make_unit(&n)) return;
    }
    s->ns[0][i] = n.x, s->ns[1][i] = n.y, s->ns[2][i] = n.z;
}

static void turn_normals(const points *p, surface_block *s) {
    uint32_t mapped = 0;
    for (uint32_t left = p->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        if (p->plan[i]->of[FATHOM_MAP_NORMAL] != NO_LOOKUP) mapped |= 1u << i;
    }
    if (!mapped) return;
    memcpy(s->base, s->ns, sizeof s->base);
    s->mapped = mapped;
    for (; mapped; mapped &= mapped - 1) turn_normal(p, (unsigned)__builtin_ctz(mapped), s);
}

/* ---- blocks ---- */

/* Lanes past the count repeat the last one. */
static void find_points(const texturing *t, const surface_gather *g, const float width[LANES],
                        surface_block *s, points *p) {
    p->t = t, p->g = g, p->lanes = 0;
    for (unsigned i = 0; i < s->count; ++i) add_point(p, i, s->material[i], s, width);
    for (unsigned k = 0; k < FATHOM_MAPS && look_up(p, k); ++k) continue;
    turn_normals(p, s);
    for (unsigned i = s->count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) s->ns[c][i] = s->ns[c][s->count - 1];
    }
}

void texturing_shade(const texturing *t, const surface_gather *g, const float width[LANES], surface_block *s,
                     shader made[LANES], const shader *at[LANES]) {
    points p;
    find_points(t, g, width, s, &p);
    for (uint32_t left = p.lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        fathom_material m;
        apply(p.plan[i], p.values[i], p.color[i], &m);
        shader_prepare(&m, &made[i]);
        at[i] = &made[i];
    }
    for (unsigned i = s->count; i < LANES; ++i) at[i] = at[s->count - 1];
}

void texturing_classic(const texturing *t, const surface_gather *g, const float width[LANES],
                       surface_block *s, bsdf made[LANES], const bsdf *at[LANES]) {
    points p;
    find_points(t, g, width, s, &p);
    for (uint32_t left = p.lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        fathom_material m, classic;
        apply(p.plan[i], p.values[i], p.color[i], &m);
        classic = m;
        if (is_classic(&m)) {
            dissolve(&classic);
        } else {
            const metallic_factors factors = metallic_factors_of(&m);
            metallic_to_classic(&factors, &classic);
        }
        bsdf_prepare(&classic, t->w->scene->ambient, &made[i]);
        at[i] = &made[i];
    }
    for (unsigned i = s->count; i < LANES; ++i) at[i] = at[s->count - 1];
}

/* ---- opacity and emission ---- */

static const float *mapped_value(const texturing *t, const material_plan *p, int kind, float u, float v,
                                 float width, float rgba[4][TEXTURE_BLOCK]) {
    texture_queries q = {.count = 0};
    lookup l = p->lookups[p->of[kind]];
    l.exact = !(width > 0);
    place_lookup(&l, u, v, width, &q);
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
    fathom_material m = {.model = p->material->model, .opacity = p->material->opacity};
    float color[4], rgba[4][TEXTURE_BLOCK];
    m.opacity_cutoff = p->material->opacity_cutoff;
    if (p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP) {
        const fathom_map *map = &p->material->maps[FATHOM_MAP_OPACITY];
        surface_uv at;
        surface_uv_at(g, t->w, i, map->uv_set, &at);
        const float *value = mapped_value(t, p, FATHOM_MAP_OPACITY, at.u, at.v, 0, rgba);
        multiply(&m, FATHOM_MAP_OPACITY, &value[map->channel], map->inverted);
    }
    if (t->alphas && surface_color_at(g, t->w, i, color)) multiply(&m, FATHOM_MAP_OPACITY, &color[3], false);
    return material_opacity(&m);
}

bool texturing_varies_emission(const texturing *t, fathom_id material) {
    const material_plan *p = &t->plans[material];
    return p->of[FATHOM_MAP_EMISSIVE] != NO_LOOKUP || p->of[FATHOM_MAP_OPACITY] != NO_LOOKUP || t->alphas ||
           (t->colors && sends_alone(p->material));
}

/* The root of the area that the place's triangle or half quad has in the image. */
static float image_side(const texturing *t, const texturing_place *place, unsigned set) {
    float uv[3][2];
    for (int k = 0; k < 3; ++k) {
        const float corner[3] = {k == 0, k == 1, k == 2};
        surface_uv_of(t->w, place->geometry, place->primitive, place->second, corner, set, uv[k]);
    }
    const float bu = uv[1][0] - uv[0][0], bv = uv[1][1] - uv[0][1];
    const float cu = uv[2][0] - uv[0][0], cv = uv[2][1] - uv[0][1];
    return sqrtf(0.5f * fabsf(bu * cv - cu * bv));
}

/* Those lookups that emission needs. */
void texturing_emission(const texturing *t, const texturing_place *place, float rgb[3]) {
    static const int kinds[] = {FATHOM_MAP_EMISSIVE, FATHOM_MAP_OPACITY};
    const material_plan *p = &t->plans[place->material];
    float values[FATHOM_MAPS][4], color[4] = {1, 1, 1, 1};
    material_plan few = {.material = p->material};
    memset(few.of, NO_LOOKUP, sizeof few.of);
    for (size_t k = 0; k < 2; ++k) {
        const int kind = kinds[k];
        float rgba[4][TEXTURE_BLOCK], uv[2];
        if (p->of[kind] == NO_LOOKUP) continue;
        const fathom_map *map = &p->material->maps[kind];
        surface_uv_of(t->w, place->geometry, place->primitive, place->second, place->weight, map->uv_set, uv);
        few.of[kind] = (uint8_t)k;
        const float width = place->width > 0 ? place->width * image_side(t, place, map->uv_set) : 0;
        memcpy(values[k], mapped_value(t, p, kind, uv[0], uv[1], width, rgba), sizeof values[k]);
    }
    surface_color_of(t->w, place->geometry, place->primitive, place->weight, color);
    fathom_material m;
    apply(&few, values, color, &m);
    shader_emission(&m, rgb);
}
