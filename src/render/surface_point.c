/* Where a ray that leaves may start: as far off as its own rounding takes it (shade/kernels/surfaces.c), and
 * `beside`, how wrong the intersector may be about a start that it knows exactly.
 *
 * With u = 2^-24, in an instance the start is carried to object space, o_i = Σ A_ij s_j + T_i, and rounded
 * there. Our own tracers do that with A and T = to_object as given and one rounding, u |o_i|. Embree inverts
 * to_world in float: its A is off by E_ij (to_object_error), and its T = -A t, with t the translation of
 * to_world, by that and by three roundings of its products; three more enter when the start is carried. As A
 * s + T = A (s
 * - t), E counts by |s - t|: in all Σ_j E_ij |s_j - t_j| + 6 u Σ_j |A_ij| (|s_j| + |t_j|) on axis i. A
 * distance e along the object's normal n is e / |Aᵀn| in the world, whose normal is Aᵀn / |Aᵀn|. */
#include "render/surface_point.h"

#include "render/local_hit.h"

#include <string.h>

static const double unit_round = 0x1p-24;

ray_hit ray_hit_load(const trace_block *b, size_t i) {
    return (ray_hit){.org = {b->rays.org_x[i], b->rays.org_y[i], b->rays.org_z[i]},
                     .dir = {b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]},
                     .t_near = b->rays.t_near[i],
                     .geometry = b->hits.geometry[i],
                     .primitive = b->hits.primitive[i],
                     .instance = b->hits.instance[i]};
}

/* ---- maps in double ---- */

static vec3_f64 map_vector(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[0][1] * v.y + (double)m[0][2] * v.z,
                      (double)m[1][0] * v.x + (double)m[1][1] * v.y + (double)m[1][2] * v.z,
                      (double)m[2][0] * v.x + (double)m[2][1] * v.y + (double)m[2][2] * v.z};
}

static vec3_f64 translation(const float m[3][4]) {
    return (vec3_f64){(double)m[0][3], (double)m[1][3], (double)m[2][3]};
}

static vec3_f64 map_point(const float m[3][4], vec3_f64 p) {
    return add_f64(map_vector(m, p), translation(m));
}

/* Mᵀ v */
static vec3_f64 map_normal(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[1][0] * v.y + (double)m[2][0] * v.z,
                      (double)m[0][1] * v.x + (double)m[1][1] * v.y + (double)m[2][1] * v.z,
                      (double)m[0][2] * v.x + (double)m[1][2] * v.y + (double)m[2][2] * v.z};
}

static vec3_f64 absolute(vec3_f64 v) { return (vec3_f64){fabs(v.x), fabs(v.y), fabs(v.z)}; }

/* How far a tracer may carry a point of the world wrong along the normal n of the object. */
static double carried_along(const world_instance *instance, vec3_f64 n, vec3_f64 p) {
    vec3_f64 shift = translation(instance->to_world);
    vec3_f64 from = absolute(sub_f64(p, shift)), sum = add_f64(absolute(p), absolute(shift));
    const double along[3] = {fabs(n.x), fabs(n.y), fabs(n.z)};
    double error = 0;
    for (int i = 0; i < 3; ++i) {
        const float *a = instance->to_object[i], *e = instance->to_object_error[i];
        double products =
            fabs((double)a[0]) * sum.x + fabs((double)a[1]) * sum.y + fabs((double)a[2]) * sum.z;
        double map = (double)e[0] * from.x + (double)e[1] * from.y + (double)e[2] * from.z;
        error += along[i] * (map + 6 * unit_round * products);
    }
    return error;
}

static vec3_f64 unit_of(vec3_f64 v) { return scale_f64(1 / sqrt(dot_f64(v, v)), v); }

/* ---- lanes ---- */

static vec3_f64 lane_f64(const lanes3_f64 from, unsigned i) {
    return vec_f64(from[0][i], from[1][i], from[2][i]);
}
static vec3_f64 lane_f32(const lanes3 from, unsigned i) {
    return vec_f64((double)from[0][i], (double)from[1][i], (double)from[2][i]);
}
static void put_f64(lanes3_f64 to, unsigned i, vec3_f64 v) { to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z; }
static void put_f32(float to[3][LANES], unsigned i, vec3_f32 v) {
    to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z;
}

/* Object to world: to the point that to_object, as it was rounded, carries to the object's: to_world is its
 * inverse but for some u, so what is left after one step of Newton's is of the order u². */
static void to_world(const world_instance *instance, local_block *b, unsigned i) {
    const float(*m)[4] = instance->to_world, (*inverse)[4] = instance->to_object;
    vec3_f64 object_p = lane_f64(b->p, i), object_n = lane_f64(b->n, i);
    vec3_f64 p = map_point(m, object_p), n = map_normal(inverse, object_n);
    p = add_f64(p, map_vector(m, sub_f64(object_p, map_point(inverse, p))));
    double length = sqrt(dot_f64(n, n));
    b->beside[i] = (b->beside[i] + carried_along(instance, object_n, p)) / length;
    put_f64(b->p, i, p);
    put_f64(b->n, i, scale_f64(1 / length, n));
    put_f32(b->ns, i, narrow(unit_of(map_normal(inverse, lane_f32(b->ns, i)))));
    put_f32(b->lift, i, narrow(map_vector(m, lane_f32(b->lift, i))));
    put_f32(b->lift_inside, i, narrow(map_vector(m, lane_f32(b->lift_inside, i))));
}

/* ---- hits ---- */

/* Unused lanes are computed too: a triangle seen from a distance of 1. */
void surface_gather_begin(surface_gather *g, bool normals, bool always) {
    g->count = 0, g->instances = 0, g->faceted = false, g->normals = normals;
    memset(&g->facets, 0, sizeof g->facets);
    g->facets.smooth = always;
    memset(g->local.lift, 0, sizeof g->local.lift);
    memset(g->local.lift_inside, 0, sizeof g->local.lift_inside);
    memset(g->local.smooth, 0, sizeof g->local.smooth);
}

static const float *vector_at(const float *base, size_t stride, uint32_t i) {
    return (const float *)(const void *)((const char *)base + stride * i);
}

/* A triangle's corners and normals are only fetched here; facets() computes. */
static void add_facet(surface_gather *g, unsigned i, const fathom_mesh *mesh, uint32_t triangle) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k)
        put_f32(g->facets.corner[k], i,
                load_f32(vector_at(mesh->positions, mesh->position_stride, index[k])));
    g->facets.facet[i] = ~0u;
    g->faceted = true;
    if (!mesh->normals || !g->normals) return;
    index = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k)
        put_f32(g->facets.normal[k], i, load_f32(vector_at(mesh->normals, mesh->normal_stride, index[k])));
    g->facets.bent[i] = ~0u;
    g->facets.smooth = true;
}

/* The mesh that a lane met; NULL: none. */
static const fathom_mesh *met_mesh(const world *w, const trace_block *block, unsigned lane) {
    uint32_t id = block->hits.geometry[lane];
    if (id >= TRACE_PLANE) return NULL; /* a plane, or nothing */
    const world_geometry *geometry = &w->geometries.items[id];
    return geometry->kind == WORLD_MESH ? &w->meshes.items[geometry->first] : NULL;
}

void surface_fetch_indices(const world *w, const trace_block *block, unsigned lanes, bool normals) {
    for (unsigned i = 0; i < lanes; ++i) {
        const fathom_mesh *mesh = met_mesh(w, block, i);
        if (!mesh) continue;
        size_t first = 3 * (size_t)block->hits.primitive[i];
        __builtin_prefetch(mesh->indices + first);
        if (normals && mesh->normals && mesh->normal_indices)
            __builtin_prefetch(mesh->normal_indices + first);
    }
}

void surface_fetch_corners(const world *w, const trace_block *block, unsigned lanes, bool normals) {
    for (unsigned i = 0; i < lanes; ++i) {
        const fathom_mesh *mesh = met_mesh(w, block, i);
        if (!mesh) continue;
        size_t first = 3 * (size_t)block->hits.primitive[i];
        const uint32_t *index = mesh->indices + first;
        for (int k = 0; k < 3; ++k)
            __builtin_prefetch(vector_at(mesh->positions, mesh->position_stride, index[k]));
        if (!normals || !mesh->normals) continue;
        if (mesh->normal_indices) index = mesh->normal_indices + first;
        for (int k = 0; k < 3; ++k)
            __builtin_prefetch(vector_at(mesh->normals, mesh->normal_stride, index[k]));
    }
}

static void add_hit(surface_gather *g, unsigned i, const local_hit *hit) {
    put_f64(g->local.p, i, hit->p);
    put_f64(g->local.n, i, hit->n);
    put_f32(g->local.ns, i, hit->ns);
    g->local.beside[i] = hit->beside;
}

static void add_primitive(surface_gather *g, unsigned i, const world *w, const ray_hit *ray,
                          const local_ray *local) {
    local_hit hit;
    if (ray->geometry == TRACE_PLANE) {
        local_plane(&w->planes.items[ray->primitive], local, &hit);
        add_hit(g, i, &hit);
        return;
    }
    const world_geometry *geometry = &w->geometries.items[ray->geometry];
    switch (geometry->kind) {
    case WORLD_SPHERES: local_sphere(&w->spheres.items[geometry->first + ray->primitive], local, &hit); break;
    case WORLD_QUADS: local_quad(&w->quads.items[geometry->first + ray->primitive], local, &hit); break;
    case WORLD_MESH: add_facet(g, i, &w->meshes.items[geometry->first], ray->primitive); return;
    }
    add_hit(g, i, &hit);
}

void surface_gather_add(surface_gather *g, const world *w, const ray_hit *ray) {
    unsigned i = g->count++;
    local_ray local = {widen(ray->org), widen(ray->dir), ray->t_near};
    g->hits[i] = *ray;
    put_f32(g->local.ray, i, ray->dir);
    if (ray->geometry != TRACE_PLANE && ray->instance != FATHOM_NONE) {
        const world_instance *instance = &w->instances.items[ray->instance];
        local.org = map_point(instance->to_object, local.org);
        local.dir = map_vector(instance->to_object, local.dir);
        g->instances |= 1u << i;
    }
    put_f64(g->local.org, i, local.org);
    put_f64(g->local.dir, i, local.dir);
    add_primitive(g, i, w, ray, &local);
}

/* The rest of a block repeats its last hit. */
static void pad(surface_gather *g) {
    local_block *b = &g->local;
    for (unsigned i = g->count, last = g->count - 1; i < LANES; ++i) {
        put_f64(b->p, i, lane_f64(b->p, last));
        put_f64(b->n, i, lane_f64(b->n, last));
        put_f32(b->ns, i, narrow(lane_f32(b->ns, last)));
        put_f32(b->ray, i, narrow(lane_f32(b->ray, last)));
        put_f32(b->lift, i, narrow(lane_f32(b->lift, last)));
        put_f32(b->lift_inside, i, narrow(lane_f32(b->lift_inside, last)));
        b->beside[i] = b->beside[last], b->smooth[i] = b->smooth[last];
    }
}

void surface_gather_end(surface_gather *g, const world *w, const shade_kernels *kernels, bool lift,
                        bool automatic, surface_block *s) {
    if (g->faceted) kernels->facets(&g->facets, lift, &g->local);
    for (uint32_t left = g->instances; left; left &= left - 1) {
        unsigned i = (unsigned)__builtin_ctz(left);
        to_world(&w->instances.items[g->hits[i].instance], &g->local, i);
    }
    pad(g);
    kernels->surfaces(&g->local, automatic, s);
}
