/* Meshes that are placed once, carried into the world: their vertices, normals and tangents are copied there.
 * No ray then has to be carried to their space and back, and where many of them lie within each other, as the
 * parts of a room do, a ray meets one structure in place of one for each.
 *
 * What shading reads keeps its meaning, because nothing is carried but by maps that turn, move and scale
 * evenly: angles stay, and triangles keep their front. What float loses stays small, too. A mesh of radius r
 * whose centre is |c| from the origin keeps 2^-24 (|c| + r) / r of its radius, 2^-18 at the distance below:
 * a hundredth of a pixel for a mesh of 2,600 pixels. No triangle may lose its area by it. */
#include "base/threads.h"
#include "scene/mesh/mesh_array.h"
#include "scene/world/world_build.h"

#include <stdlib.h>

/* The farthest centre, in radii of the mesh. */
static const double far_ratio = 63;
/* How far columns of the map may differ in length, and lie from a right angle: as float turns lie. */
static const double even_slack = 0x1p-18;
/* Thousandths of a unit become units, and the other way; farther off, what is small in float is small. */
static const double scale_most = 0x1p12;
/* Vertices a triangle, at most. Meshes that share an array with many others would each copy all of it. */
enum { VERTICES_PER_TRIANGLE = 3 };

/* ---- what can be carried ---- */

/* The even scale of a map, 0 where it has none or mirrors. */
static double even_scale(const affine_f64 *map) {
    const vec3_f64 x = {map->m[0][0], map->m[1][0], map->m[2][0]},
                   y = {map->m[0][1], map->m[1][1], map->m[2][1]},
                   z = {map->m[0][2], map->m[1][2], map->m[2][2]};
    const double square = dot_f64(x, x), slack = even_slack * square;
    const bool even = fabs(dot_f64(y, y) - square) <= 2 * slack &&
                      fabs(dot_f64(z, z) - square) <= 2 * slack && fabs(dot_f64(x, y)) <= slack &&
                      fabs(dot_f64(x, z)) <= slack && fabs(dot_f64(y, z)) <= slack;
    return even && dot_f64(cross_f64(x, y), z) > 0 ? sqrt(square) : 0;
}

/* From the mesh's own coordinates, without its origin. */
static affine_f64 map_of(const fathom_mesh *mesh, const affine_f64 *to_world) {
    const affine_f64 shift = affine_translation(load_f64(mesh->origin));
    return affine_compose(to_world, &shift);
}

bool world_can_carry(const fathom_scene *scene, uint32_t index, const affine_f64 *to_world) {
    const fathom_mesh *mesh = &scene->meshes.items[index];
    const mesh_facts *facts = &scene->mesh_facts.items[index];
    const double scale = even_scale(to_world);
    if (mesh->key_count || mesh->point_radius > 0 || !(scale >= 1 / scale_most && scale <= scale_most) ||
        mesh->vertex_count / VERTICES_PER_TRIANGLE > mesh->triangle_count ||
        mesh->normal_count / VERTICES_PER_TRIANGLE > mesh->triangle_count)
        return false;
    const scene_bounds bounds = {widen(load_f32(facts->lower)), widen(load_f32(facts->upper))};
    const affine_f64 map = map_of(mesh, to_world);
    const double radius = scale * bounds_radius(&bounds),
                 distance = length_f64(affine_point(&map, bounds_center(&bounds)));
    return distance <= far_ratio * radius && distance + radius < WORLD_REACH;
}

/* ---- carrying ---- */

typedef struct carrying {
    affine_f64 map;
    mesh_array from;
    float *to;
} carrying;

static void carry_points(void *user, size_t begin, size_t end, unsigned worker) {
    const carrying *c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const vec3_f64 p = widen(load_f32(mesh_row(c->from.values, c->from.stride, i)));
        store_f32(c->to + 3 * i, narrow(affine_point(&c->map, p)));
    }
}

/* The fourth number of a tangent is a sign. */
static void carry_directions(void *user, size_t begin, size_t end, unsigned worker) {
    const carrying *c = user;
    const unsigned width = c->from.width;
    (void)worker;
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

fathom_status world_carry_mesh(world *w, uint32_t index, const affine_f64 *to_world, fathom_mesh *mesh,
                               mesh_facts *facts, bool *fits) {
    fathom_context *context = w->scene->context;
    const double scale = even_scale(to_world);
    *mesh = w->scene->meshes.items[index];
    *facts = w->scene->mesh_facts.items[index];
    const uint32_t flat = facts->flat;
    const affine_f64 map = map_of(mesh, to_world),
                     evenly = affine_scaling((vec3_f64){1 / scale, 1 / scale, 1 / scale}),
                     turn = affine_compose(&evenly, &map);
    if (!carry_array(w, mesh, MESH_POSITIONS, &map) || !carry_array(w, mesh, MESH_NORMALS, &turn) ||
        !carry_array(w, mesh, MESH_TANGENTS, &turn))
        return fail_memory(context, (size_t)mesh->vertex_count * 3 * sizeof(float));
    fathom_status status = mesh_look_at_vertices(context, "positions", mesh->positions, mesh->position_stride,
                                                 mesh->vertex_count, facts);
    if (status == FATHOM_OK) status = mesh_look_at_triangles(context, "indices", mesh, facts);
    *fits = facts->flat <= flat;
    return status;
}
