/* Safe origins for rays that leave a surface: the offset covers the ray's own rounding
 * (surface/kernels/surfaces.c) and `self_hit`, the error of the intersector for an origin that is exact. See
 * placed.h for this error in instances. */
#include "surface/gather.h"

#include "math/lane.h"
#include "surface/half.h"
#include "surface/local_hit.h"
#include "surface/placed.h"

#include <string.h>

static const double unit_round = 0x1p-24;

/* ---- instances ---- */

double surface_stretch_along(const world_instance *instance, vec3_f64 n) {
    const double along[3] = {fabs(n.x), fabs(n.y), fabs(n.z)};
    double sum = 0;
    for (int i = 0; i < 9; ++i) sum += along[i / 3] * fabs((double)instance->to_object[i / 3][i % 3]);
    return sum;
}

/* Embree interpolates the components of a moving transform in float. The rotation is a sum of two
 * quaternions, normalised by an inverse square root: 3 u for each number and 4 u for the root. An entry of
 * its matrix, of two products, doubles this and rounds three times: 17 u. The scale adds 3 u, the products
 * with it 3 u more. So a point has an error of 24 u of the sum of the terms' sizes, and the translation one
 * of 3 u of itself. */
#define MOVED_TURN (24 * 0x1p-24)
#define MOVED_SHIFT (3 * 0x1p-24)

double surface_moved_along(const world_instance *instance, vec3_f64 n, vec3_f64 object_p) {
    const double at[3] = {fabs(object_p.x), fabs(object_p.y), fabs(object_p.z)};
    double reach = 0, shift = 0;
    const double along[3] = {fabs(n.x), fabs(n.y), fabs(n.z)};
    for (int i = 0; i < 3; ++i) {
        const float *m = instance->to_world[i];
        double square = 0;
        for (int k = 0; k < 3; ++k)
            square += (double)instance->to_world[k][i] * (double)instance->to_world[k][i];
        reach += sqrt(square) * at[i]; /* a column's length, which the rotation keeps */
        shift += along[i] * fabs((double)m[3]);
    }
    return MOVED_TURN * (along[0] + along[1] + along[2]) * reach + MOVED_SHIFT * shift;
}

static void to_world(const world_instance *instance, local_block *b, unsigned i) {
    const vec3_f64 object_p = lane_f64(b->p, i);
    placed_hit hit = {object_p, lane_f64(b->n, i), b->self_hit[i], lane_f32(b->ns, i), lane_f32(b->lift, i)};
    hit = placed_to_world(instance, hit);
    if (instance->moving) hit.self_hit += surface_moved_along(instance, hit.n, object_p);
    put_lane_f64(b->p, i, hit.p);
    put_lane_f64(b->n, i, hit.n);
    b->self_hit[i] = hit.self_hit;
    put_lane_f32(b->ns, i, hit.ns);
    put_lane_f32(b->lift, i, hit.lift);
}

/* Up to this many lanes of one instance, single lanes are as fast as the kernel. */
#define FEW_LANES 3

static void leave_instances(surface_gather *g, const world *w, const surface_kernels *kernels) {
    for (uint32_t left = w->moves ? g->instances : 0; left; left &= left - 1)
        to_world(g->placed[lane_first(left)], &g->local, lane_first(left));
    for (uint32_t left = w->moves ? 0 : g->instances, mine; left; left &= ~mine) {
        const uint32_t id = g->instance[lane_first(left)];
        mine = 0;
        for (unsigned i = 0; i < LANES; ++i) mine |= g->instance[i] == id ? 1u << i : 0;
        mine &= left;
        if (__builtin_popcount(mine) > FEW_LANES) {
            kernels->hits_to_world(&w->instances.items[id], mine, &g->local);
            continue;
        }
        for (uint32_t one = mine; one; one &= one - 1)
            to_world(&w->instances.items[id], &g->local, lane_first(one));
    }
}

static void add_corner_error(const facet_block *f, local_block *b, unsigned i) {
    double size[3] = {0, 0, 0}, sum = 0;
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 3; ++k) size[c] = fmax(size[c], fabs((double)f->corner[k][c][i]));
        sum += fabs(b->n[c][i]) * size[c];
    }
    b->self_hit[i] += SURFACE_BENT * unit_round * sum;
}

/* ---- hits ---- */

void surface_gather_begin(surface_gather *g) {
    g->count = 0, g->instances = 0, g->shaped = 0, g->faceted = false;
    g->facets.smooth = false;
}

/* Clears all lanes, for hits that are added one by one: the kernels compute unused lanes too. */
static void clear_lanes(surface_gather *g) {
    memset(g->facets.corner, 0, sizeof g->facets.corner);
    memset(g->facets.normal, 0, sizeof g->facets.normal);
    memset(g->facets.facet, 0, sizeof g->facets.facet);
    memset(g->facets.has_normals, 0, sizeof g->facets.has_normals);
    memset(g->local.lift, 0, sizeof g->local.lift);
    memset(g->local.smooth, 0, sizeof g->local.smooth);
}

/* Only fetches a triangle's corners and normals; facets() computes points and normals from them. */
static void add_moving_facet(surface_gather *g, unsigned i, const world *w, const world_geometry *geometry) {
    const bool normals = w->meshes.items[geometry->first].normals != NULL;
    vec3_f32 corner[3], normal[3];
    world_corners_when(w, geometry, g->primitive[i], g->time[i], corner, normal);
    for (int k = 0; k < 3; ++k) {
        put_lane_f32(g->facets.corner[k], i, corner[k]);
        if (normals) put_lane_f32(g->facets.normal[k], i, normal[k]);
    }
    g->facets.facet[i] = ~0u;
    g->facets.has_normals[i] = normals ? ~0u : 0;
    g->facets.smooth |= normals;
    g->faceted = true;
    g->shaped |= 1u << i;
}

static void add_facet(surface_gather *g, unsigned i, const fathom_mesh *mesh, uint32_t triangle) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k) put_lane_f32(g->facets.corner[k], i, load_f32(mesh_vertex(mesh, index[k])));
    g->facets.facet[i] = ~0u;
    g->faceted = true;
    if (!mesh->normals) return;
    index = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k)
        put_lane_f32(g->facets.normal[k], i,
                     load_f32(mesh_row(mesh->normals, mesh->normal_stride, index[k])));
    g->facets.has_normals[i] = ~0u;
    g->facets.smooth = true;
}

/* Adds the half of the quad that the ray hits, as a triangle. */
static void add_half(surface_gather *g, unsigned i, const world_quad *quad, const local_ray *local) {
    static const int halves[2][3] = {{0, 1, 3}, {2, 3, 1}};
    const vec3_f32 *v = quad->corner;
    bool second = half_is_second(widen(v[0]), widen(v[1]), widen(v[2]), widen(v[3]), local->org, local->dir);
    for (int k = 0; k < 3; ++k) put_lane_f32(g->facets.corner[k], i, v[halves[second][k]]);
    g->facets.facet[i] = ~0u;
    g->faceted = true;
}

static void add_hit(surface_gather *g, unsigned i, local_hit hit) {
    put_lane_f64(g->local.p, i, hit.p);
    put_lane_f64(g->local.n, i, hit.n);
    put_lane_f32(g->local.ns, i, hit.ns);
    g->local.self_hit[i] = hit.self_hit;
}

static void add_primitive(surface_gather *g, unsigned i, const world *w, const local_ray *local) {
    const uint32_t primitive = g->primitive[i];
    if (g->geometry[i] == TRACE_PLANE) {
        add_hit(g, i, local_plane(&w->planes.items[primitive], local));
        return;
    }
    const world_geometry *geometry = &w->geometries.items[g->geometry[i]];
    const uint32_t item = geometry->first + primitive;
    switch (geometry->kind) {
    case WORLD_SPHERES: add_hit(g, i, local_sphere(&w->spheres.items[item], local)); break;
    case WORLD_QUADS: add_half(g, i, &w->quads.items[item], local); break;
    case WORLD_MESH:
        if (geometry->moving)
            add_moving_facet(g, i, w, geometry);
        else
            add_facet(g, i, &w->meshes.items[geometry->first], primitive);
    }
}

void surface_gather_add(surface_gather *g, const world *w, const trace_block *block, size_t lane) {
    const trace_rays *r = &block->rays;
    if (!g->count) clear_lanes(g);
    unsigned i = g->count++;
    vec3_f32 dir = {r->dir_x[lane], r->dir_y[lane], r->dir_z[lane]};
    local_ray local = {vec_f64((double)r->org_x[lane], (double)r->org_y[lane], (double)r->org_z[lane]),
                       widen(dir), r->t_near[lane]};
    g->geometry[i] = block->hits.geometry[lane];
    g->primitive[i] = block->hits.primitive[lane];
    g->instance[i] = block->hits.instance[lane];
    put_lane_f32(g->local.ray, i, dir);
    if (w->moves) g->time[i] = r->time[lane];
    if (g->geometry[i] != TRACE_PLANE && g->instance[i] != FATHOM_NONE) {
        const world_instance *instance = &w->instances.items[g->instance[i]];
        if (w->moves) {
            instance = world_instance_when(w, g->instance[i], g->time[i], &g->moved[i]);
            g->placed[i] = instance;
        }
        local.org = placed_point(instance->to_object, local.org);
        local.dir = placed_vector(instance->to_object, local.dir);
        g->instances |= 1u << i;
    }
    put_lane_f64(g->local.org, i, local.org);
    put_lane_f64(g->local.dir, i, local.dir);
    add_primitive(g, i, w, &local);
}

/* The mesh that all lanes hit, in one instance or in the root, or a run of quads in the root without flat
 * ones; else NULL. Also NULL for instances in a world that moves, because each lane would have its own
 * transform. */
static const world_geometry *common_facets(const world *w, const trace_hits *hits) {
    uint32_t differ = 0;
    const uint32_t id = hits->geometry[0], instance = hits->instance[0];
    for (int i = 0; i < LANES; ++i) differ |= (hits->geometry[i] ^ id) | (hits->instance[i] ^ instance);
    if (differ || id == TRACE_PLANE) return NULL;
    const bool rooted = instance == FATHOM_NONE;
    const world_geometry *met = &w->geometries.items[id];
    if (met->moving || (w->moves && !rooted)) return NULL;
    return met->kind == WORLD_MESH || (met->kind == WORLD_QUADS && !met->flat && rooted) ? met : NULL;
}

static bool same_primitive(const uint32_t primitive[LANES]) {
    uint32_t differ = 0;
    for (int i = 0; i < LANES; ++i) differ |= primitive[i] ^ primitive[0];
    return !differ;
}

/* Minimum number of triangles of a mesh that does not stay in the caches between waves, at about 20 bytes
 * each. */
#define LARGE_MESH (1u << 20)

/* The large mesh that the first lane hit, or NULL. The other lanes have probably hit it too. */
static const fathom_mesh *large_mesh(const world *w, const trace_hits *hits) {
    uint32_t id = hits->geometry[0];
    if (id >= w->geometries.count) return NULL;
    const world_geometry *geometry = &w->geometries.items[id];
    return geometry->kind == WORLD_MESH && geometry->count >= LARGE_MESH ? world_mesh(w, id) : NULL;
}

void surface_ask_indices(const world *w, const trace_hits *hits) {
    const fathom_mesh *mesh = large_mesh(w, hits);
    for (int i = 0; mesh && i < LANES; ++i) {
        if (hits->geometry[i] == hits->geometry[0])
            __builtin_prefetch(mesh->indices + 3 * (size_t)hits->primitive[i]);
    }
}

static void ask_rows(const float *rows, size_t stride, const uint32_t vertex[3]) {
    for (int k = 0; k < 3; ++k) __builtin_prefetch((const char *)rows + stride * vertex[k]);
}

void surface_ask_corners(const world *w, const trace_hits *hits) {
    const fathom_mesh *mesh = large_mesh(w, hits);
    if (!mesh) return;
    const bool has_normals = mesh->normals && !mesh->normal_indices;
    for (int i = 0; i < LANES; ++i) {
        if (hits->geometry[i] != hits->geometry[0]) continue;
        const uint32_t *vertex = mesh->indices + 3 * (size_t)hits->primitive[i];
        ask_rows(mesh->positions, mesh->position_stride, vertex);
        if (has_normals) ask_rows(mesh->normals, mesh->normal_stride, vertex);
    }
}

fathom_id surface_gather_material(const surface_gather *g, const world *w, unsigned i) {
    if (g->geometry[i] == TRACE_PLANE) return w->planes.items[g->primitive[i]].material;
    return world_material(w, g->geometry[i], g->primitive[i], g->instance[i]);
}

bool surface_gather_block(surface_gather *g, const world *w, const surface_kernels *kernels,
                          const trace_block *block) {
    const trace_rays *rays = &block->rays;
    const trace_hits *hits = &block->hits;
    const world_geometry *met = common_facets(w, hits);
    if (!met) {
        for (unsigned i = 0; i < LANES; ++i) surface_gather_add(g, w, block, i);
        return false;
    }
    memcpy(g->geometry, hits->geometry, sizeof g->geometry);
    memcpy(g->primitive, hits->primitive, sizeof g->primitive);
    memcpy(g->instance, hits->instance, sizeof g->instance);
    memcpy(g->local.ray[0], rays->dir_x, sizeof rays->dir_x);
    memcpy(g->local.ray[1], rays->dir_y, sizeof rays->dir_y);
    memcpy(g->local.ray[2], rays->dir_z, sizeof rays->dir_z);
    const bool quads = met->kind == WORLD_QUADS;
    if (quads)
        kernels->quad_gather(&w->quads.items[met->first], hits->primitive, trace_origins(rays),
                             trace_directions(rays), &g->facets, &g->local);
    else
        kernels->facet_gather(&w->meshes.items[met->first], hits->primitive, trace_origins(rays),
                              trace_directions(rays), &g->facets, &g->local);
    if (hits->instance[0] != FATHOM_NONE) {
        kernels->rays_to_object(&w->instances.items[hits->instance[0]], &g->local);
        g->instances = (1u << LANES) - 1;
    }
    g->count = LANES;
    g->faceted = true;
    return !quads || same_primitive(hits->primitive);
}

/* Unused lanes repeat the last hit. */
static void pad(surface_gather *g) {
    local_block *b = &g->local;
    for (unsigned i = g->count, last = g->count - 1; i < LANES; ++i) {
        put_lane_f64(b->p, i, lane_f64(b->p, last));
        put_lane_f64(b->n, i, lane_f64(b->n, last));
        put_lane_f32(b->ns, i, lane_f32(b->ns, last));
        put_lane_f32(b->ray, i, lane_f32(b->ray, last));
        put_lane_f32(b->lift, i, lane_f32(b->lift, last));
        b->self_hit[i] = b->self_hit[last], b->smooth[i] = b->smooth[last];
    }
}

void surface_gather_end(surface_gather *g, const world *w, const surface_kernels *kernels, bool lift,
                        bool automatic, surface_block *s) {
    if (g->faceted) kernels->facets(&g->facets, lift, &g->local);
    for (uint32_t left = g->shaped; left; left &= left - 1)
        add_corner_error(&g->facets, &g->local, (unsigned)__builtin_ctz(left));
    leave_instances(g, w, kernels);
    pad(g);
    kernels->surfaces(&g->local, automatic, s);
}
