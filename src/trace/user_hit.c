#include "trace/user_hit.h"
#include "reference/reference.h"

#include <math.h>

/* A hit in the space of its geometry. Normals need not be unit. */
typedef struct local_hit {
    double t;
    vec3_f64 point, geometric, shading;
    double u, v;
} local_hit;

static double clamp_unit(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

static vec3_f64 weighted(const vec3_f64 v[3], double u, double w) {
    return madd_f64(madd_f64(scale_f64(1 - u - w, v[0]), u, v[1]), w, v[2]);
}

/* ---- shapes ---- */

/* The root nearest to t; for a ray that passes the sphere by, its nearest point. */
static local_hit sphere_hit(const world_sphere *s, vec3_f64 org, vec3_f64 dir, double t) {
    double roots[2], radius = world_sphere_radius(s);
    vec3_f64 center = world_sphere_center(s), from = sub_f64(org, center);
    if (sphere_roots_f64(center, radius, org, dir, roots)) {
        t = fabs(roots[0] - t) <= fabs(roots[1] - t) ? roots[0] : roots[1];
    } else {
        t = -dot_f64(from, dir) / dot_f64(dir, dir);
    }
    vec3_f64 n = normalize_f64(madd_f64(from, t, dir));
    double phi = atan2(n.y, n.x);
    return (local_hit){.t = t,
                       .point = madd_f64(center, radius, n),
                       .geometric = n,
                       .shading = n,
                       .u = (phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI),
                       .v = acos(n.z < -1 ? -1 : (n.z > 1 ? 1 : n.z)) / M_PI};
}

static local_hit quad_hit(const world_quad *quad, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 c[4];
    for (int i = 0; i < 4; ++i) c[i] = widen(quad->corner[i]);
    reference_hit_f64 hit = {.t = t};
    if (!quad_robust_f64(c[0], c[1], c[2], c[3], org, dir, -INFINITY, INFINITY, &hit)) {
        quad_textbook_f64(c[0], c[1], c[2], c[3], org, dir, -INFINITY, INFINITY, &hit);
        hit.u = clamp_unit(hit.u), hit.v = clamp_unit(hit.v);
        if (!isfinite(hit.t)) hit.t = t;
    }
    const vec3_f64 near[3] = {c[0], c[1], c[3]}, far[3] = {c[2], c[3], c[1]};
    vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    return (local_hit){.t = hit.t,
                       .point = hit.u + hit.v <= 1 ? weighted(near, hit.u, hit.v)
                                                   : weighted(far, 1 - hit.u, 1 - hit.v),
                       .geometric = n,
                       .shading = n,
                       .u = hit.u,
                       .v = hit.v};
}

static local_hit plane_hit(const world_plane *plane, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double exact = dot_f64(sub_f64(point, org), n) / dot_f64(dir, n);
    if (isfinite(exact)) t = exact;
    vec3_f64 p = madd_f64(org, t, dir), q = sub_f64(p, point);
    return (local_hit){.t = t,
                       .point = p,
                       .geometric = n,
                       .shading = n,
                       .u = dot_f64(q, widen(plane->u)),
                       .v = dot_f64(q, widen(plane->v))};
}

/* Item i of an array whose items lie `stride` bytes apart. */
static const float *item(const float *first, size_t stride, uint32_t i) {
    return (const float *)(const void *)((const char *)first + stride * i);
}

static void mesh_attributes(const fathom_mesh *mesh, uint32_t triangle, local_hit *hit) {
    size_t first = 3 * (size_t)triangle;
    double u = hit->u, v = hit->v;
    if (mesh->normals) {
        const uint32_t *index = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + first;
        vec3_f64 n[3];
        for (int c = 0; c < 3; ++c) {
            n[c] = widen(load_f32(item(mesh->normals, mesh->normal_stride, index[c])));
        }
        vec3_f64 shading = weighted(n, u, v);
        if (finite_f64(shading) && dot_f64(shading, shading) > 0) hit->shading = shading;
    }
    if (mesh->uvs) {
        const uint32_t *index = (mesh->uv_indices ? mesh->uv_indices : mesh->indices) + first;
        const float *uv[3];
        for (int c = 0; c < 3; ++c) uv[c] = item(mesh->uvs, mesh->uv_stride, index[c]);
        hit->u = (1 - u - v) * (double)uv[0][0] + u * (double)uv[1][0] + v * (double)uv[2][0];
        hit->v = (1 - u - v) * (double)uv[0][1] + u * (double)uv[1][1] + v * (double)uv[2][1];
    }
}

static local_hit mesh_hit(const fathom_mesh *mesh, uint32_t triangle, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 c[3];
    for (int i = 0; i < 3; ++i)
        c[i] = widen(load_f32(mesh_vertex(mesh, mesh->indices[3 * (size_t)triangle + (size_t)i])));
    vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[2], c[0]));
    reference_hit_f64 hit = {.t = t};
    if (!triangle_robust_f64(c[0], c[1], c[2], org, dir, -INFINITY, INFINITY, &hit)) {
        double exact = dot_f64(sub_f64(c[0], org), n) / dot_f64(dir, n), n2 = dot_f64(n, n);
        if (isfinite(exact)) hit.t = exact;
        vec3_f64 q = sub_f64(madd_f64(org, hit.t, dir), c[0]);
        hit.u = clamp_unit(dot_f64(cross_f64(q, sub_f64(c[2], c[0])), n) / n2);
        hit.v = clamp_unit(dot_f64(cross_f64(sub_f64(c[1], c[0]), q), n) / n2);
        if (hit.u + hit.v > 1) hit.v = 1 - hit.u;
    }
    local_hit out = {
        .t = hit.t, .point = weighted(c, hit.u, hit.v), .geometric = n, .shading = n, .u = hit.u, .v = hit.v};
    mesh_attributes(mesh, triangle, &out);
    return out;
}

/* ---- from the geometry's space to the scene's ---- */

static local_hit geometry_hit(const world *w, const world_geometry *geometry, uint32_t primitive,
                              vec3_f64 org, vec3_f64 dir, double t) {
    switch (geometry->kind) {
    case WORLD_SPHERES: return sphere_hit(&w->spheres.items[geometry->first + primitive], org, dir, t);
    case WORLD_QUADS: return quad_hit(&w->quads.items[geometry->first + primitive], org, dir, t);
    case WORLD_MESH: break;
    }
    return mesh_hit(&w->meshes.items[geometry->first], primitive, org, dir, t);
}

/* In the space of the instance. The inverse is taken in double of the map as it was rounded, so that going
 * there and back loses nothing. */
static local_hit instance_hit(const world *w, const world_instance *instance, const world_geometry *geometry,
                              uint32_t primitive, vec3_f64 org, vec3_f64 dir, double t) {
    affine_f64 to_world, to_object;
    for (int i = 0; i < 12; ++i) {
        to_world.m[i / 4][i % 4] = (double)instance->to_world[i / 4][i % 4];
        to_object.m[i / 4][i % 4] = (double)instance->to_object[i / 4][i % 4];
    }
    affine_invert(&to_world, &to_object);
    local_hit hit = geometry_hit(w, geometry, primitive, affine_point(&to_object, org),
                                 affine_vector(&to_object, dir), t);
    hit.point = affine_point(&to_world, hit.point);
    hit.geometric = affine_transposed_vector(&to_object, normalize_f64(hit.geometric));
    hit.shading = affine_transposed_vector(&to_object, normalize_f64(hit.shading));
    return hit;
}

static void set_out(const world *w, const local_hit *hit, fathom_hit *out) {
    out->t = hit->t;
    store_f64(out->position, add_f64(hit->point, w->origin));
    store_f32(out->geometric_normal, narrow(normalize_f64(hit->geometric)));
    store_f32(out->shading_normal, narrow(normalize_f64(hit->shading)));
    out->u = (float)hit->u, out->v = (float)hit->v;
}

void user_hit_resolve(const world *w, const trace_block *block, unsigned lane, vec3_f64 org, vec3_f64 dir,
                      fathom_hit *out) {
    uint32_t geometry = block->hits.geometry[lane], primitive = block->hits.primitive[lane];
    uint32_t instance = block->hits.instance[lane];
    double t = (double)block->rays.t_far[lane];
    local_hit hit;
    if (geometry == TRACE_PLANE) {
        const world_plane *plane = &w->planes.items[primitive];
        hit = plane_hit(plane, org, dir, t);
        set_out(w, &hit, out);
        out->object = plane->object, out->material = plane->material;
        out->primitive = 0, out->instance = FATHOM_NONE;
        return;
    }
    const world_geometry *g = &w->geometries.items[geometry];
    if (instance == FATHOM_NONE) {
        hit = geometry_hit(w, g, primitive, org, dir, t);
        out->instance = g->instance;
    } else {
        hit = instance_hit(w, &w->instances.items[instance], g, primitive, org, dir, t);
        out->instance = w->instances.items[instance].id;
    }
    set_out(w, &hit, out);
    out->object = world_object(w, geometry, primitive);
    out->material = world_material(w, geometry, primitive, instance);
    out->primitive = world_primitive(w, geometry, primitive);
}
