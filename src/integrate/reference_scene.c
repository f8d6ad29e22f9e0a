/* Shapes in double, and the rays that meet them: the reference intersectors for every primitive, or for those
 * in boxes that the ray crosses. */
#include "integrate/reference_inner.h"
#include "reference/reference.h"
#include "scene/graph.h"
#include "scene/mesh/absent.h"
#include "scene/motion/motion.h"

#include <stdlib.h>

/* ---- shapes ---- */

static vec3_f64 mesh_corner(const fathom_mesh *m, uint32_t triangle, size_t k) {
    return add_f64(load_f64(m->origin), color_of(mesh_vertex(m, m->indices[3 * (size_t)triangle + k])));
}

/* Sets the place's flags, too. */
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
    case SCENE_MESH:
        for (size_t k = 0; k < 4; ++k)
            p.corner[k] = mesh_corner(&s->meshes.items[o->index], triangle, k < 3 ? k : 2);
        *flags = s->meshes.items[o->index].flags;
        break;
    }
    return p;
}

static bool add_object(reference_scene *r, fathom_id id, reference_place at, fathom_id material) {
    const scene_object *o = &r->scene->objects.items[id];
    const uint32_t count = o->kind == SCENE_MESH ? r->scene->meshes.items[o->index].triangle_count : 1;
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

/* material: that of the outermost instance with one, or FATHOM_NONE. */
static bool add_group(reference_scene *r, const scene_graph *graph, uint32_t group,
                      const affine_f64 *to_world, fathom_id material) {
    reference_place at = {.to_world = *to_world};
    if (!affine_invert(to_world, &at.to_object)) return false;
    for (uint32_t i = graph->objects.first[group]; i < graph->objects.first[group + 1]; ++i) {
        if (!add_object(r, graph->objects.items[i], at, material)) return false;
    }
    for (uint32_t i = graph->instances.first[group]; i < graph->instances.first[group + 1]; ++i) {
        const fathom_instance *inner = &r->scene->instances.items[graph->instances.items[i]];
        affine_f64 map = motion_place(inner, r->scene->camera.shutter[0]);
        map = affine_compose(to_world, &map);
        if (!add_group(r, graph, inner->group, &map, material != FATHOM_NONE ? material : inner->material))
            return false;
    }
    return true;
}

/* A box in float around a primitive in the world. */
static bvh_item item_of(const reference_scene *r, uint32_t primitive) {
    const reference_primitive *p = &r->primitives.items[primitive];
    scene_bounds b = bounds_empty();
    for (int k = 0; k < 4 && p->kind != SCENE_SPHERE; ++k) bounds_add(&b, p->corner[k]);
    if (p->kind == SCENE_SPHERE)
        b = (scene_bounds){sub_f64(p->corner[0], p->corner[1]), add_f64(p->corner[0], p->corner[1])};
    b = bounds_transformed(&b, &r->places.items[p->place].to_world);
    /* Some times float's rounding. */
    const vec3_f64 margin = gray(0x1p-20 * fmax(length_f64(b.lower), length_f64(b.upper)));
    bvh_item item = {.id = primitive};
    store_f32(item.lower, narrow(sub_f64(b.lower, margin)));
    store_f32(item.upper, narrow(add_f64(b.upper, margin)));
    return item;
}

static fathom_status build_tree(reference_scene *r) {
    r->items = malloc((r->primitives.count + 1) * sizeof *r->items);
    if (!r->items) return fail_memory(r->scene->context, r->primitives.count * sizeof *r->items);
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->primitives.count; ++i) {
        if (r->primitives.items[i].kind != SCENE_PLANE) r->items[count++] = item_of(r, i);
    }
    const bvh_build build = {.context = r->scene->context};
    return bvh_tree_build(&build, r->items, count, &r->tree);
}

fathom_status reference_gather(reference_scene *r) {
    scene_graph graph;
    fathom_status status = graph_create(r->scene, &graph);
    if (status != FATHOM_OK) return status;
    const affine_f64 identity = affine_identity();
    if (!add_group(r, &graph, FATHOM_ROOT, &identity, FATHOM_NONE))
        status = fail_memory(r->scene->context, r->primitives.count * sizeof *r->primitives.items);
    graph_destroy(&graph);
    return status == FATHOM_OK ? build_tree(r) : status;
}

/* ---- rays ---- */

typedef struct query {
    vec3_f64 origin, direction;
    bool shadow;
    reference_hit_f64 hit; /* the closest so far; before there is one, t is where the ray ends */
    const reference_primitive *met;
} query;

static void test(const reference_scene *r, uint32_t primitive, query *q) {
    const reference_primitive *p = &r->primitives.items[primitive];
    const reference_place *at = &r->places.items[p->place];
    if (q->shadow && at->flags & FATHOM_CASTS_NO_SHADOW) return;
    const vec3_f64 o = affine_point(&at->to_object, q->origin),
                   d = affine_vector(&at->to_object, q->direction);
    const vec3_f64 *c = p->corner;
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

static bool crosses(const bvh_node *n, const query *q) {
    double enter = 0, leave = q->hit.t, o[3], d[3];
    store_f64(o, q->origin);
    store_f64(d, q->direction);
    for (int k = 0; k < 3; ++k) {
        const double x = ((double)n->lower[k] - o[k]) / d[k], y = ((double)n->upper[k] - o[k]) / d[k];
        enter = fmax(enter, fmin(x, y)), leave = fmin(leave, fmax(x, y));
    }
    return enter <= leave;
}

static void descend(const reference_scene *r, uint32_t at, query *q) {
    const bvh_node *node = &r->tree.nodes[at];
    if (!crosses(node, q)) return;
    for (uint32_t i = node->first; i < node->first + node->count; ++i) test(r, r->items[i].id, q);
    if (node->count) return;
    descend(r, node->first, q);
    descend(r, node->first + 1, q);
}

/* ---- surfaces ---- */

static vec3_f64 vertex_normals(const fathom_mesh *m, const query *q, vec3_f64 flat) {
    if (!m->normals) return flat;
    const uint32_t *index =
        (m->normal_indices ? m->normal_indices : m->indices) + 3 * (size_t)q->met->triangle;
    const double weight[3] = {1 - q->hit.u - q->hit.v, q->hit.u, q->hit.v};
    vec3_f64 sum = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        const void *n = (const char *)m->normals + index[k] * m->normal_stride;
        sum = madd_f64(sum, weight[k], color_of(n));
    }
    return length_f64(sum) > 0 ? sum : flat;
}

/* The shading normal is turned to the viewer's side, which the geometric one tells; where it still faces away
 * from the viewer, the geometric one takes its place. */
static void make_surface(const reference_scene *r, const query *q, reference_surface *out) {
    const reference_primitive *p = q->met;
    const reference_place *at = &r->places.items[p->place];
    const vec3_f64 *c = p->corner;
    out->point = madd_f64(q->origin, q->hit.t, q->direction);
    out->to_viewer = neg_f64(q->direction);
    out->material = &r->scene->materials.items[at->material].value;
    out->t = q->hit.t;
    vec3_f64 own = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    if (p->kind == SCENE_SPHERE) own = sub_f64(affine_point(&at->to_object, out->point), c[0]);
    if (p->kind == SCENE_PLANE) own = c[1];
    out->normal = p->kind == SCENE_MESH ? vertex_normals(&r->scene->meshes.items[p->mesh], q, own) : own;
    out->geometric = normalize_f64(affine_transposed_vector(&at->to_object, own));
    out->normal = normalize_f64(affine_transposed_vector(&at->to_object, out->normal));
    out->behind = dot_f64(out->geometric, out->to_viewer) < 0;
    if (out->behind) out->geometric = neg_f64(out->geometric);
    if (dot_f64(out->normal, out->geometric) < 0) out->normal = neg_f64(out->normal);
    if (!(dot_f64(out->normal, out->to_viewer) > 0)) out->normal = out->geometric;
}

/* Some thousand times the error of a point in double, and far below what can be seen. */
vec3_f64 reference_leave(const reference_surface *s, vec3_f64 direction) {
    const double size = fmax(length_f64(s->point), s->t);
    return madd_f64(s->point, copysign(0x1p-40 * size, dot_f64(s->geometric, direction)), s->geometric);
}

bool reference_closest(const reference_scene *r, vec3_f64 origin, vec3_f64 direction, double t_far,
                       bool shadow, reference_random *random, reference_surface *out) {
    for (double passed = 0;; passed = out->t, origin = reference_leave(out, direction)) {
        query q = {origin, direction, shadow, {t_far - passed, 0, 0}, NULL};
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
