/* Frames of images on surfaces, and the normals that they turn. */
#include "material/textured_inner.h"

#include <stdlib.h>

static const fathom_mesh *mesh_of(const world *w, uint32_t geometry) {
    const bool mesh = geometry < w->geometries.count && w->geometries.items[geometry].kind == WORLD_MESH;
    return mesh ? world_mesh(w, geometry) : NULL;
}

/* The map whose image gives the frame. */
static const fathom_map *map_of_frame(const material_plan *p) {
    const fathom_map *maps = p->material->maps;
    const bool own = p->directed && maps[FATHOM_MAP_ANISOTROPY].texture != FATHOM_NONE;
    if (maps[FATHOM_MAP_NORMAL].texture != FATHOM_NONE) return &maps[FATHOM_MAP_NORMAL];
    return &maps[own ? FATHOM_MAP_ANISOTROPY : FATHOM_MAP_CLEARCOAT_NORMAL];
}

fathom_status texturing_make_tangents(fathom_context *context, texturing *t) {
    const world *w = t->w;
    fathom_status status = FATHOM_OK;
    t->tangents = calloc(w->meshes.count + 1, sizeof *t->tangents);
    if (!t->tangents) return fail_memory(context, w->meshes.count * sizeof *t->tangents);
    for (size_t i = 0; i < w->meshes.count && status == FATHOM_OK; ++i) {
        const fathom_mesh *m = &w->meshes.items[i];
        const material_plan *plan = &t->plans[m->material];
        const fathom_map *map = map_of_frame(plan);
        if ((map->texture == FATHOM_NONE && !plan->directed) || (m->tangents && map->uv_set == 0)) continue;
        status = surface_tangents_make(context, m, map->uv_set, &t->tangents[i]);
    }
    return status;
}
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
static bool find_frame(const points *p, unsigned i, const lookup *l, vec3_f32 n, vec3_f32 *t, vec3_f32 *b) {
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

/* As a normal map of this kind has it; `outside` without one. */
static vec3_f32 mapped_normal(const points *p, unsigned i, int kind, float scale, vec3_f32 outside) {
    const material_plan *plan = p->plan[i];
    const unsigned at = plan->of[kind];
    vec3_f32 t, b;
    if (at == NO_LOOKUP || !find_frame(p, i, &plan->lookups[at], outside, &t, &b)) return outside;
    const float *rgb = p->values[i][at], z = 2 * rgb[2] - 1;
    const vec3_f32 n = scale_f32(z > 0x1p-6f ? z : 0x1p-6f, outside);
    return madd_f32(madd_f32(n, scale * (2 * rgb[0] - 1), t), scale * (2 * rgb[1] - 1), b);
}

/* How a height map rises along the surface: from the point over a footprint, and at least a texel, along each
 * side of the image (Blinn, "Simulation of Wrinkled Surfaces", 1978). */
static vec3_f32 slope_of_bump(const points *p, unsigned i, vec3_f32 n) {
    const material_plan *plan = p->plan[i];
    const fathom_map *map = &plan->material->maps[FATHOM_MAP_BUMP];
    const lookup *l = &plan->lookups[plan->of[FATHOM_MAP_BUMP]];
    const surface_uv *at = &p->uv[l->uv_set][i];
    const vec3_f32 up = cross_f32(at->dv, n), right = cross_f32(n, at->du);
    const float area = dot_f32(n, cross_f32(at->du, at->dv));
    texture_queries q = {.count = 0};
    float rgba[4][TEXTURE_BLOCK], rise[2];
    uint32_t size[2];
    texture_size(p->t->cache, l->texture, &size[0], &size[1]);
    for (int c = 0; c < 3; ++c) texturing_place_lookup(l, at->u, at->v, p->width[l->uv_set][i], &q);
    const float step[2] = {fmaxf(q.width[0], 1 / (float)size[0]), fmaxf(q.width[0], 1 / (float)size[1])};
    q.u[1] += step[0], q.v[2] += step[1];
    texture_lookup(p->t->cache, &q, rgba);
    const float *h = rgba[map->channel];
    for (int k = 0; k < 2; ++k) rise[k] = plan->material->bump_scale * (h[k + 1] - h[0]) / step[k];
    const float du = rise[0] * l->m[0] + rise[1] * l->m[3], dv = rise[0] * l->m[1] + rise[1] * l->m[4];
    const vec3_f32 slope = scale_f32(1 / area, madd_f32(scale_f32(du, up), dv, right));
    return area != 0 && finite_f32(slope) ? slope : (vec3_f32){0, 0, 0};
}

/* Sets the normal n of the outside, not unit, as the viewer's side has it. */
static void set_normal(const points *p, unsigned i, const surface_block *s, vec3_f32 n, float (*to)[LANES]) {
    const float side = dot_f32(lane(p->g->local.ns, i), lane(s->base, i)) < 0 ? -1 : 1;
    if (!make_unit(&n)) return;
    n = scale_f32(side, n);
    const float facing = dot_f32(n, lane(s->v, i));
    if (facing < FACES_VIEWER) {
        n = madd_f32(n, FACES_VIEWER - facing, lane(s->v, i));
        if (!make_unit(&n)) return;
    }
    to[0][i] = n.x, to[1][i] = n.y, to[2][i] = n.z;
}

static void turn_normal(const points *p, unsigned i, surface_block *s) {
    const fathom_material *m = p->plan[i]->material;
    const vec3_f32 outside = lane(p->g->local.ns, i);
    vec3_f32 n = mapped_normal(p, i, FATHOM_MAP_NORMAL, m->normal_scale, outside);
    if (p->plan[i]->of[FATHOM_MAP_BUMP] != NO_LOOKUP && make_unit(&n))
        n = sub_f32(n, slope_of_bump(p, i, outside));
    set_normal(p, i, s, n, s->ns);
}

/* KHR_materials_clearcoat: the coat does not have the normals of what it covers. */
static void turn_coat(const points *p, unsigned i, surface_block *s) {
    const float scale = p->plan[i]->material->clearcoat_normal_scale;
    const vec3_f32 outside = lane(p->g->local.ns, i);
    for (int c = 0; c < 3; ++c) s->coat[c][i] = s->base[c][i];
    if (p->plan[i]->of[FATHOM_MAP_CLEARCOAT_NORMAL] != NO_LOOKUP)
        set_normal(p, i, s, mapped_normal(p, i, FATHOM_MAP_CLEARCOAT_NORMAL, scale, outside), s->coat);
}

void texturing_turn_normals(const points *p, surface_block *s) {
    uint32_t mapped = 0, coated = 0;
    for (uint32_t left = p->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        const uint8_t *of = p->plan[i]->of;
        if (of[FATHOM_MAP_NORMAL] != NO_LOOKUP || of[FATHOM_MAP_BUMP] != NO_LOOKUP) mapped |= 1u << i;
        if (shader_coat_has_normal(p->plan[i]->material)) coated |= 1u << i;
    }
    if (!(mapped | coated)) return;
    memcpy(s->base, s->ns, sizeof s->base);
    s->mapped = mapped, s->coated = coated;
    for (; mapped; mapped &= mapped - 1) turn_normal(p, (unsigned)__builtin_ctz(mapped), s);
    for (; coated; coated &= coated - 1) turn_coat(p, (unsigned)__builtin_ctz(coated), s);
}

void texturing_direct(const points *p, unsigned i, const fathom_material *m, surface_block *s) {
    const fathom_map *map = map_of_frame(p->plan[i]);
    lookup l = {.uv_set = map->texture == FATHOM_NONE ? 0 : map->uv_set};
    memcpy(l.m, map->transform, sizeof l.m);
    vec3_f32 t, b;
    if (!p->plan[i]->directed || !find_frame(p, i, &l, lane(p->g->local.ns, i), &t, &b)) return;
    const float cosine = cosf(m->anisotropy_rotation), sine = sinf(m->anisotropy_rotation);
    const vec3_f32 along = madd_f32(scale_f32(cosine, t), sine, b);
    s->along[0][i] = along.x, s->along[1][i] = along.y, s->along[2][i] = along.z;
    s->directed |= 1u << i;
}
