/* Frames of images on surfaces, and normals that are rotated in them. */
#include "material/textured_inner.h"
#include "math/lane.h"
#include "math/limit.h"

#include <stdlib.h>

static const fathom_mesh *mesh_of(const world *w, uint32_t geometry) {
    const bool mesh = geometry < w->geometries.count && w->geometries.items[geometry].kind == WORLD_MESH;
    return mesh ? world_mesh(w, geometry) : NULL;
}

/* The map whose image gives the frame of normals and grooves; without a texture, that of the first uv set. */
static const fathom_map *map_of_frame(const material_plan *p) {
    const fathom_map *normal = &p->material->maps[FATHOM_MAP_NORMAL],
                     *own = &p->material->maps[FATHOM_MAP_ANISOTROPY];
    return normal->texture == FATHOM_NONE && p->directed && own->texture != FATHOM_NONE ? own : normal;
}

/* True if an image stands in a frame of this uv set. A coat may have another one than the base. */
static bool takes_frame(const material_plan *p, unsigned set) {
    const fathom_map *map = map_of_frame(p), *coat = &p->material->maps[FATHOM_MAP_CLEARCOAT_NORMAL];
    return ((map->texture != FATHOM_NONE || p->directed) && map->uv_set == set) ||
           (coat->texture != FATHOM_NONE && coat->uv_set == set);
}

fathom_status texturing_make_tangents(fathom_context *context, texturing *t) {
    const world *w = t->w;
    fathom_status status = FATHOM_OK;
    t->tangents = calloc(w->meshes.count + 1, sizeof *t->tangents);
    if (!t->tangents) return fail_memory(context, w->meshes.count * sizeof *t->tangents);
    for (size_t i = 0; i < 2 * w->meshes.count && status == FATHOM_OK; ++i) {
        const fathom_mesh *m = &w->meshes.items[i / 2];
        const unsigned set = i % 2;
        if (!takes_frame(&t->plans[m->material], set) || (m->tangents && set == 0)) continue;
        status = surface_tangents_make(context, m, set, &t->tangents[i / 2][set]);
    }
    return status;
}

/* ---- frames ---- */

/* Two axes orthogonal to the outward normal, along u and against v of an image. */
typedef struct frame_block {
    _Alignas(64) lanes3 t, b;
    uint32_t lies[LANES]; /* all ones: the axes are valid; else there are none, or they have length 0 */
} frame_block;

/* The mesh's generated tangent, for maps whose transform does not rotate the image but may mirror it. False:
 * the tangent is that of the image itself. */
static bool made_tangent(const points *p, unsigned i, const lookup *l, vec3_f32 *t) {
    const world *w = p->t->w;
    if (l->m[1] != 0 || l->m[3] != 0 || l->m[0] == 0 || !mesh_of(w, p->g->geometry[i])) return false;
    const surface_tangents *made = p->t->tangents[w->geometries.items[p->g->geometry[i]].first][l->uv_set];
    if (!made || !surface_made_tangent_at(p->g, w, i, made, t)) return false;
    if (l->m[0] < 0) *t = scale_f32(-1, *t);
    return true;
}

static inline float largest(float x, float y, float z) { return most(most(fabsf(x), fabsf(y)), fabsf(z)); }

/* Scales both alike, so that their products are within the range of float at any scale of the scene. */
static surface_uv near_one(const surface_uv *uv) {
    surface_uv out = *uv;
    const float by = 1 / most(largest(uv->du.x, uv->du.y, uv->du.z), largest(uv->dv.x, uv->dv.y, uv->dv.z));
    if (by > 0 && by < INFINITY) out.du = scale_f32(by, uv->du), out.dv = scale_f32(by, uv->dv);
    return out;
}

/* The tangent, of any length, and the sign of the bitangent. */
static vec3_f32 tangent_of(const points *p, unsigned i, const lookup *l, float *sign) {
    const surface_uv uv = near_one(&p->uv[l->uv_set][i]), *at = &uv;
    const float turn = l->m[0] * l->m[4] - l->m[1] * l->m[3] < 0 ? -1 : 1;
    vec3_f32 t;
    if (l->uv_set == 0 && surface_tangent_at(p->g, p->t->w, i, &t, sign)) return t;
    const vec3_f32 up = scale_f32(turn, sub_f32(scale_f32(l->m[1], at->du), scale_f32(l->m[0], at->dv)));
    t = scale_f32(turn, sub_f32(scale_f32(l->m[4], at->du), scale_f32(l->m[3], at->dv)));
    *sign = dot_f32(cross_f32(lane_f32(p->g->local.ns, i), t), up) < 0 ? -1 : 1;
    made_tangent(p, i, l, &t);
    return t;
}

static inline bool has_length(float square) { return (square > 0x1p-100f) & (square < 0x1p100f); }

static inline float to_unit(float square) { return 1 / sqrtf(has_length(square) ? square : 1); }

/* Makes frames from tangents t; b[0] holds the bitangents' signs. */
static void make_frames(const lanes3 n, frame_block *f) {
    for (int i = 0; i < LANES; ++i) {
        const float nx = n[0][i], ny = n[1][i], nz = n[2][i], sign = f->b[0][i];
        float x = f->t[0][i], y = f->t[1][i], z = f->t[2][i];
        const float by = 1 / largest(x, y, z);
        x *= by, y *= by, z *= by;
        const float square = x * x + y * y + z * z, unit = to_unit(square);
        x *= unit, y *= unit, z *= unit;
        const float along = nx * x + ny * y + nz * z;
        x -= along * nx, y -= along * ny, z -= along * nz;
        const float across = x * x + y * y + z * z, again = to_unit(across);
        x *= again, y *= again, z *= again;
        f->t[0][i] = x, f->t[1][i] = y, f->t[2][i] = z;
        f->b[0][i] = sign * (ny * z - nz * y);
        f->b[1][i] = sign * (nz * x - nx * z);
        f->b[2][i] = sign * (nx * y - ny * x);
        f->lies[i] = has_length(square) & has_length(across) ? ~0u : 0;
    }
}

/* The frames of one kind of map. */
static void find_frames(const points *p, uint32_t lanes, int kind, frame_block *f) {
    memset(f, 0, sizeof *f);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes), at = p->plan[i]->of[kind];
        if (at == NO_LOOKUP) continue;
        put_lane_f32(f->t, i, tangent_of(p, i, &p->plan[i]->lookups[at], &f->b[0][i]));
    }
    make_frames(p->g->local.ns, f);
}

/* ---- normals ---- */

/* A normal whose cosine to the viewer is below this is rotated towards the viewer. */
#define FACES_VIEWER 0x1p-6f

/* Normals that maps of this kind give, not unit; the outward normal in lanes without such a map. */
static void map_normals(const points *p, uint32_t lanes, int kind, lanes3 n) {
    const bool coat = kind == FATHOM_MAP_CLEARCOAT_NORMAL;
    float(*const outside)[LANES] = (float(*)[LANES])p->g->local.ns;
    frame_block f;
    lanes3 to = {{0}};
    find_frames(p, lanes, kind, &f);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes), at = p->plan[i]->of[kind];
        const fathom_material *m = p->plan[i]->material;
        if (at == NO_LOOKUP) continue;
        const float *rgb = p->values[i][at], scale = coat ? m->clearcoat_normal_scale : m->normal_scale;
        put_lane_f32(to, i, (vec3_f32){scale * (2 * rgb[0] - 1), scale * (2 * rgb[1] - 1), 2 * rgb[2] - 1});
    }
    for (int i = 0; i < LANES; ++i) {
        const float z = to[2][i] > 0x1p-6f ? to[2][i] : 0x1p-6f;
        for (int c = 0; c < 3; ++c) {
            const float turned = z * outside[c][i] + to[0][i] * f.t[c][i] + to[1][i] * f.b[c][i];
            n[c][i] = f.lies[i] ? turned : outside[c][i];
        }
    }
}

static const lookup *bump_of(const points *p, unsigned i) {
    const uint8_t at = p->plan[i]->of[FATHOM_MAP_BUMP];
    return at == NO_LOOKUP ? NULL : &p->plan[i]->lookups[at];
}

static uint32_t bumped_lanes(const points *p, uint32_t lanes) {
    uint32_t bumped = 0;
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes);
        if (bump_of(p, i)) bumped |= 1u << i;
    }
    return bumped;
}

/* How fast height maps rise along one side of their images: finite differences over a footprint, and at least
 * a texel. */
static void find_rises(const points *p, uint32_t lanes, unsigned side, float rise[LANES]) {
    texture_queries q = {.count = 0};
    float rgba[4][TEXTURE_BLOCK];
    unsigned j = 0;
    for (uint32_t left = lanes; left; left &= left - 1, ++j) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        const lookup *l = bump_of(p, i);
        const surface_uv *at = &p->uv[l->uv_set][i];
        uint32_t size[2];
        texture_size(p->t->cache, l->texture, &size[0], &size[1]);
        texturing_place_lookup(l, at->u, at->v, width_of_lookup(p, l, i), &q);
        rise[i] = fmaxf(q.width[j], 1 / (float)size[side]); /* the step, for now */
        (side ? q.v : q.u)[j] += rise[i];
    }
    texture_lookup(p->t->cache, &q, rgba);
    j = 0;
    for (uint32_t left = lanes; left; left &= left - 1, ++j) {
        const unsigned i = (unsigned)__builtin_ctz(left), at = p->plan[i]->of[FATHOM_MAP_BUMP];
        const fathom_material *m = p->plan[i]->material;
        const uint32_t channel = m->maps[FATHOM_MAP_BUMP].channel;
        rise[i] = m->bump_scale * (rgba[channel][j] - p->values[i][at][channel]) / rise[i];
    }
}

/* The gradient of a height map along the surface (Blinn, "Simulation of Wrinkled Surfaces", 1978). */
static vec3_f32 slope_of(const points *p, unsigned i, float rise_u, float rise_v) {
    const vec3_f32 n = lane_f32(p->g->local.ns, i);
    const lookup *l = bump_of(p, i);
    const surface_uv *at = &p->uv[l->uv_set][i];
    const vec3_f32 up = cross_f32(at->dv, n), right = cross_f32(n, at->du);
    const double area = dot_f64(widen(n), cross_f64(widen(at->du), widen(at->dv)));
    const float du = rise_u * l->m[0] + rise_v * l->m[3], dv = rise_u * l->m[1] + rise_v * l->m[4];
    const vec3_f64 along = madd_f64(scale_f64((double)du, widen(up)), (double)dv, widen(right));
    const vec3_f32 slope = narrow(scale_f64(1 / area, along));
    return area != 0 && finite_f32(slope) ? slope : (vec3_f32){0, 0, 0};
}

static bool make_unit(vec3_f32 *v) {
    const float square = dot_f32(*v, *v);
    if (!has_length(square)) return false;
    *v = scale_f32(to_unit(square), *v);
    return true;
}

static void bump_normals(const points *p, uint32_t lanes, lanes3 n) {
    float rise[2][LANES];
    if (!lanes) return;
    for (unsigned side = 0; side < 2; ++side) find_rises(p, lanes, side, rise[side]);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes);
        vec3_f32 turned = lane_f32(n, i);
        if (make_unit(&turned)) put_lane_f32(n, i, sub_f32(turned, slope_of(p, i, rise[0][i], rise[1][i])));
    }
}

/* Flips the outward normals n to the viewer's side and sets them, in lanes where they have a length. */
static void set_normals(const points *p, uint32_t lanes, const surface_block *s, const lanes3 n,
                        float (*to)[LANES]) {
    const float(*outside)[LANES] = (const float(*)[LANES])p->g->local.ns;
    uint32_t wanted[LANES];
    for (int i = 0; i < LANES; ++i) wanted[i] = lanes >> i & 1;
    for (int i = 0; i < LANES; ++i) {
        float x = n[0][i], y = n[1][i], z = n[2][i];
        const float vx = s->v[0][i], vy = s->v[1][i], vz = s->v[2][i];
        const float same =
            outside[0][i] * s->base[0][i] + outside[1][i] * s->base[1][i] + outside[2][i] * s->base[2][i];
        const float square = x * x + y * y + z * z, unit = to_unit(square), side = same < 0 ? -1 : 1;
        x = side * (unit * x), y = side * (unit * y), z = side * (unit * z);
        const float facing = x * vx + y * vy + z * vz, less = FACES_VIEWER - facing;
        const float ux = x + less * vx, uy = y + less * vy, uz = z + less * vz;
        const float up = ux * ux + uy * uy + uz * uz, again = to_unit(up);
        const bool turn = facing < FACES_VIEWER;
        const bool set = wanted[i] & has_length(square) & (!turn | has_length(up));
        x = turn ? again * ux : x, y = turn ? again * uy : y, z = turn ? again * uz : z;
        to[0][i] = set ? x : to[0][i], to[1][i] = set ? y : to[1][i], to[2][i] = set ? z : to[2][i];
    }
}

static void turn_shading(const points *p, uint32_t lanes, surface_block *s) {
    lanes3 n;
    map_normals(p, lanes, FATHOM_MAP_NORMAL, n);
    bump_normals(p, bumped_lanes(p, lanes), n);
    set_normals(p, lanes, s, n, s->ns);
}

/* KHR_materials_clearcoat: the coat does not inherit the normals of the layers below it. */
static void turn_coats(const points *p, uint32_t lanes, surface_block *s) {
    uint32_t mapped = 0;
    lanes3 n;
    for (uint32_t left = lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        put_lane_f32(s->coat, i, lane_f32(s->base, i));
        if (p->plan[i]->of[FATHOM_MAP_CLEARCOAT_NORMAL] != NO_LOOKUP) mapped |= 1u << i;
    }
    if (!mapped) return;
    map_normals(p, mapped, FATHOM_MAP_CLEARCOAT_NORMAL, n);
    set_normals(p, mapped, s, n, s->coat);
}

void texturing_turn_normals(const points *p, surface_block *s) {
    uint32_t mapped = 0, coated = 0;
    for (uint32_t left = p->lanes; left; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctz(left);
        const uint8_t *of = p->plan[i]->of;
        if (of[FATHOM_MAP_NORMAL] != NO_LOOKUP || of[FATHOM_MAP_BUMP] != NO_LOOKUP) mapped |= 1u << i;
        if (p->plan[i]->coat_turns) coated |= 1u << i;
    }
    if (!(mapped | coated)) return;
    memcpy(s->base, s->ns, sizeof s->base);
    s->mapped = mapped, s->coated = coated;
    if (mapped) turn_shading(p, mapped, s);
    if (coated) turn_coats(p, coated, s);
}

void texturing_direct(const points *p, unsigned i, const fathom_material *m, surface_block *s) {
    const fathom_map *map = map_of_frame(p->plan[i]);
    lookup l = {.uv_set = map->texture == FATHOM_NONE ? 0 : map->uv_set};
    frame_block f;
    if (!p->plan[i]->directed) return;
    memcpy(l.m, map->transform, sizeof l.m);
    memset(&f, 0, sizeof f);
    put_lane_f32(f.t, i, tangent_of(p, i, &l, &f.b[0][i]));
    make_frames(p->g->local.ns, &f);
    if (!f.lies[i]) return;
    const float cosine = cosf(m->anisotropy_rotation), sine = sinf(m->anisotropy_rotation);
    put_lane_f32(s->along, i, madd_f32(scale_f32(cosine, lane_f32(f.t, i)), sine, lane_f32(f.b, i)));
    s->directed |= 1u << i;
}
