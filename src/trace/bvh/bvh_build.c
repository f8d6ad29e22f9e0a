/* Builds one tree from the top down. Each split minimises the surface area heuristic over 16 bins per axis
 * (Wald 2007, On fast construction of SAH-based bounding volume hierarchies). */
#include "base/array.h"
#include "trace/bvh/bvh.h"

#include <math.h>
#include <string.h>

#define BINS 16
/* Below this level, items are split at the median index, because the traversal stack holds 48 + log2(2^32 /
 * 4) levels. */
#define SPLIT_LEVELS 48

/* ---- boxes ---- */

typedef struct box {
    float lower[3], upper[3];
} box;

static const box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void box_join(box *b, const float lower[3], const float upper[3]) {
    for (int k = 0; k < 3; ++k) {
        b->lower[k] = lower[k] < b->lower[k] ? lower[k] : b->lower[k];
        b->upper[k] = upper[k] > b->upper[k] ? upper[k] : b->upper[k];
    }
}

/* Half the surface area. In double, squares of floats do not overflow. */
static double box_area(const box *b) {
    double x = (double)b->upper[0] - (double)b->lower[0], y = (double)b->upper[1] - (double)b->lower[1],
           z = (double)b->upper[2] - (double)b->lower[2];
    return x * y + y * z + z * x;
}

static float item_center(const bvh_item *item, int axis) {
    return 0.5f * item->lower[axis] + 0.5f * item->upper[axis];
}

/* ---- where to split ---- */

typedef struct bins {
    box boxes[3][BINS];
    uint32_t counts[3][BINS];
    float begin[3], scale[3]; /* scale 0: all centres are equal */
} bins;

static unsigned bin_of(const bins *b, const bvh_item *item, int axis) {
    unsigned i = (unsigned)((item_center(item, axis) - b->begin[axis]) * b->scale[axis]);
    return i < BINS ? i : BINS - 1;
}

static void bins_fill(bins *b, const bvh_item *items, uint32_t count, const box *centers) {
    for (int k = 0; k < 3; ++k) {
        float extent = centers->upper[k] - centers->lower[k], scale = (float)BINS / extent;
        b->begin[k] = centers->lower[k];
        b->scale[k] = extent > 0 && scale < INFINITY ? scale : 0;
        for (int i = 0; i < BINS; ++i) b->boxes[k][i] = nothing, b->counts[k][i] = 0;
    }
    for (uint32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            unsigned bin = bin_of(b, &items[i], k);
            box_join(&b->boxes[k][bin], items[i].lower, items[i].upper);
            ++b->counts[k][bin];
        }
    }
}

static double side_cost(const box *b, uint32_t count) { return count ? box_area(b) * (double)count : 0; }

/* Returns the cost of the cheapest split along one axis: items of bins below *at go to the first side. */
static double axis_cost(const bins *b, int axis, unsigned *at) {
    double above[BINS], best = HUGE_VAL;
    box side = nothing;
    uint32_t count = 0;
    for (unsigned i = BINS; i-- > 1;) {
        box_join(&side, b->boxes[axis][i].lower, b->boxes[axis][i].upper);
        count += b->counts[axis][i];
        above[i] = count ? side_cost(&side, count) : HUGE_VAL;
    }
    side = nothing, count = 0;
    for (unsigned i = 1; i < BINS; ++i) {
        box_join(&side, b->boxes[axis][i - 1].lower, b->boxes[axis][i - 1].upper);
        count += b->counts[axis][i - 1];
        double cost = count ? side_cost(&side, count) + above[i] : HUGE_VAL;
        if (cost < best) best = cost, *at = i;
    }
    return best;
}

/* Reorders the items. Returns the number on the first side, never 0 or all. */
static uint32_t split(bvh_item *items, uint32_t count, const box *centers, unsigned level) {
    bins b;
    int axis = -1;
    unsigned at = 0;
    double best = HUGE_VAL;
    bool by_cost = level < SPLIT_LEVELS;
    if (by_cost) bins_fill(&b, items, count, centers);
    for (int k = 0; by_cost && k < 3; ++k) {
        unsigned where = 0;
        double cost = b.scale[k] > 0 ? axis_cost(&b, k, &where) : HUGE_VAL;
        if (cost < best) best = cost, axis = k, at = where;
    }
    if (axis < 0) return count / 2;
    uint32_t first = 0, last = count;
    while (first < last) {
        if (bin_of(&b, &items[first], axis) < at) {
            ++first;
        } else {
            bvh_item swap = items[--last];
            items[last] = items[first], items[first] = swap;
        }
    }
    return first;
}

/* ---- nodes ---- */

typedef struct builder {
    const bvh_build *build;
    bvh_item *items;
    uint32_t count;
    ARRAY(bvh_node) nodes;
    bool stopped;
} builder;

/* Nodes with fewer items do not call go_on(): they take less than 10 ms. */
#define ASK_LEAST 65536

/* Reports progress: the items before `begin` are done. False: stop. */
static bool go_on(builder *b, uint32_t begin, uint32_t end) {
    if (begin && end - begin < ASK_LEAST) return true;
    const bvh_build *build = b->build;
    b->stopped = build->go_on && !build->go_on(build->user, (double)begin / (b->count ? b->count : 1));
    return !b->stopped;
}

/* Builds the node `at` over items [begin, end), and its subtree. False: out of memory, or stopped. */
static bool build_node(builder *b, uint32_t at, uint32_t begin, uint32_t end, unsigned level) {
    box bounds = nothing, centers = nothing;
    for (uint32_t i = begin; i < end; ++i) {
        const bvh_item *item = &b->items[i];
        float c[3] = {item_center(item, 0), item_center(item, 1), item_center(item, 2)};
        box_join(&bounds, item->lower, item->upper);
        box_join(&centers, c, c);
    }
    bvh_node *node = &b->nodes.items[at];
    *node = (bvh_node){.first = begin, .count = end - begin};
    memcpy(node->lower, bounds.lower, sizeof node->lower);
    memcpy(node->upper, bounds.upper, sizeof node->upper);
    if (end - begin <= BVH_LEAF) return true;
    if (!go_on(b, begin, end) || !array_room(&b->nodes, 2)) return false;
    const uint32_t child = (uint32_t)b->nodes.count;
    const uint32_t middle = begin + split(b->items + begin, end - begin, &centers, level);
    b->nodes.count += 2;
    b->nodes.items[at].first = child, b->nodes.items[at].count = 0;
    return build_node(b, child, begin, middle, level + 1) && build_node(b, child + 1, middle, end, level + 1);
}

fathom_status bvh_tree_build(const bvh_build *build, bvh_item *items, uint32_t count, bvh_tree *tree) {
    builder b = {.build = build, .items = items, .count = count};
    bool fine = go_on(&b, 0, count);
    if (fine && count) {
        fine = array_room(&b.nodes, 1);
        b.nodes.count = fine;
        fine = fine && build_node(&b, 0, 0, count, 0);
    }
    tree->nodes = b.nodes.items, tree->node_count = (uint32_t)b.nodes.count;
    if (fine) return FATHOM_OK;
    if (b.stopped) return fail(build->context, FATHOM_INTERRUPTED, "building was stopped by the caller");
    return fail_memory(build->context, count * sizeof(bvh_node));
}
