#include "verify/search/search_tree.h"
#include "verify/search/search.h"

#include <stdlib.h>
#include <string.h>

/* Minimum number of primitives of a sorted geometry. Runs of distant triangles reject nothing, and meshes
 * come in any order, so large geometries are sorted along a space-filling curve. */
#define SORTED_FROM 1024

bool search_tree_takes(const oracle_primitive *p) {
    for (unsigned k = 0; k < oracle_corners(p); ++k) {
        if (!finite_f32(p->v[k])) return false;
    }
    return true;
}

/* The radius is rounded up by far more than the rounding of a difference, a square root and a sum. */
static void set_bound(search_tree *tree, size_t slot, vec3_f64 center, double radius) {
    tree->bounds.x[slot] = center.x, tree->bounds.y[slot] = center.y, tree->bounds.z[slot] = center.z;
    tree->bounds.radius[slot] = radius * (1 + 0x1p-45) + FILTER_LEAST;
}

static double distance(vec3_f64 a, vec3_f64 b) {
    vec3_f64 d = sub_f64(a, b);
    return sqrt(dot_f64(d, d));
}

static oracle_primitive primitive_of(const world *w, const search_part *part, uint32_t geometry, size_t i) {
    return search_primitive(w, geometry, part->order ? part->order[i] : (uint32_t)i, FATHOM_NONE);
}

/* The bounding sphere, centred on the bounding box of all corners (for spheres: of their centres). For an
 * empty run it is NaN, and rejects nothing. */
static void enclose_primitives(search_tree *tree, const world *w, uint32_t geometry, size_t run) {
    const search_part *part = &tree->parts[geometry];
    size_t first = run * SEARCH_RUN, end = w->geometries.items[geometry].count;
    if (end - first > SEARCH_RUN) end = first + SEARCH_RUN;
    scene_bounds b = bounds_empty();
    for (size_t i = first; i < end; ++i) {
        oracle_primitive p = primitive_of(w, part, geometry, i);
        for (unsigned k = 0; search_tree_takes(&p) && k < oracle_corners(&p); ++k)
            bounds_add(&b, widen(p.v[k]));
    }
    vec3_f64 center = bounds_center(&b);
    double radius = 0;
    for (size_t i = first; i < end; ++i) {
        oracle_primitive p = primitive_of(w, part, geometry, i);
        for (unsigned k = 0; search_tree_takes(&p) && k < oracle_corners(&p); ++k) {
            vec3_f64 v = p.shape == ORACLE_SPHERE ? oracle_center(&p) : widen(p.v[k]);
            radius = fmax(radius, distance(v, center) + fabs(oracle_radius(&p)));
        }
    }
    set_bound(tree, part->slot[0] + run, center, radius);
}

static vec3_f64 center_of(const search_tree *tree, size_t slot) {
    return vec_f64(tree->bounds.x[slot], tree->bounds.y[slot], tree->bounds.z[slot]);
}

/* The bounding sphere of spheres. Spheres of empty runs (NaN) are skipped. */
static void enclose_spheres(search_tree *tree, size_t slot, size_t first, size_t end) {
    scene_bounds b = bounds_empty();
    for (size_t i = first; i < end; ++i) {
        if (!isnan(tree->bounds.x[i])) bounds_add(&b, center_of(tree, i));
    }
    vec3_f64 center = bounds_center(&b);
    double radius = 0;
    for (size_t i = first; i < end; ++i) {
        if (!isnan(tree->bounds.x[i]))
            radius = fmax(radius, distance(center_of(tree, i), center) + tree->bounds.radius[i]);
    }
    set_bound(tree, slot, center, radius);
}

static void enclose(search_tree *tree, const world *w, uint32_t geometry) {
    const search_part *part = &tree->parts[geometry];
    for (size_t run = 0; part->levels && run < part->count[0]; ++run)
        enclose_primitives(tree, w, geometry, run);
    for (unsigned level = 1; level < part->levels; ++level) {
        size_t from = part->slot[level - 1], end = from + part->count[level - 1];
        for (size_t i = 0; i < part->count[level]; ++i) {
            size_t first = from + i * SEARCH_RUN;
            enclose_spheres(tree, part->slot[level] + i, first,
                            end - first < SEARCH_RUN ? end : first + SEARCH_RUN);
        }
    }
}

/* ---- order ---- */

/* Spreads the lower ten bits of x with two zeros between them (Morton order). */
static uint32_t spread(uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

static uint32_t cell(double x, double low, double high) {
    double place = 1024 * ((x - low) / (high - low));
    return place >= 1023 ? 1023u : place > 0 ? (uint32_t)place : 0u;
}

static int by_key(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static bool sort(const world *w, uint32_t geometry, uint32_t *order) {
    uint32_t count = w->geometries.items[geometry].count;
    uint64_t *keys = malloc(count * sizeof *keys);
    if (!keys) return false;
    scene_bounds b = bounds_empty();
    for (uint32_t i = 0; i < count; ++i) {
        oracle_primitive p = search_primitive(w, geometry, i, FATHOM_NONE);
        if (search_tree_takes(&p)) bounds_add(&b, widen(p.v[0]));
    }
    for (uint32_t i = 0; i < count; ++i) {
        oracle_primitive p = search_primitive(w, geometry, i, FATHOM_NONE);
        vec3_f64 v = widen(p.v[0]);
        uint32_t code = spread(cell(v.x, b.lower.x, b.upper.x)) << 2 |
                        spread(cell(v.y, b.lower.y, b.upper.y)) << 1 |
                        spread(cell(v.z, b.lower.z, b.upper.z));
        keys[i] = (uint64_t)code << 32 | i;
    }
    qsort(keys, count, sizeof *keys, by_key);
    for (uint32_t i = 0; i < count; ++i) order[i] = (uint32_t)keys[i];
    free(keys);
    return true;
}

/* Assigns slots to the levels of each part. Returns the total number of spheres. */
static size_t lay_out(const world *w, search_tree *tree) {
    size_t slots = 0;
    for (size_t g = 0; g < w->geometries.count; ++g) {
        search_part *part = &tree->parts[g];
        size_t count = w->geometries.items[g].count;
        while (count > (part->levels ? SEARCH_RUN : 0)) {
            count = (count + SEARCH_RUN - 1) / SEARCH_RUN;
            part->slot[part->levels] = slots, part->count[part->levels++] = count;
            slots += count;
        }
    }
    return slots;
}

static bool sort_all(const world *w, search_tree *tree) {
    size_t total = 0;
    for (size_t g = 0; g < w->geometries.count; ++g) {
        if (w->geometries.items[g].count >= SORTED_FROM) total += w->geometries.items[g].count;
    }
    uint32_t *next = tree->order = malloc((total + 1) * sizeof *tree->order);
    if (!next) return false;
    for (uint32_t g = 0; g < w->geometries.count; ++g) {
        uint32_t count = w->geometries.items[g].count;
        if (count < SORTED_FROM) continue;
        tree->parts[g].order = next;
        next += count;
        if (!sort(w, g, tree->parts[g].order)) return false;
    }
    return true;
}

static double extent_of(const search_tree *tree, const world *w, uint32_t group,
                        const world_instance *placed) {
    const world_group *g = &w->groups.items[group];
    double most = 0, norm = 0, shift = 0;
    for (uint32_t k = g->first; k < g->first + g->count; ++k) {
        const search_part *part = &tree->parts[k];
        for (size_t i = 0; part->levels && i < part->count[part->levels - 1]; ++i) {
            size_t slot = part->slot[part->levels - 1] + i;
            double far = length_f64(center_of(tree, slot));
            if (isfinite(far)) most = fmax(most, far + tree->bounds.radius[slot]);
        }
    }
    if (!placed) return most;
    for (int i = 0; i < 12; ++i) {
        double part = fabs((double)placed->to_world[i / 4][i % 4]);
        *(i % 4 == 3 ? &shift : &norm) += part;
    }
    return norm * most + shift;
}

bool search_tree_build(const world *w, search_tree *tree) {
    tree->parts = calloc(w->geometries.count + 1, sizeof *tree->parts);
    if (!tree->parts) return false;
    size_t slots = lay_out(w, tree);
    double *all = malloc((4 * slots + 1) * sizeof *all);
    if (!all) return false;
    tree->bounds = (filter_spheres){all, all + slots, all + 2 * slots, all + 3 * slots};
    if (!sort_all(w, tree)) return false;
    for (uint32_t g = 0; g < w->geometries.count; ++g) enclose(tree, w, g);
    if (w->groups.count) tree->extent = extent_of(tree, w, 0, NULL);
    for (size_t k = 0; k < w->instances.count; ++k) {
        const world_instance *instance = &w->instances.items[k];
        tree->extent = fmax(tree->extent, extent_of(tree, w, instance->group, instance));
    }
    return true;
}

void search_tree_free(search_tree *tree) {
    free(tree->bounds.x);
    free(tree->parts);
    free(tree->order);
    memset(tree, 0, sizeof *tree);
}
