/* Shapes in double, and ray queries: the reference intersectors on every primitive, or on those whose boxes
 * the ray crosses. */
#include "integrate/reference/reference_inner.h"
#include "math/frame.h"
#include "reference/reference.h"
#include "scene/graph.h"
#include "scene/mesh/absent.h"
#include "scene/motion/motion.h"

#include <stdlib.h>

/* ---- shapes ---- */

/* Row `index` of keyed rows, interpolated at a time; constant before the first key and after the last. */
static vec3_f64 row_when(const fathom_mesh *m, const float *rows, size_t count, uint32_t index, double time) {
    uint32_t k = 0;
    while (k + 1 < m->key_count && m->key_times[k + 1] <= time) ++k;
    const vec3_f64 a = color_of(rows + 3 * (k * count + index));
    if (k + 1 == m->key_count || time <= m->key_times[k]) return a;
    const vec3_f64 b = color_of(rows + 3 * ((k + 1) * count + index));
    return blend(a, b, (time - m->key_times[k]) / (m->key_times[k + 1] - m->key_times[k]));
}

static vec3_f64 mesh_corner(const fathom_mesh *m, uint32_t triangle, size_t k, double time) {
    const uint32_t index = m->indices[3 * (size_t)triangle + k];
    return add_f64(load_f64(m->origin), m->key_count
                                            ? row_when(m, m->key_positions, m->vertex_count, index, time)
                                            : color_of(mesh_vertex(m, index)));
}

/* A point of a point cloud is a sphere. Also sets the placement's flags. */
static reference_primitive load(const fathom_scene *s, const scene_object *o, uint32_t triangle,
                                unsigned *flags) {
    reference_primitive p = {.kind = o->kind, .mesh = o->index, .triangle = triangle};
    switch (o->kind) {
    case SCENE_SPHERE:
        p.corner[0] = load_f64(s->spheres.items[o->index].center);
        p.corner[1] = gray(s->spheres.items[o->index].radius);
        *flags = s->spheres.items[o->index].flags;
        break;
    case SCENE_QUAD:
        for (int k = 0; k < 4; ++k) p.corner[k] = load_f64(s->quads.items[o->index].corners[k]);
        *flags = s->quads.items[o->index].flags;
        break;
    case SCENE_PLANE:
        p.corner[0] = load_f64(s->planes.items[o->index].point);
        p.corner[1] = load_f64(s->planes.items[o->index].normal);
        *flags = s->planes.items[o->index].flags;
        break;
    case SCENE_MESH: {
        const fathom_mesh *m = &s->meshes.items[o->index];
        *flags = m->flags;
        if (m->point_radius > 0) {
            p.kind = SCENE_SPHERE;
            p.corner[0] = add_f64(load_f64(m->origin), color_of(mesh_vertex(m, triangle)));
            p.corner[1] = gray((double)m->point_radius);
            break;
        }
        for (size_t k = 0; k < 4; ++k)
            p.corner[k] = mesh_corner(m, triangle, k < 3 ? k : 2, s->camera.shutter[0]);
        break;
    }
    }
    return p;
}

static bool add_object(reference_scene *r, fathom_id id, reference_place at, fathom_id material) {
    const scene_object *o = &r->scene->objects.items[id];
    const fathom_mesh *m = o->kind == SCENE_MESH ? &r->scene->meshes.items[o->index] : NULL;
    const uint32_t count = !m ? 1 : m->point_radius > 0 ? m->vertex_count : m->triangle_count;
    if (!array_room(&r->primitives, count)) return false;
    const size_t first = r->primitives.count;
    for (uint32_t i = 0; i < count; ++i) {
        reference_primitive *p = &r->primitives.items[r->primitives.count++];
        *p = load(r->scene, o, i, &at.flags);
        p->place = (uint32_t)r->places.count;
    }
    at.material = material != FATHOM_NONE ? material : scene_object_material(r->scene, id);
    if (at.flags & FATHOM_CASTS_NO_SHADOW && absent_material(&r->scene->materials.items[at.material].value))
        r->primitives.count = first;
    else if (o->kind == SCENE_PLANE && !array_push(&r->planes, (uint32_t)first))
        return false;
    return array_push(&r->places, at);
}

/* material: that of the outermost instance that has one, or FATHOM_NONE. */
static bool add_group(reference_scene *r, const scene_graph *graph, uint32_t group,
                      const affine_f64 *to_world, fathom_id material, uint32_t link, bool moves) {
    reference_place at = {.to_world = *to_world, .link = moves ? link : FATHOM_NONE};
    if (!affine_invert(to_world, &at.to_object)) return false;
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        if (!add_object(r, graph->objects.items[i], at, material)) return false;
    }
    for (uint32_t i = graph->instances.first[group]; i < graph->instances.first[group + 1]; ++i) {
        const fathom_instance *inner = &r->scene->instances.items[graph->instances.items[i]];
        affine_f64 map = motion_place(inner, r->scene->camera.shutter[0]);
        map = affine_compose(to_world, &map);
        const uint32_t own = (uint32_t)r->links.count;
        if (!array_push(&r->links, ((reference_link){graph->instances.items[i], link}))) return false;
        if (!add_group(r, graph, inner->group, &map, material != FATHOM_NONE ? material : inner->material,
                       own, moves || motion_is_moving(inner, r->scene->camera.shutter)))
            return false;
    }
    return true;
}

/* The placement at a time: the transforms of all instances around it, interpolated and composed. */
static reference_place place_when(const reference_scene *r, uint32_t index, double time) {
    reference_place at = r->places.items[index];
    if (at.link == FATHOM_NONE) return at;
    at.to_world = affine_identity();
    for (uint32_t l = at.link; l != FATHOM_NONE; l = r->links.items[l].outer) {
        const affine_f64 outer = motion_place(&r->scene->instances.items[r->links.items[l].instance], time);
        at.to_world = affine_compose(&outer, &at.to_world);
    }
    affine_invert(&at.to_world, &at.to_object);
    return at;
}

/* The bounds of a moving placement: its boxes at uniform times, each enlarged by how far its corners moved
 * since the previous time. This assumes that corners stay within that distance between two times. */
static scene_bounds moved_bounds(const reference_scene *r, uint32_t place, const scene_bounds *inside) {
    enum { LOOKS = 256 };
    const double *shutter = r->scene->camera.shutter;
    scene_bounds all = bounds_empty();
    vec3_f64 last[8];
    for (int k = 0; k <= LOOKS; ++k) {
        const reference_place at = place_when(r, place, shutter[0] + (shutter[1] - shutter[0]) * k / LOOKS);
        for (int i = 0; i < 8; ++i) {
            const vec3_f64 p = affine_point(&at.to_world, bounds_corner(inside, i));
            const vec3_f64 way = gray(k ? length_f64(sub_f64(p, last[i])) : 0);
            bounds_add(&all, sub_f64(p, way));
            bounds_add(&all, add_f64(p, way));
            last[i] = p;
        }
    }
    return all;
}

/* The corners at every key of the mesh. */
static void add_corners(const reference_scene *r, const reference_primitive *p, scene_bounds *b) {
    const fathom_mesh *m = p->kind == SCENE_MESH ? &r->scene->meshes.items[p->mesh] : NULL;
    for (int k = 0; k < 4; ++k) bounds_add(b, p->corner[k]);
    for (uint32_t key = 0; m && key < m->key_count; ++key)
        for (size_t k = 0; k < 3; ++k) bounds_add(b, mesh_corner(m, p->triangle, k, m->key_times[key]));
}

/* A float box around a primitive, relative to r->middle. */
static bvh_item item_of(const reference_scene *r, uint32_t primitive) {
    const reference_primitive *p = &r->primitives.items[primitive];
    scene_bounds b = bounds_empty();
    if (p->kind != SCENE_SPHERE) add_corners(r, p, &b);
    if (p->kind == SCENE_SPHERE)
        b = (scene_bounds){sub_f64(p->corner[0], p->corner[1]), add_f64(p->corner[0], p->corner[1])};
    const reference_place *at = &r->places.items[p->place];
    b = at->link == FATHOM_NONE ? bounds_transformed(&b, &at->to_world) : moved_bounds(r, p->place, &b);
    b = (scene_bounds){sub_f64(b.lower, r->middle), sub_f64(b.upper, r->middle)};
    /* Several times the rounding error of float. */
    const vec3_f64 margin = gray(0x1p-20 * fmax(length_f64(b.lower), length_f64(b.upper)));
    bvh_item item = {.id = primitive};
    store_f32(item.lower, narrow(sub_f64(b.lower, margin)));
    store_f32(item.upper, narrow(add_f64(b.upper, margin)));
    return item;
}

/* The ball around the consecutive items of one placement, from `first` on; next: the first item of another
 * placement. */
static reference_lamp lamp_of(const reference_scene *r, uint32_t first, uint32_t count, uint32_t *next) {
    const reference_primitive *p = &r->primitives.items[r->items[first].id];
    scene_bounds b = bounds_empty();
    uint32_t i = first;
    for (; i < count && r->primitives.items[r->items[i].id].place == p->place; ++i) {
        bounds_add(&b, color_of(r->items[i].lower));
        bounds_add(&b, color_of(r->items[i].upper));
    }
    *next = i;
    const vec3_f64 size = sub_f64(b.upper, b.lower);
    return (reference_lamp){add_f64(r->middle, blend(b.lower, b.upper, 0.5)),
                            0.5 * (p->kind == SCENE_SPHERE ? largest(size) : length_f64(size))};
}

/* Call before the tree reorders the items: those of one placement are consecutive. */
static bool find_lamps(reference_scene *r, uint32_t count) {
    for (uint32_t i = 0, next; i < count; i = next) {
        const uint32_t place = r->primitives.items[r->items[i].id].place;
        const reference_lamp lamp = lamp_of(r, i, count, &next);
        const fathom_material *m = &r->scene->materials.items[r->places.items[place].material].value;
        if (largest(reference_emission(m)) > 0 && !array_push(&r->lamps, lamp)) return false;
    }
    if (r->lamps.count > REFERENCE_LAMPS) r->lamps.count = 0;
    return true;
}

static fathom_status build_tree(reference_scene *r) {
    r->items = malloc((r->primitives.count + 1) * sizeof *r->items);
    if (!r->items) return fail_memory(r->scene->context, r->primitives.count * sizeof *r->items);
    uint32_t count = 0;
    r->middle = load_f64(r->scene->camera.origin);
    for (uint32_t i = 0; i < r->primitives.count; ++i) {
        if (r->primitives.items[i].kind != SCENE_PLANE) r->items[count++] = item_of(r, i);
    }
    if (!find_lamps(r, count)) return fail_memory(r->scene->context, count * sizeof *r->lamps.items);
    const bvh_build build = {.context = r->scene->context};
    return bvh_tree_build(&build, r->items, count, &r->tree);
}

fathom_status reference_gather(reference_scene *r) {
    scene_graph graph;
    fathom_status status = graph_create(r->scene, &graph);
    if (status != FATHOM_OK) return status;
    const affine_f64 identity = affine_identity();
    if (!add_group(r, &graph, FATHOM_ROOT, &identity, FATHOM_NONE, FATHOM_NONE, false))
        status = fail_memory(r->scene->context, r->primitives.count * sizeof *r->primitives.items);
    graph_destroy(&graph);
    return status == FATHOM_OK ? build_tree(r) : status;
}

/* ---- rays ---- */

typedef struct query {
    vec3_f64 origin, direction;
    bool shadow;
    double time;
    reference_hit_f64 hit; /* the closest hit so far; before the first, t is the ray's end */
    const reference_primitive *met;
} query;

static void corners_when(const reference_scene *r, const reference_primitive *p, double time, vec3_f64 c[4]) {
    const fathom_mesh *m = p->kind == SCENE_MESH ? &r->scene->meshes.items[p->mesh] : NULL;
    for (size_t k = 0; k < 4; ++k)
        c[k] = m && m->key_count ? mesh_corner(m, p->triangle, k < 3 ? k : 2, time) : p->corner[k];
}

static void test(const reference_scene *r, uint32_t primitive, query *q) {
    const reference_primitive *p = &r->primitives.items[primitive];
    if (q->shadow && r->places.items[p->place].flags & FATHOM_CASTS_NO_SHADOW) return;
    const reference_place at = place_when(r, p->place, q->time);
    const vec3_f64 o = affine_point(&at.to_object, q->origin), d = affine_vector(&at.to_object, q->direction);
    vec3_f64 c[4];
    corners_when(r, p, q->time, c);
    reference_hit_f64 hit = {0, 0, 0};
    bool met = false;
    switch (p->kind) {
    case SCENE_SPHERE: met = sphere_robust_f64(c[0], c[1].x, o, d, 0, q->hit.t, &hit.t); break;
    case SCENE_QUAD: met = quad_robust_f64(c[0], c[1], c[2], c[3], o, d, 0, q->hit.t, &hit); break;
    case SCENE_PLANE: met = plane_robust_f64(c[0], c[1], o, d, 0, q->hit.t, &hit.t); break;
    case SCENE_MESH: met = triangle_robust_f64(c[0], c[1], c[2], o, d, 0, q->hit.t, &hit); break;
    }
    if (met) q->hit = hit, q->met = p;
}

static bool crosses(const reference_scene *r, const bvh_node *n, const query *q) {
    double enter = 0, leave = q->hit.t, o[3], d[3];
    store_f64(o, sub_f64(q->origin, r->middle));
    store_f64(d, q->direction);
    for (int k = 0; k < 3; ++k) {
        const double x = ((double)n->lower[k] - o[k]) / d[k], y = ((double)n->upper[k] - o[k]) / d[k];
        enter = fmax(enter, fmin(x, y)), leave = fmin(leave, fmax(x, y));
    }
    return enter <= leave;
}

static void descend(const reference_scene *r, uint32_t at, query *q) {
    const bvh_node *node = &r->tree.nodes[at];
    if (!crosses(r, node, q)) return;
    for (uint32_t i = node->first; i < node->first + node->count; ++i) test(r, r->items[i].id, q);
    if (node->count) return;
    descend(r, node->first, q);
    descend(r, node->first + 1, q);
}

/* ---- surfaces ---- */

/* The normals at the corners of the triangle, and the corners' weights at the hit. */
typedef struct corner_normals {
    vec3_f64 n[3];
    double weight[3];
} corner_normals;

/* The shading normal; `flat` if the mesh has no normals, or they cancel. */
static vec3_f64 vertex_normals(const fathom_mesh *m, const query *q, vec3_f64 flat, corner_normals *out) {
    if (!m->normals) return flat;
    const uint32_t *index =
        (m->normal_indices ? m->normal_indices : m->indices) + 3 * (size_t)q->met->triangle;
    *out = (corner_normals){.weight = {1 - q->hit.u - q->hit.v, q->hit.u, q->hit.v}};
    vec3_f64 sum = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        const void *n = (const char *)m->normals + index[k] * m->normal_stride;
        out->n[k] = normalize_f64(
            m->key_count ? row_when(m, m->key_normals, m->normal_count, index[k], q->time) : color_of(n));
        sum = madd_f64(sum, out->weight[k], out->n[k]);
    }
    return length_f64(sum) > 0 ? sum : flat;
}

/* Hanika, "Hacking the Shadow Terminator" (2021): the mean of the vectors from the point to the planes that
 * touch the smooth surface at the corners. Planes below the point, seen from the viewer's side, do not count.
 * side: 1 if the normals point to the viewer's side, else -1. */
static vec3_f64 lift_of(const vec3_f64 corner[3], const corner_normals *at, vec3_f64 point, double side) {
    vec3_f64 sum = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        const double down = fmin(side * dot_f64(sub_f64(point, corner[k]), at->n[k]), 0);
        sum = madd_f64(sum, -at->weight[k] * side * down, at->n[k]);
    }
    return sum;
}

/* Sets the tangent: along u on the shape, rotated about the shape's own normal; in the opposite sense in a
 * mirror image. */
static void set_direction(const affine_f64 *to_world, reference_surface *s, vec3_f64 u) {
    const frame_f64 f = frame_from((vec3_f64){0, 0, 0}, s->normal, affine_vector(to_world, u));
    const bool mirrored = affine_determinant(to_world) < 0;
    const double angle = (double)s->material->anisotropy_rotation * (s->behind != mirrored ? -1 : 1);
    s->along = madd_f64(scale_f64(cos(angle), f.y), -sin(angle), f.x);
}

/* The shading normal is flipped to the viewer's side of the geometric normal; if it still faces away from the
 * viewer, the geometric normal replaces it. */
static void make_surface(const reference_scene *r, const query *q, reference_surface *out) {
    const reference_primitive *p = q->met;
    const reference_place at = place_when(r, p->place, q->time);
    vec3_f64 c[4];
    corners_when(r, p, q->time, c);
    out->point = madd_f64(q->origin, q->hit.t, q->direction);
    out->to_viewer = neg_f64(q->direction);
    out->material = &r->scene->materials.items[at.material].value;
    out->albedos = r->albedos[at.material];
    out->t = q->hit.t;
    vec3_f64 own = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    if (p->kind == SCENE_SPHERE) own = sub_f64(affine_point(&at.to_object, out->point), c[0]);
    if (p->kind == SCENE_PLANE) own = c[1];
    corner_normals corners = {.weight = {0, 0, 0}}; /* only of meshes with normals */
    out->normal =
        p->kind == SCENE_MESH ? vertex_normals(&r->scene->meshes.items[p->mesh], q, own, &corners) : own;
    const bool smooth =
        r->settings.terminator_fix && p->kind == SCENE_MESH && r->scene->meshes.items[p->mesh].normals;
    out->geometric = normalize_f64(affine_transposed_vector(&at.to_object, own));
    out->normal = normalize_f64(affine_transposed_vector(&at.to_object, out->normal));
    out->behind = dot_f64(out->geometric, out->to_viewer) < 0;
    out->ratio = out->behind ? 1 / (double)out->material->ior : (double)out->material->ior;
    out->turn = out->ratio;
    if (out->behind) out->geometric = neg_f64(out->geometric);
    const double side = dot_f64(out->normal, out->geometric) < 0 ? -1 : 1;
    out->normal = scale_f64(side, out->normal);
    out->lifted = smooth;
    out->lift = (vec3_f64){0, 0, 0};
    if (smooth)
        out->lift =
            affine_vector(&at.to_world, lift_of(c, &corners, affine_point(&at.to_object, out->point), side));
    if (!(dot_f64(out->normal, out->to_viewer) > 0)) out->normal = out->geometric;
    vec3_f64 u = sub_f64(c[1], c[0]);
    if (p->kind == SCENE_SPHERE) u = vec_f64(-own.y, own.x, 0);
    set_direction(&at.to_world, out, u);
}

bool reference_crosses(const reference_surface *s, vec3_f64 direction) {
    return dot_f64(s->geometric, direction) < 0 && !(s->lifted && dot_f64(s->normal, direction) > 0);
}

/* Several thousand times the rounding error of a point in double, and far below visibility. */
vec3_f64 reference_leave(const reference_surface *s, vec3_f64 direction) {
    const double size = fmax(length_f64(s->point), s->t);
    const bool above = dot_f64(s->geometric, direction) > 0, crosses = reference_crosses(s, direction);
    const vec3_f64 from = above || crosses ? s->point : add_f64(s->point, s->lift);
    return madd_f64(from, crosses ? -0x1p-40 * size : 0x1p-40 * size, s->geometric);
}

bool reference_closest(const reference_scene *r, vec3_f64 origin, vec3_f64 direction, double t_far,
                       bool shadow, reference_random *random, reference_surface *out) {
    for (double passed = 0;; passed = out->t, origin = reference_leave(out, direction)) {
        query q = {origin, direction, shadow, random->time, {t_far - passed, 0, 0}, NULL};
        for (size_t i = 0; i < r->planes.count; ++i) test(r, r->planes.items[i], &q);
        for (uint32_t i = 0; i < r->primitives.count && r->settings.without_bvh; ++i) test(r, i, &q);
        if (r->tree.node_count && !r->settings.without_bvh) descend(r, 0, &q);
        if (!q.met) return false;
        make_surface(r, &q, out);
        out->t += passed;
        const bool classic = out->material->model == FATHOM_MODEL_CLASSIC;
        if (classic || reference_uniform(random) < (double)out->material->opacity) return true;
    }
}
