/* Building one tree: top down, where the surface area heuristic over 16 bins along each axis finds it
 * cheapest (Wald 2007, On fast construction of SAH-based bounding volume hierarchies). The upper levels are
 * split on one thread until enough pieces are there for all; pieces become subtrees of their own, which are
 * joined in order, so the tree does not depend on the threads. */
#include "base/array.h"
#include "base/threads.h"
#include "trace/bvh/bvh.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define BINS 16
/* Below this level items are halved: at most 48 + log2(2^32 / 4) levels, which the traversal's stack holds.
 */
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

/* Half the surface. Double: squares of floats do not overflow. */
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
    float begin[3], scale[3]; /* scale 0: all centres are in one place */
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

/* Leaves are tested whole, so what costs is blocks. */
static double side_cost(const box *b, uint32_t count) {
    return count ? box_area(b) * (double)((count + BVH_LEAF - 1) / BVH_LEAF) : 0;
}

/* The cheapest split along one axis: items of bins below *at go to the first side. */
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

/* Reorders the items; returns how many are on the first side, never 0 nor all. */
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

/* ---- subtrees ---- */

typedef ARRAY(bvh_node) node_array;

typedef struct piece {
    uint32_t node; /* of the upper levels; becomes the subtree's root */
    uint32_t begin, end;
    unsigned level;
    node_array nodes;
} piece;

typedef struct builder {
    const bvh_build *build;
    bvh_item *items;
    uint32_t piece_size; /* ranges of at most so many items are left to pieces */
    ARRAY(piece) pieces; /* NULL while pieces are built */
    atomic_bool failed, stopped;
    atomic_uint done;
} builder;

static void node_set(bvh_node *node, const box *b) {
    memcpy(node->lower, b->lower, sizeof node->lower);
    memcpy(node->upper, b->upper, sizeof node->upper);
}

/* The node `at` over items [begin, end), and all below it. False: out of memory. */
static bool build_node(builder *l, node_array *nodes, uint32_t at, uint32_t begin, uint32_t end,
                       unsigned level, bool leave_pieces) {
    box bounds = nothing, centers = nothing;
    for (uint32_t i = begin; i < end; ++i) {
        const bvh_item *item = &l->items[i];
        float c[3] = {item_center(item, 0), item_center(item, 1), item_center(item, 2)};
        box_join(&bounds, item->lower, item->upper);
        box_join(&centers, c, c);
    }
    node_set(&nodes->items[at], &bounds);
    if (end - begin <= BVH_LEAF) {
        nodes->items[at].first = begin, nodes->items[at].count = end - begin;
        return true;
    }
    if (leave_pieces && end - begin <= l->piece_size) {
        piece p = {.node = at, .begin = begin, .end = end, .level = level};
        return array_push(&l->pieces, p);
    }
    uint32_t middle = begin + split(l->items + begin, end - begin, &centers, level);
    if (!array_room(nodes, 2)) return false;
    uint32_t child = (uint32_t)nodes->count;
    nodes->count += 2;
    nodes->items[at].first = child, nodes->items[at].count = 0;
    return build_node(l, nodes, child, begin, middle, level + 1, leave_pieces) &&
           build_node(l, nodes, child + 1, middle, end, level + 1, leave_pieces);
}

static bool go_on(builder *l, double fraction) {
    if (l->build->go_on && !l->build->go_on(l->build->user, fraction)) atomic_store(&l->stopped, true);
    return !atomic_load(&l->stopped);
}

static void build_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    builder *l = user;
    for (size_t i = begin; i < end; ++i) {
        if (worker == 0) go_on(l, (double)atomic_load(&l->done) / (double)l->pieces.count);
        if (atomic_load(&l->stopped) || atomic_load(&l->failed)) return;
        piece *p = &l->pieces.items[i];
        bool fine = array_room(&p->nodes, (size_t)(p->end - p->begin));
        if (fine) {
            p->nodes.count = 1;
            fine = build_node(l, &p->nodes, 0, p->begin, p->end, p->level, false);
        }
        if (!fine) atomic_store(&l->failed, true);
        atomic_fetch_add(&l->done, 1);
    }
}

/* The pieces' nodes behind the upper ones, in order; a piece's own root takes its place among those. */
static bool join_pieces(builder *l, node_array *nodes) {
    size_t more = 0;
    for (size_t i = 0; i < l->pieces.count; ++i) more += l->pieces.items[i].nodes.count - 1;
    if (!array_room(nodes, more)) return false;
    for (size_t i = 0; i < l->pieces.count; ++i) {
        const piece *p = &l->pieces.items[i];
        uint32_t moved = (uint32_t)nodes->count - 1;
        for (size_t k = 0; k < p->nodes.count; ++k) {
            bvh_node node = p->nodes.items[k];
            if (!node.count) node.first += moved;
            nodes->items[k ? nodes->count++ : p->node] = node;
        }
    }
    return true;
}

static bool build_all(builder *l, uint32_t count, node_array *nodes) {
    if (!array_room(nodes, 1)) return false;
    nodes->count = 1;
    if (!build_node(l, nodes, 0, 0, count, 0, true)) return false;
    if (l->pieces.count) loop_parallel(l->build->threads, l->pieces.count, 1, build_pieces, l);
    if (atomic_load(&l->failed)) return false;
    return atomic_load(&l->stopped) || join_pieces(l, nodes);
}

fathom_status bvh_tree_build(const bvh_build *build, bvh_item *items, uint32_t count, bvh_tree *tree) {
    builder l = {.build = build, .items = items, .piece_size = count / 64 > 4096 ? count / 64 : 4096};
    node_array nodes = {0};
    bool fine = go_on(&l, 0) && count ? build_all(&l, count, &nodes) : true;
    for (size_t i = 0; i < l.pieces.count; ++i) array_free(&l.pieces.items[i].nodes);
    array_free(&l.pieces);
    tree->nodes = nodes.items, tree->node_count = (uint32_t)nodes.count;
    if (!fine) return fail_memory(build->context, count * sizeof(bvh_node));
    if (atomic_load(&l.stopped)) {
        return fail(build->context, FATHOM_INTERRUPTED, "building was stopped by the caller");
    }
    return FATHOM_OK;
}
