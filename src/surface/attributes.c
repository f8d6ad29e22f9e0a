#include "surface/attributes.h"

#include "math/lane.h"
#include "surface/placed.h"

#include <string.h>

static const float pi = 3.14159265f;

/* ---- meshes ---- */

static const fathom_mesh *mesh_of(const world *w, uint32_t geometry) {
    if (geometry >= w->geometries.count || w->geometries.items[geometry].kind != WORLD_MESH) return NULL;
    return world_mesh(w, geometry);
}

/* Texture coordinates of a triangle's corners. */
static void corner_uvs(const fathom_mesh *m, uint32_t triangle, unsigned set, float uv[3][2]) {
    static const float barycentric[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    const uint32_t *indices = set || !m->uv_indices ? m->indices : m->uv_indices;
    const float *values = set ? m->uvs_1 : m->uvs;
    const size_t stride = set ? m->uv_1_stride : m->uv_stride;
    memcpy(uv, barycentric, sizeof barycentric);
    for (int k = 0; values && k < 3; ++k)
        memcpy(uv[k], mesh_row(values, stride, indices[3 * (size_t)triangle + (size_t)k]), 2 * sizeof(float));
}

/* Texture coordinates of a quad's half with corners (0,1,3), and of the half (2,3,1). */
static const float half_uvs[2][3][2] = {{{0, 1}, {1, 1}, {0, 0}}, {{1, 0}, {0, 0}, {1, 1}}};

static void mix_uvs(const float uv[3][2], const float weight[3], float out[2]) {
    for (int c = 0; c < 2; ++c) out[c] = weight[0] * uv[0][c] + weight[1] * uv[1][c] + weight[2] * uv[2][c];
}

/* From the spherical angles of the unit normal. */
static void normal_uv(vec3_f32 n, float uv[2]) {
    const float phi = atan2f(n.y, n.x);
    uv[0] = phi < 0 ? phi / (2 * pi) + 1 : phi / (2 * pi);
    uv[1] = acosf(n.z > 1 ? 1 : n.z < -1 ? -1 : n.z) / pi;
}

void surface_uv_of(const world *w, uint32_t geometry, uint32_t primitive, bool second, const float weight[3],
                   unsigned set, float out[2]) {
    const fathom_mesh *m = mesh_of(w, geometry);
    float uv[3][2];
    if (w->geometries.items[geometry].kind == WORLD_SPHERES) {
        normal_uv(load_f32(weight), out);
        return;
    }
    if (m)
        corner_uvs(m, primitive, set, uv);
    else
        memcpy(uv, half_uvs[second], sizeof uv);
    mix_uvs(uv, weight, out);
}

bool surface_color_of(const world *w, uint32_t geometry, uint32_t primitive, const float weight[3],
                      float rgba[4]) {
    const uint32_t cloud = geometry < w->geometries.count ? w->geometries.items[geometry].cloud : 0;
    const fathom_mesh *m = cloud ? &w->meshes.items[cloud - 1] : mesh_of(w, geometry);
    for (int c = 0; c < 4; ++c) rgba[c] = 1;
    if (!m || !m->colors) return false;
    if (cloud) {
        memcpy(rgba, mesh_row(m->colors, m->color_stride, primitive), m->color_channels * sizeof *rgba);
        return true;
    }
    const float *at[3];
    for (size_t k = 0; k < 3; ++k)
        at[k] = mesh_row(m->colors, m->color_stride, m->indices[3 * (size_t)primitive + k]);
    /* An alpha of 1 at all corners is 1 between them, too. */
    for (unsigned c = 0; c < m->color_channels; ++c)
        rgba[c] = at[0][c] + weight[1] * (at[1][c] - at[0][c]) + weight[2] * (at[2][c] - at[0][c]);
    return true;
}

/* ---- a lane ---- */

static const world_instance *instance_of(const surface_gather *g, const world *w, unsigned i) {
    const bool placed = g->geometry[i] != TRACE_PLANE && g->instance[i] != FATHOM_NONE;
    return placed ? (w->moves ? g->placed[i] : &w->instances.items[g->instance[i]]) : NULL;
}

static vec3_f32 to_world(const world_instance *instance, vec3_f32 v) {
    if (!instance) return v;
    const float(*m)[4] = instance->to_world;
    return (vec3_f32){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                      m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                      m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

static bool mirrors(const world_instance *instance) {
    if (!instance) return false;
    const vec3_f32 x = to_world(instance, (vec3_f32){1, 0, 0}), y = to_world(instance, (vec3_f32){0, 1, 0}),
                   z = to_world(instance, (vec3_f32){0, 0, 1});
    return dot_f32(cross_f32(x, y), z) < 0;
}

static bool is_second_half(const surface_gather *g, const world *w, unsigned i) {
    const world_quad *quad = &w->quads.items[w->geometries.items[g->geometry[i]].first + g->primitive[i]];
    const vec3_f32 at = lane_f32(g->facets.corner[0], i);
    return at.x != quad->corner[0].x || at.y != quad->corner[0].y || at.z != quad->corner[0].z;
}

/* Solves for du and dv: the sides of the facet are linear combinations of them. */
static void facet_uv(const surface_gather *g, const world_instance *instance, unsigned i,
                     const float uv[3][2], surface_uv *out) {
    const float weight[3] = {g->local.weight[0][i], g->local.weight[1][i], g->local.weight[2][i]};
    const vec3_f32 a = lane_f32(g->facets.corner[0], i);
    const vec3_f32 ab = to_world(instance, sub_f32(lane_f32(g->facets.corner[1], i), a)),
                   ac = to_world(instance, sub_f32(lane_f32(g->facets.corner[2], i), a));
    const float bu = uv[1][0] - uv[0][0], bv = uv[1][1] - uv[0][1];
    const float cu = uv[2][0] - uv[0][0], cv = uv[2][1] - uv[0][1];
    const float determinant = bu * cv - cu * bv, inverse = determinant != 0 ? 1 / determinant : 0;
    float at[2];
    mix_uvs(uv, weight, at);
    *out = (surface_uv){.u = at[0],
                        .v = at[1],
                        .du = scale_f32(inverse, sub_f32(scale_f32(cv, ab), scale_f32(bv, ac))),
                        .dv = scale_f32(inverse, sub_f32(scale_f32(bu, ac), scale_f32(cu, ab)))};
}

/* The sine has a minimum, because du would be 0 at a pole. */
static void sphere_uv(const surface_gather *g, const world *w, const world_instance *instance, unsigned i,
                      surface_uv *out) {
    const world_sphere *sphere =
        &w->spheres.items[w->geometries.items[g->geometry[i]].first + g->primitive[i]];
    vec3_f64 p = {g->local.p[0][i], g->local.p[1][i], g->local.p[2][i]};
    if (instance) p = placed_point(instance->to_object, p);
    const vec3_f32 n = narrow(normalize_f64(sub_f64(p, world_sphere_center(sphere))));
    const float flat = n.x * n.x + n.y * n.y, sine = sqrtf(flat > 1e-6f ? flat : 1e-6f);
    const float r = (float)world_sphere_radius(sphere);
    const float x = flat > 0 ? n.x / sqrtf(flat) : 1, y = flat > 0 ? n.y / sqrtf(flat) : 0;
    float uv[2];
    normal_uv(n, uv);
    *out = (surface_uv){
        .u = uv[0],
        .v = uv[1],
        .du = to_world(instance, (vec3_f32){-y * sine * 2 * pi * r, x * sine * 2 * pi * r, 0}),
        .dv = to_world(instance, (vec3_f32){n.z * x * pi * r, n.z * y * pi * r, -sine * pi * r})};
}

static void plane_uv(const surface_gather *g, const world *w, unsigned i, surface_uv *out) {
    const world_plane *plane = &w->planes.items[g->primitive[i]];
    const vec3_f64 p = {g->local.p[0][i], g->local.p[1][i], g->local.p[2][i]},
                   from = sub_f64(p, widen(plane->point));
    *out = (surface_uv){.u = (float)dot_f64(from, widen(plane->u)),
                        .v = (float)dot_f64(from, widen(plane->v)),
                        .du = plane->u,
                        .dv = plane->v};
}

void surface_uv_at(const surface_gather *g, const world *w, unsigned i, unsigned set, surface_uv *out) {
    const world_instance *instance = instance_of(g, w, i);
    float uv[3][2];
    if (g->geometry[i] == TRACE_PLANE) {
        plane_uv(g, w, i, out);
        return;
    }
    switch (w->geometries.items[g->geometry[i]].kind) {
    case WORLD_SPHERES: sphere_uv(g, w, instance, i, out); return;
    case WORLD_QUADS: memcpy(uv, half_uvs[is_second_half(g, w, i)], sizeof uv); break;
    case WORLD_MESH: corner_uvs(world_mesh(w, g->geometry[i]), g->primitive[i], set, uv); break;
    }
    facet_uv(g, instance, i, uv, out);
}

/* Moves a vector with a triangle: it keeps its weights of two sides, and its part along the unit normal. */
static vec3_f32 moved_with(const vec3_f32 from[3], const vec3_f32 to[3], vec3_f32 v) {
    const vec3_f64 ab = widen(sub_f32(from[1], from[0])), ac = widen(sub_f32(from[2], from[0])),
                   n = cross_f64(ab, ac), at = widen(v);
    const double square = dot_f64(n, n);
    if (!(square > 0)) return v;
    const double b = dot_f64(cross_f64(at, ac), n) / square, c = dot_f64(cross_f64(ab, at), n) / square;
    const vec3_f64 to_ab = widen(sub_f32(to[1], to[0])), to_ac = widen(sub_f32(to[2], to[0])),
                   to_n = normalize_f64(cross_f64(to_ab, to_ac));
    return narrow(madd_f64(madd_f64(scale_f64(b, to_ab), c, to_ac), dot_f64(at, n) / sqrt(square), to_n));
}

/* Moves a tangent of triangle i's mesh, which belongs to these positions, to where the hit's corners are. */
static vec3_f32 moved_tangent(const surface_gather *g, const fathom_mesh *m, unsigned i,
                              const float *positions, size_t stride, vec3_f32 tangent) {
    const uint32_t *index = m->indices + 3 * (size_t)g->primitive[i];
    vec3_f32 from[3], to[3];
    for (int k = 0; k < 3; ++k) {
        from[k] = load_f32(mesh_row(positions, stride, index[k]));
        to[k] = lane_f32(g->facets.corner[k], i);
    }
    return moved_with(from, to, tangent);
}

bool surface_tangent_at(const surface_gather *g, const world *w, unsigned i, vec3_f32 *tangent, float *sign) {
    const fathom_mesh *m = mesh_of(w, g->geometry[i]);
    if (!m || !m->tangents) return false;
    const world_instance *instance = instance_of(g, w, i);
    vec3_f32 sum = {0, 0, 0};
    float turn = 0;
    for (int k = 0; k < 3; ++k) {
        const float weight = g->local.weight[k][i],
                    *at = mesh_row(m->tangents, m->tangent_stride,
                                   m->indices[3 * (size_t)g->primitive[i] + (size_t)k]);
        sum = madd_f32(sum, weight, load_f32(at));
        turn += weight * at[3];
    }
    if (m->key_count) sum = moved_tangent(g, m, i, m->key_positions, 3 * sizeof(float), sum);
    *tangent = to_world(instance, sum);
    *sign = (turn < 0) != mirrors(instance) ? -1 : 1;
    return true;
}

/* They are made of the vertices at the opening of the shutter. */
bool surface_made_tangent_at(const surface_gather *g, const world *w, unsigned i,
                             const surface_tangents *made, vec3_f32 *tangent) {
    const float weight[3] = {g->local.weight[0][i], g->local.weight[1][i], g->local.weight[2][i]};
    const fathom_mesh *m = world_mesh(w, g->geometry[i]);
    vec3_f32 at;
    if (!surface_tangents_at(made, m, g->primitive[i], weight, &at)) return false;
    if (w->geometries.items[g->geometry[i]].moving)
        at = moved_tangent(g, m, i, m->positions, m->position_stride, at);
    *tangent = to_world(instance_of(g, w, i), at);
    return true;
}

bool surface_color_at(const surface_gather *g, const world *w, unsigned i, float rgba[4]) {
    const float weight[3] = {g->local.weight[0][i], g->local.weight[1][i], g->local.weight[2][i]};
    return surface_color_of(w, g->geometry[i], g->primitive[i], weight, rgba);
}
