/* Top-down build: a node's items are split in two until there are eight pieces, the piece of highest cost
 * first. Each split is the cheapest of 15 on each axis. The cost of a piece is its power times the area of
 * its box times the spread of its axes (Conty Estevez and Kulla 2018; the spread here is 1 minus the length
 * of the mean axis, which can be summed over bins; a cone cannot). Pieces of up to 64 items are split at
 * multiples of eight, so that nearly all nodes are full. */
#include "base/array.h"
#include "light/tree.h"

#include <float.h>
#include <stdlib.h>

/* Splits of more items than LOOKED_AT examine a subset, evenly spaced in memory. */
enum { BINS = 16, LOOKED_AT = 4096 };

/* Bounds of some items; can be summed. */
typedef struct sums {
    float lower[3], upper[3];
    double power, axis[3]; /* axes weighted by power, the largest coordinate positive */
    uint32_t count;
} sums;

/* Items [first, first + count). */
typedef struct piece {
    uint32_t first;
    sums all;
} piece;

typedef struct builder {
    tree_item *items;
    ARRAY(tree_node) nodes;
    ARRAY(uint32_t) parent;
    uint32_t *slot_of;
    float scale;
} builder;

/* ---- bounds ---- */

static sums no_sums(void) {
    return (sums){.lower = {FLT_MAX, FLT_MAX, FLT_MAX}, .upper = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
}

static inline void widen_to(sums *s, const float lower[3], const float upper[3]) {
    for (int k = 0; k < 3; ++k) {
        s->lower[k] = lower[k] < s->lower[k] ? lower[k] : s->lower[k];
        s->upper[k] = upper[k] > s->upper[k] ? upper[k] : s->upper[k];
    }
}

static inline double sign_of(const float axis[3]) {
    float x = fabsf(axis[0]), y = fabsf(axis[1]), z = fabsf(axis[2]);
    float largest = x >= y && x >= z ? axis[0] : (y >= z ? axis[1] : axis[2]);
    return largest < 0 ? -1 : 1;
}

static inline void add_item(sums *s, const tree_item *item) {
    const double weight = (double)item->power * sign_of(item->axis);
    widen_to(s, item->lower, item->upper);
    for (int k = 0; k < 3; ++k) s->axis[k] += weight * (double)item->axis[k];
    s->power += (double)item->power;
    ++s->count;
}

static void join(sums *s, const sums *other) {
    if (!other->count) return;
    widen_to(s, other->lower, other->upper);
    for (int k = 0; k < 3; ++k) s->axis[k] += other->axis[k];
    s->power += other->power;
    s->count += other->count;
}

static sums sums_of(const tree_item *items, uint32_t count) {
    sums all = no_sums();
    for (uint32_t i = 0; i < count; ++i) add_item(&all, &items[i]);
    return all;
}

/* A point has no area but must have a cost: a fraction of the longest side is added. */
static double cost_of(const sums *s) {
    if (!s->count) return 0;
    double x = (double)s->upper[0] - (double)s->lower[0], y = (double)s->upper[1] - (double)s->lower[1],
           z = (double)s->upper[2] - (double)s->lower[2], longest = fmax(x, fmax(y, z));
    double mean = length_f64(load_f64(s->axis)) / s->power;
    return s->power * (x * y + y * z + z * x + 0.1 * longest * longest) * (1.25 - mean);
}

/* ---- cuts ---- */

static inline float middle_of(const tree_item *item, int axis) {
    return 0.5f * item->lower[axis] + 0.5f * item->upper[axis];
}

/* The grid of bins for the items' centres. */
typedef struct grid {
    float from[3], scale[3];
} grid;

static inline int bin_of(const grid *g, const tree_item *item, int axis) {
    float at = (middle_of(item, axis) - g->from[axis]) * g->scale[axis];
    int bin = (int)(at < BINS - 1 ? at : BINS - 1);
    return bin > 0 ? bin : 0;
}

static grid grid_of(const tree_item *items, uint32_t count, uint32_t step) {
    sums middles = no_sums();
    grid g;
    for (uint32_t i = 0; i < count; i += step) {
        float at[3] = {middle_of(&items[i], 0), middle_of(&items[i], 1), middle_of(&items[i], 2)};
        widen_to(&middles, at, at);
    }
    for (int k = 0; k < 3; ++k) {
        float extent = middles.upper[k] - middles.lower[k];
        g.from[k] = middles.lower[k];
        g.scale[k] = extent > 0 ? fminf((float)BINS * (1 - 0x1p-20f) / extent, FLT_MAX) : 0;
    }
    return g;
}

/* Items in bins below `bin` of the axis go first. */
typedef struct cut {
    int axis, bin;
    uint32_t below; /* how many of the examined items */
    double cost;
} cut;

static void try_axis(const sums bins[BINS], int axis, double longer, cut *best) {
    double above[BINS];
    sums s = no_sums();
    for (int b = BINS - 1; b > 0; --b) join(&s, &bins[b]), above[b] = cost_of(&s);
    s = no_sums();
    uint32_t all = 0;
    for (int b = 0; b < BINS; ++b) all += bins[b].count;
    for (int b = 1; b < BINS; ++b) {
        join(&s, &bins[b - 1]);
        double cost = longer * (cost_of(&s) + above[b]);
        if (s.count > 0 && s.count < all && cost < best->cost) *best = (cut){axis, b, s.count, cost};
    }
}

static cut find_cut(const tree_item *items, uint32_t count, uint32_t step, const grid *g) {
    sums bins[3][BINS];
    cut best = {.axis = -1, .cost = INFINITY};
    for (int b = 0; b < 3 * BINS; ++b) bins[b / BINS][b % BINS] = no_sums();
    for (uint32_t i = 0; i < count; i += step) {
        for (int k = 0; k < 3; ++k) add_item(&bins[k][bin_of(g, &items[i], k)], &items[i]);
    }
    float longest = FLT_MAX; /* scale of the longest side */
    for (int k = 0; k < 3; ++k) longest = g->scale[k] > 0 ? fminf(longest, g->scale[k]) : longest;
    for (int k = 0; k < 3; ++k) {
        if (g->scale[k] > 0) try_axis(bins[k], k, (double)g->scale[k] / (double)longest, &best);
    }
    return best;
}

static inline void swap(tree_item *a, tree_item *b) {
    tree_item keep = *a;
    *a = *b, *b = keep;
}

static uint32_t part_by_bins(tree_item *items, uint32_t count, const grid *g, const cut *c) {
    uint32_t low = 0, high = count;
    while (low < high) {
        if (bin_of(g, &items[low], c->axis) < c->bin)
            ++low;
        else
            swap(&items[low], &items[--high]);
    }
    return low;
}

static int by_middle(const tree_item *a, const tree_item *b, int axis) {
    float x = middle_of(a, axis), y = middle_of(b, axis);
    return x < y ? -1 : (x > y ? 1 : 0);
}

/* Insertion sort, for few items. */
static void sort_along(tree_item *items, uint32_t count, int axis) {
    for (uint32_t i = 1; i < count; ++i) {
        for (uint32_t k = i; k > 0 && by_middle(&items[k], &items[k - 1], axis) < 0; --k)
            swap(&items[k], &items[k - 1]);
    }
}

/* Splits the items; returns how many go first. */
static uint32_t part(tree_item *items, uint32_t count) {
    const uint32_t step = count / LOOKED_AT + 1;
    const grid g = grid_of(items, count, step);
    cut c = find_cut(items, count, step, &g);
    if (c.axis < 0) { /* all centres are equal, or costs overflow double */
        uint32_t half = count / 2;
        return count > TREE_WIDE * TREE_WIDE ? half : (half + TREE_WIDE - 1) / TREE_WIDE * TREE_WIDE;
    }
    if (count > TREE_WIDE * TREE_WIDE) {
        return part_by_bins(items, count, &g, &c);
    }
    sort_along(items, count, c.axis);
    const uint32_t full = (c.below + TREE_WIDE / 2) / TREE_WIDE * TREE_WIDE;
    const uint32_t most = (count - 1) / TREE_WIDE * TREE_WIDE;
    return full < TREE_WIDE ? TREE_WIDE : (full > most ? most : full);
}

/* ---- nodes ---- */

/* A node of beams alone is a beam, if all of them lead to one side. The margin is 1e-6 and more of an angle.
 */
static bool bound_beams(const tree_item *items, uint32_t count, tree_node *node, int k) {
    vec3_f64 sum = {0, 0, 0};
    double widest = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (!items[i].beam) return false;
        sum = madd_f64(sum, (double)items[i].power, widen(load_f32(items[i].axis)));
    }
    sum = normalize_f64(sum);
    for (uint32_t i = 0; i < count; ++i) {
        const double off = acos(fmin(fmax(dot_f64(widen(load_f32(items[i].axis)), sum), -1), 1));
        widest = fmax(widest, off + acos(fmin((double)items[i].spread, 1)));
    }
    if (!(widest < 1.5)) return false;
    node->axis_x[k] = (float)sum.x, node->axis_y[k] = (float)sum.y, node->axis_z[k] = (float)sum.z;
    node->spread[k] = (float)(0x1p-20 - cos(widest));
    return true;
}

/* The cosine of the widest angle between an axis and the directions of an item. */
static double spread_around(const tree_item *item, vec3_f64 axis) {
    if (item->beam) return 0;
    const double own = (double)item->spread, cosine = fabs(dot_f64(widen(load_f32(item->axis)), axis));
    return own < 1 ? cos(acos(fmin(cosine, 1)) + acos(own)) : cosine;
}

/* The power-weighted mean axis, and the widest angle from it. */
static void bound_axes(const tree_item *items, uint32_t count, tree_node *node, int k) {
    vec3_f64 sum = {0, 0, 0};
    double least = 1;
    if (bound_beams(items, count, node, k)) return;
    for (uint32_t i = 0; i < count; ++i) {
        vec3_f64 axis = widen(load_f32(items[i].axis));
        sum = madd_f64(sum, (double)items[i].power * (dot_f64(axis, sum) < 0 ? -1 : 1), axis);
    }
    sum = normalize_f64(sum);
    for (uint32_t i = 0; i < count; ++i) {
        least = fmin(least, spread_around(&items[i], sum));
    }
    node->axis_x[k] = (float)sum.x, node->axis_y[k] = (float)sum.y, node->axis_z[k] = (float)sum.z;
    node->spread[k] = (float)fmax(least - 0x1p-20, 0);
}

/* A millionth covers rounding errors. */
static void bound_places(const sums *all, float scale, tree_node *node, int k) {
    float *const middle[3] = {&node->x[k], &node->y[k], &node->z[k]};
    float *const half[3] = {&node->half_x[k], &node->half_y[k], &node->half_z[k]};
    for (int c = 0; c < 3; ++c) {
        const double lower = (double)all->lower[c], upper = (double)all->upper[c];
        const double at = 0.5 * lower + 0.5 * upper, side = 0.5 * upper - 0.5 * lower;
        *middle[c] = (float)((double)scale * at);
        *half[c] = (float)((double)scale * (side * (1 + 0x1p-20) + 0x1p-22 * fabs(at)));
    }
}

static piece piece_of(const tree_item *items, uint32_t first, uint32_t count) {
    return (piece){first, sums_of(items + first, count)};
}

/* The piece to split next: the one of highest cost among those with more than one item; if `small`, the one
 * with most items among those that do not fit in a child's node. -1: none. */
static int costliest(const piece pieces[TREE_WIDE], uint32_t count, bool small) {
    int found = -1;
    double most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        double cost = small ? (double)pieces[i].all.count : cost_of(&pieces[i].all);
        if (pieces[i].all.count > (small ? TREE_WIDE : 1) && cost > most) found = (int)i, most = cost;
    }
    return found;
}

static uint32_t cut_up(tree_item *items, piece pieces[TREE_WIDE]) {
    const bool small = pieces[0].all.count <= TREE_WIDE * TREE_WIDE;
    uint32_t count = 1;
    while (count < TREE_WIDE) {
        const int i = costliest(pieces, count, small);
        if (i < 0) break;
        const uint32_t first = pieces[i].first, all = pieces[i].all.count;
        const uint32_t below = all <= TREE_WIDE ? all / 2 : part(items + first, all);
        pieces[i] = piece_of(items, first, below);
        pieces[count++] = piece_of(items, first + below, all - below);
    }
    return count;
}

static bool add_node(builder *b, const piece *all, uint32_t parent);

static bool add_child(builder *b, uint32_t at, int k, const piece *p) {
    tree_node *node = &b->nodes.items[at];
    const tree_item *items = b->items + p->first;
    const uint32_t slot = at * TREE_WIDE + (uint32_t)k;
    bound_places(&p->all, b->scale, node, k);
    bound_axes(items, p->all.count, node, k);
    node->power[k] = (float)fmax(p->all.power, 0x1p-100);
    node->child[k] = p->all.count == 1 ? TREE_LEAF + items->light : (uint32_t)b->nodes.count;
    if (p->all.count > 1) return add_node(b, p, slot);
    b->slot_of[items->light] = slot;
    return true;
}

static bool add_node(builder *b, const piece *all, uint32_t parent) {
    const tree_node empty = {.power = {0}};
    const uint32_t at = (uint32_t)b->nodes.count, count = all->all.count;
    piece pieces[TREE_WIDE] = {*all};
    if (!array_push(&b->nodes, empty) || !array_push(&b->parent, parent)) return false;
    uint32_t parts = count;
    if (count > TREE_WIDE) {
        parts = cut_up(b->items, pieces);
    } else {
        for (uint32_t k = 0; k < count; ++k) pieces[k] = piece_of(b->items, all->first + k, 1);
    }
    for (uint32_t k = 0; k < parts; ++k) {
        if (!add_child(b, at, (int)k, &pieces[k])) return false;
    }
    return true;
}

/* Scales the largest distance between lights to about 1. */
static float scale_for(const sums *all) {
    double x = (double)all->upper[0] - (double)all->lower[0],
           y = (double)all->upper[1] - (double)all->lower[1],
           z = (double)all->upper[2] - (double)all->lower[2];
    double extent = fmax(x, fmax(y, z));
    return extent > 0x1p-100 && extent < 0x1p100 ? (float)exp2(-ilogb(extent)) : 1;
}

/* Divides powers by the largest. Returns their sum before that. */
static double normalize_power(tree_item *items, uint32_t count) {
    float most = 0;
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) most = fmaxf(most, items[i].power), sum += (double)items[i].power;
    for (uint32_t i = 0; i < count; ++i) items[i].power = fmaxf(items[i].power / most, 0x1p-100f);
    return sum;
}

bool tree_build(tree_item *items, uint32_t count, tree *out, uint32_t *slot_of) {
    builder b = {.items = items, .slot_of = slot_of};
    *out = (tree){.nodes = NULL};
    if (!count) return true;
    const double power = normalize_power(items, count);
    const piece all = piece_of(items, 0, count);
    b.scale = scale_for(&all.all);
    const bool built = add_node(&b, &all, 0);
    *out = (tree){.nodes = b.nodes.items,
                  .parent = b.parent.items,
                  .count = (uint32_t)b.nodes.count,
                  .scale = b.scale,
                  .power = power,
                  .kernels = tree_kernels_best()};
    if (!built) {
        tree_destroy(out);
        return false;
    }
    /* Growing arrays have unused capacity. */
    void *fits = realloc(out->nodes, out->count * sizeof *out->nodes);
    if (fits) out->nodes = fits;
    fits = realloc(out->parent, out->count * sizeof *out->parent);
    if (fits) out->parent = fits;
    return true;
}
