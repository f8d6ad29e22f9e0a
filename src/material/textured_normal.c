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
    return &maps[own && maps[FATHOM_MAP_NORMAL].texture == FATHOM_NONE ? FATHOM_MAP_ANISOTROPY
                                                                       : FATHOM_MAP_NORMAL];
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

static void turn_normal(const points *p, unsigned i, surface_block *s) {
    const material_plan *plan = p->plan[i];
    const float *rgb = p->values[i][plan->of[FATHOM_MAP_NORMAL]], scale = plan->material->normal_scale;
    vec3_f32 outside = lane(p->g->local.ns, i), t, b;
    if (!find_frame(p, i, &plan->lookups[plan->of[FATHOM_MAP_NORMAL]], outside, &t, &b)) return;
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

void texturing_turn_normals(const points *p, surface_block *s) {
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
