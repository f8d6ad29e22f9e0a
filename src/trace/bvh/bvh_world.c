/* Builds the trees of a world: the boxes of all items, and the slack of their tests. */
#include "base/array.h"
#include "trace/bvh/bvh.h"
#include "trace/search.h"

#include <stdio.h>
#include <stdlib.h>

typedef ARRAY(bvh_item) item_array;

static void item_empty(bvh_item *item) {
    for (int k = 0; k < 3; ++k) item->lower[k] = INFINITY, item->upper[k] = -INFINITY;
}

static void item_add(bvh_item *item, vec3_f32 p) {
    const float c[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
        item->lower[k] = c[k] < item->lower[k] ? c[k] : item->lower[k];
        item->upper[k] = c[k] > item->upper[k] ? c[k] : item->upper[k];
    }
}

/* ---- boxes of primitives; false: never hit ---- */

/* A float strictly below or above x, by at least half an ulp. */
static float below(double x) { return nextafterf((float)x, -INFINITY); }
static float above(double x) { return nextafterf((float)x, INFINITY); }

static bool sphere_box(const world_sphere *s, bvh_item *item) {
    if (!finite_f32(s->center) || !isfinite(s->radius)) return false;
    double c[3], radius = world_sphere_radius(s);
    store_f64(c, world_sphere_center(s));
    for (int k = 0; k < 3; ++k) {
        item->lower[k] = below(c[k] - radius);
        item->upper[k] = above(c[k] + radius);
    }
    return true;
}

/* Triangles and quads with a corner that is not finite are never hit. */
static bool primitive_box(const world *w, const world_geometry *geometry, uint32_t k, bvh_item *item) {
    if (geometry->kind == WORLD_SPHERES) return sphere_box(&w->spheres.items[geometry->first + k], item);
    vec3_f32 v[4];
    const unsigned corners = search_flat(w, geometry, k, v);
    for (unsigned c = 0; c < corners; ++c) {
        if (!finite_f32(v[c])) return false;
        item_add(item, v[c]);
    }
    return true;
}

/* ---- the tree of a geometry ---- */

static fathom_status fill_items(const bvh_build *build, const item_array *items, bvh_tree *tree) {
    tree->count = (uint32_t)items->count;
    tree->items = malloc(items->count * sizeof *tree->items);
    if (!tree->items) return fail_memory(build->context, items->count * sizeof *tree->items);
    for (size_t i = 0; i < items->count; ++i) tree->items[i] = items->items[i].id;
    return FATHOM_OK;
}

static fathom_status build_geometry(const bvh_build *build, const world *w, uint32_t index, bvh_tree *tree) {
    const world_geometry *geometry = &w->geometries.items[index];
    *tree = (bvh_tree){.geometry = geometry};
    /* A reported hit point lies within 256 unit roundoffs of the distance from its sphere (bvh_text.h). */
    if (geometry->kind == WORLD_SPHERES) tree->spread = 512;
    item_array items = {0};
    if (!array_room(&items, geometry->count))
        return fail_memory(build->context, geometry->count * sizeof(bvh_item));
    for (uint32_t k = 0; k < geometry->count; ++k) {
        bvh_item *item = &items.items[items.count];
        item_empty(item);
        item->id = k;
        items.count += primitive_box(w, geometry, k, item);
    }
    fathom_status status = bvh_tree_build(build, items.items, (uint32_t)items.count, tree);
    if (status == FATHOM_OK && items.count) status = fill_items(build, &items, tree);
    array_free(&items);
    return status;
}

/* ---- the tree of a group ---- */

/* The largest row sum of the linear part: bounds how much the map enlarges the largest coordinate of a
 * vector. */
static double norm(const affine_f64 *map) {
    double most = 0;
    for (int r = 0; r < 3; ++r)
        most = fmax(most, fabs(map->m[r][0]) + fabs(map->m[r][1]) + fabs(map->m[r][2]));
    return most;
}

static double largest_of(const float a[3], const float b[3]) {
    double most = 0;
    for (int k = 0; k < 3; ++k) most = fmax(most, fmax(fabs((double)a[k]), fabs((double)b[k])));
    return most;
}

/* Sets the world box of an instance, and adds the rounding of its rays to the tree's slack: see bvh_text.h.
 * If the map cannot be inverted, the box contains everything. */
static void instance_box(const world_instance *instance, const bvh_tree *inside, bvh_item *item,
                         bvh_tree *tree) {
    const affine_f64 to_object = affine_widen(instance->to_object);
    affine_f64 to_world;
    if (!affine_invert(&to_object, &to_world)) {
        for (int k = 0; k < 3; ++k) item->lower[k] = -0x1p120f, item->upper[k] = 0x1p120f;
        return;
    }
    const bvh_node *root = &inside->nodes[0];
    double shift = fmax(fabs(to_object.m[0][3]), fmax(fabs(to_object.m[1][3]), fabs(to_object.m[2][3])));
    double grow = norm(&to_world), condition = grow * norm(&to_object), extent = 0;
    double pad = 64 * 0x1p-53 * condition * grow * (largest_of(root->lower, root->upper) + shift);
    const scene_bounds box = {widen(load_f32(root->lower)), widen(load_f32(root->upper))},
                       placed = bounds_transformed(&box, &to_world);
    double lower[3], upper[3];
    store_f64(lower, placed.lower), store_f64(upper, placed.upper);
    for (int k = 0; k < 3; ++k) {
        item->lower[k] = below(lower[k] - pad), item->upper[k] = above(upper[k] + pad);
        extent = fmax(extent, (double)root->upper[k] - (double)root->lower[k]);
    }
    tree->spread = fmax(tree->spread, condition * (inside->spread + 32));
    tree->offset =
        fmax(tree->offset, condition * inside->offset +
                               8 * (condition * largest_of(item->lower, item->upper) + grow * shift));
    tree->reach = fmax(tree->reach, grow * (extent + inside->reach));
}

static bool add_instances(const bvh_tracer *tracer, item_array *items, bvh_tree *tree) {
    const world *w = tracer->base.world;
    for (size_t k = 0; k < w->instances.count; ++k) {
        const bvh_tree *inside = &tracer->groups[w->instances.items[k].group];
        if (!inside->node_count) continue;
        bvh_item item = {.id = (uint32_t)(w->geometries.count + k)};
        instance_box(&w->instances.items[k], inside, &item, tree);
        if (!array_push(items, item)) return false;
    }
    return true;
}

static bool add_geometries(const bvh_tracer *tracer, const world_group *group, item_array *items,
                           bvh_tree *tree) {
    for (uint32_t g = group->first; g < group->first + group->count; ++g) {
        const bvh_tree *part = &tracer->geometries[g];
        if (!part->node_count) continue;
        bvh_item item = {.id = g};
        for (int k = 0; k < 3; ++k)
            item.lower[k] = part->nodes[0].lower[k], item.upper[k] = part->nodes[0].upper[k];
        tree->spread = fmax(tree->spread, part->spread);
        if (!array_push(items, item)) return false;
    }
    return true;
}

static fathom_status build_group(const bvh_build *build, bvh_tracer *tracer, uint32_t index) {
    bvh_tree *tree = &tracer->groups[index];
    *tree = (bvh_tree){.geometry = NULL};
    item_array items = {0};
    fathom_status status = FATHOM_OK;
    if (!add_geometries(tracer, &tracer->base.world->groups.items[index], &items, tree) ||
        (index == 0 && !add_instances(tracer, &items, tree)))
        status = fail_memory(build->context, (items.count + 1) * sizeof *items.items);
    if (status == FATHOM_OK) status = bvh_tree_build(build, items.items, (uint32_t)items.count, tree);
    if (status == FATHOM_OK && items.count) status = fill_items(build, &items, tree);
    array_free(&items);
    return status;
}

/* ---- the world ---- */

static fathom_status build_world(const bvh_build *build, bvh_tracer *tracer) {
    const world *w = tracer->base.world;
    tracer->geometries = calloc(w->geometries.count + 1, sizeof *tracer->geometries);
    tracer->groups = calloc(w->groups.count, sizeof *tracer->groups);
    if (!tracer->geometries || !tracer->groups)
        return fail_memory(build->context, (w->geometries.count + w->groups.count) * sizeof(bvh_tree));
    fathom_status status = FATHOM_OK;
    for (uint32_t g = 0; g < w->geometries.count && status == FATHOM_OK; ++g)
        status = build_geometry(build, w, g, &tracer->geometries[g]);
    /* The root group comes first in the array and is built last, because it contains the others. */
    for (uint32_t g = (uint32_t)w->groups.count; g-- > 0 && status == FATHOM_OK;)
        status = build_group(build, tracer, g);
    return status;
}

/* ---- life ---- */

static void tree_free(bvh_tree *tree) {
    free(tree->nodes);
    free(tree->items);
}

static uint64_t tree_bytes(const bvh_tree *tree) {
    return tree->node_count * sizeof *tree->nodes + tree->count * sizeof *tree->items;
}

void bvh_destroy(trace_tracer *base) {
    bvh_tracer *tracer = (bvh_tracer *)base;
    const world *w = base->world;
    for (size_t g = 0; tracer->geometries && g < w->geometries.count; ++g) tree_free(&tracer->geometries[g]);
    for (size_t g = 0; tracer->groups && g < w->groups.count; ++g) tree_free(&tracer->groups[g]);
    free(tracer->geometries);
    free(tracer->groups);
    free(tracer);
}

fathom_status bvh_create(fathom_context *context, const world *w, const trace_spec *spec,
                         const trace_options *options, trace_tracer **out) {
    static const struct {
        const trace_ops *ops;
        double unit;
        const char *name;
    } precisions[] = {[TRACE_F32] = {&bvh_ops_f32, 0x1p-24, "f32"},
                      [TRACE_F64] = {&bvh_ops_f64, 0x1p-53, "f64"},
                      [TRACE_F128] = {&bvh_ops_f128, 0x1p-113, "f128"}};
    bvh_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = precisions[spec->precision].ops;
    tracer->base.world = w;
    tracer->base.unit = precisions[spec->precision].unit;
    snprintf(tracer->base.name, sizeof tracer->base.name, "reference BVH, %s",
             precisions[spec->precision].name);
    const bvh_build build = {.context = context, .go_on = options->progress, .user = options->user};
    fathom_status status = build_world(&build, tracer);
    if (status != FATHOM_OK) {
        bvh_destroy(&tracer->base);
        return status;
    }
    for (size_t g = 0; g < w->geometries.count; ++g)
        tracer->base.bvh_bytes += tree_bytes(&tracer->geometries[g]);
    for (size_t g = 0; g < w->groups.count; ++g) tracer->base.bvh_bytes += tree_bytes(&tracer->groups[g]);
    *out = &tracer->base;
    return FATHOM_OK;
}
