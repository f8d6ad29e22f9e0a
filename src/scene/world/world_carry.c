/* Meshes that are placed only once are carried into the world: their vertices, normals and tangents are
 * copied in world coordinates. Rays then need no transformation to the mesh's space and back. Where many
 * meshes overlap, as the parts of a room do, a ray traverses one structure instead of one for each mesh.
 *
 * A mesh that is mirrored is not carried, because mirroring reverses the orientation of triangles. A mesh
 * that is scaled non-uniformly is carried if nothing in it depends on angles: normals that differ within a
 * triangle are normalised before interpolation, and tangents are derived from texture coordinates if the mesh
 * has none. The loss of precision is small. A mesh of radius r whose centre is |c| from the origin gets a
 * rounding error of 2^-24 (|c| + r) / r of its radius, which is 2^-18 at the maximum distance below: a
 * hundredth of a pixel for a mesh of 2,600 pixels. No triangle may lose its area. */
#include "base/threads.h"
#include "scene/mesh/mesh_array.h"
#include "scene/world/world_build.h"

#include <stdlib.h>
#include <string.h>

/* The maximum distance of the centre from the origin, in radii of the mesh. */
static const double far_ratio = 63;
/* The tolerance for columns of the map to be equally long and orthogonal; rotations in float are within it.
 * Such a map preserves angles. */
static const double even_slack = 0x1p-18;
/* The maximum scale; the minimum is its inverse. Enough for millimetres to metres and the reverse; beyond
 * that, small values may be too small for float. */
static const double scale_most = 0x1p12;
/* The minimum volume of the axes, divided by that of a box with their lengths. */
static const double skew_least = 0x1p-6;
/* The maximum number of vertices per triangle. Without it, meshes that share an array with many others would
 * each copy all of it. */
enum { VERTICES_PER_TRIANGLE = 3 };

/* ---- which meshes can be carried ---- */

/* The axes of a mesh in world coordinates. */
typedef struct mesh_axes {
    vec3_f64 x, y, z;
    double least, most; /* minimum and maximum length */
    double volume;      /* negative if the map mirrors */
} mesh_axes;

static mesh_axes axes_of(const affine_f64 *map) {
    mesh_axes a = {affine_vector(map, vec_f64(1, 0, 0)),
                   affine_vector(map, vec_f64(0, 1, 0)),
                   affine_vector(map, vec_f64(0, 0, 1)),
                   0,
                   0,
                   0};
    const double x = length_f64(a.x), y = length_f64(a.y), z = length_f64(a.z);
    a.least = fmin(x, fmin(y, z)), a.most = fmax(x, fmax(y, z));
    a.volume = dot_f64(cross_f64(a.x, a.y), a.z);
    return a;
}

static bool is_even(const mesh_axes *a) {
    const double slack = even_slack * a->most;
    return a->most - a->least <= slack && fabs(dot_f64(a->x, a->y)) <= slack * a->most &&
           fabs(dot_f64(a->x, a->z)) <= slack * a->most && fabs(dot_f64(a->y, a->z)) <= slack * a->most;
}

static bool is_ordinary(const mesh_axes *a) {
    return a->least >= 1 / scale_most && a->most <= scale_most &&
           a->volume >= skew_least * length_f64(a->x) * length_f64(a->y) * length_f64(a->z);
}

static bool normals_differ(const fathom_mesh *m) {
    const uint32_t *index = m->normal_indices ? m->normal_indices : m->indices;
    for (size_t i = 0; m->normals && i < (size_t)m->triangle_count * 3; i += 3) {
        const float *a = mesh_row(m->normals, m->normal_stride, index[i]);
        for (size_t k = i + 1; k < i + 3; ++k)
            if (memcmp(a, mesh_row(m->normals, m->normal_stride, index[k]), 3 * sizeof *a) != 0) return true;
    }
    return false;
}

static bool depends_on_angles(const fathom_mesh *m) {
    return (m->uvs && !m->tangents) || m->uvs_1 || normals_differ(m);
}

/* The map from vertex coordinates, which are relative to the mesh's origin. */
static affine_f64 map_of(const fathom_mesh *mesh, const affine_f64 *to_world) {
    const affine_f64 shift = affine_translation(load_f64(mesh->origin));
    return affine_compose(to_world, &shift);
}

static bool keeps_digits(const fathom_mesh *mesh, const mesh_facts *facts, const affine_f64 *to_world,
                         const mesh_axes *axes) {
    const scene_bounds bounds = {widen(load_f32(facts->lower)), widen(load_f32(facts->upper))};
    const affine_f64 map = map_of(mesh, to_world);
    const double radius = axes->least * bounds_radius(&bounds),
                 distance = length_f64(affine_point(&map, bounds_center(&bounds)));
    return distance <= far_ratio * radius && distance + axes->most / axes->least * radius < WORLD_REACH;
}

bool world_can_carry(const fathom_scene *scene, uint32_t index, const affine_f64 *to_world) {
    const fathom_mesh *mesh = &scene->meshes.items[index];
    const mesh_axes axes = axes_of(to_world);
    const uint32_t vertices =
        mesh->vertex_count > mesh->normal_count ? mesh->vertex_count : mesh->normal_count;
    return !mesh->key_count && !(mesh->point_radius > 0) &&
           vertices / VERTICES_PER_TRIANGLE <= mesh->triangle_count && is_ordinary(&axes) &&
           keeps_digits(mesh, &scene->mesh_facts.items[index], to_world, &axes) &&
           (is_even(&axes) || !depends_on_angles(mesh));
}

/* ---- carrying ---- */

typedef struct carrying {
    affine_f64 map;
    mesh_array from;
    float *to;
} carrying;

static void carry_points(void *user, size_t begin, size_t end) {
    const carrying *c = user;
    for (size_t i = begin; i < end; ++i) {
        const vec3_f64 p = widen(load_f32(mesh_row(c->from.values, c->from.stride, i)));
        store_f32(c->to + 3 * i, narrow(affine_point(&c->map, p)));
    }
}

/* The fourth number of a tangent is a sign, which is copied. */
static void carry_directions(void *user, size_t begin, size_t end) {
    const carrying *c = user;
    const unsigned width = c->from.width;
    for (size_t i = begin; i < end; ++i) {
        const float *from = mesh_row(c->from.values, c->from.stride, i);
        store_f32(c->to + width * i, narrow(affine_vector(&c->map, widen(load_f32(from)))));
        if (width > 3) c->to[width * i + 3] = from[3];
    }
}

#define GRAIN ((size_t)1 << 14)

static bool carry_array(world *w, fathom_mesh *mesh, mesh_kind kind, const affine_f64 *map) {
    carrying c = {.map = *map, .from = mesh_array_of(mesh, kind)};
    if (!c.from.values) return true;
    c.to = world_new_rows(1, (size_t)c.from.width * c.from.count);
    if (!c.to || !array_push(&w->still_vertices, c.to)) {
        free(c.to);
        return false;
    }
    loop_parallel(fathom_context_threads(w->scene->context), c.from.count, GRAIN,
                  kind == MESH_POSITIONS ? carry_points : carry_directions, &c);
    w->carried_bytes += (uint64_t)c.from.width * c.from.count * sizeof(float);
    mesh_array_set(mesh, kind, c.to, c.from.width * sizeof(float));
    return true;
}

/* Normals are transformed by the inverse transpose, tangents by the map. Both keep their lengths if the map
 * is uniform. */
static bool carry_arrays(world *w, fathom_mesh *mesh, const affine_f64 *map, const affine_f64 *inverse) {
    const mesh_axes axes = axes_of(map);
    const double size = cbrt(axes.volume);
    const affine_f64 larger = affine_scaling((vec3_f64){size, size, size}),
                     smaller = affine_scaling((vec3_f64){1 / size, 1 / size, 1 / size});
    affine_f64 transposed = affine_identity();
    for (int i = 0; i < 9; ++i) transposed.m[i / 3][i % 3] = inverse->m[i % 3][i / 3];
    const affine_f64 of_normals = affine_compose(&larger, &transposed),
                     of_tangents = affine_compose(&smaller, map);
    return carry_array(w, mesh, MESH_POSITIONS, map) && carry_array(w, mesh, MESH_NORMALS, &of_normals) &&
           carry_array(w, mesh, MESH_TANGENTS, &of_tangents);
}

fathom_status world_carry_mesh(world *w, uint32_t index, const affine_f64 *to_world, fathom_mesh *mesh,
                               mesh_facts *facts, bool *fits) {
    fathom_context *context = w->scene->context;
    *mesh = w->scene->meshes.items[index];
    *facts = w->scene->mesh_facts.items[index];
    const uint32_t flat = facts->flat;
    const affine_f64 map = map_of(mesh, to_world);
    affine_f64 inverse;
    *fits = affine_invert(&map, &inverse);
    if (!*fits) return FATHOM_OK;
    if (!carry_arrays(w, mesh, &map, &inverse))
        return fail_memory(context, (size_t)mesh->vertex_count * 3 * sizeof(float));
    fathom_status status = mesh_look_at_vertices(context, "positions", mesh->positions, mesh->position_stride,
                                                 mesh->vertex_count, facts);
    if (status == FATHOM_OK) status = mesh_look_at_triangles(context, "indices", mesh, facts);
    *fits = facts->flat <= flat;
    return status;
}
