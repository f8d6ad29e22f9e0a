#include "light/tree_view.h"

#include "base/kernel.h"

#include <stdlib.h>

KERNEL_BEST(tree_kernels)

void tree_destroy(tree *t) {
    free(t->nodes);
    free(t->parent);
    free(t->row_of);
    free(t->row_node);
    *t = (tree){.nodes = NULL};
}

static vec3_f32 scaled(const tree *t, vec3_f32 p) { return scale_f32(t->scale, p); }

static double sum_of(const float weight[TREE_WIDE]) {
    double sum = 0;
    for (int i = 0; i < TREE_WIDE; ++i) sum += (double)weight[i];
    return sum;
}

/* The index of the node in the cut, or the count if it is not in it. */
static uint32_t find_node(const tree_cut *cut, uint32_t node) {
    uint32_t k = 0;
    while (k < cut->count && cut->node[k] != node) ++k;
    return k;
}

static double cut_sum(const tree_cut *cut) {
    double sum = 0;
    for (uint32_t k = 0; k < cut->count; ++k) sum += sum_of(cut->weight[k]);
    return sum;
}

/* The weights of a node's children, outside of cuts. */
static void weigh(const tree *t, uint32_t node, vec3_f32 at, vec3_f32 n, tree_factors factors,
                  float weight[TREE_WIDE]) {
    float unsure[TREE_WIDE];
    t->kernels->weigh(&t->nodes[node], at, n, weight, unsure);
    const uint32_t row = factors ? t->row_of[node] : FATHOM_NONE;
    for (uint32_t i = 0; row != FATHOM_NONE && i < TREE_WIDE; ++i) weight[i] *= factors[row * TREE_WIDE + i];
}

/* ---- probabilities ---- */

/* The first step of a traversal from the list: the probability of the slot, or -1 if it is not in the list.
 */
static double listed_chance(const tree *t, const tree_view *v, vec3_f32 at, vec3_f32 n, uint32_t slot) {
    const uint32_t near = v->near_count * TREE_WIDE, all = near + v->far_count;
    uint32_t found = 0;
    while (found < all && v->slot[found] != slot) ++found;
    if (found == all) return -1;
    double sum = tree_view_far(v), own = 0;
    for (uint32_t k = 0; k < v->near_count; ++k) {
        float weight[TREE_WIDE], unsure[TREE_WIDE];
        t->kernels->weigh(&v->near[k], at, n, weight, unsure);
        if (found / TREE_WIDE == k) own = (double)weight[found % TREE_WIDE];
        sum += sum_of(weight);
    }
    if (found >= near) own = v->far[found - near] - (found > near ? v->far[found - near - 1] : 0);
    return sum > 0 ? own / sum : 0;
}

/* The same from a cut. */
static double cut_chance(const tree_cut *cut, uint32_t slot) {
    const uint32_t k = find_node(cut, slot / TREE_WIDE);
    if (k == cut->count) return -1;
    const double sum = cut_sum(cut);
    return sum > 0 ? (double)cut->weight[k][slot % TREE_WIDE] / sum : 0;
}

double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, const tree_view *view, uint32_t slot) {
    const vec3_f32 at = scaled(t, p);
    const tree_factors factors = view ? view->factors : NULL;
    const bool listed = view && tree_view_holds(view, p);
    double chance = 1;
    tree_cut cut;
    if (!listed) t->kernels->cut(t, at, n, factors, &cut);
    for (;;) {
        const double first = listed ? listed_chance(t, view, at, n, slot) : cut_chance(&cut, slot);
        if (first >= 0) return chance * first;
        float weight[TREE_WIDE];
        weigh(t, slot / TREE_WIDE, at, n, factors, weight);
        const double sum = sum_of(weight);
        chance *= sum > 0 ? (double)weight[slot % TREE_WIDE] / sum : 0;
        if (!(chance > 0)) return 0;
        slot = t->parent[slot / TREE_WIDE];
    }
}

/* ---- rows ---- */

static bool has_row(const tree *t, uint32_t child) {
    return !(child & TREE_LEAF) && t->row_of[child] != FATHOM_NONE;
}

/* The slot, among the children of nodes with rows, whose node gets the next row; FATHOM_NONE: none. */
static uint32_t next_slot(const tree *t, const uint32_t *asked, uint32_t least) {
    uint32_t found = FATHOM_NONE, most = least;
    for (uint32_t k = 0; k < t->rows * TREE_WIDE; ++k) {
        const uint32_t slot = t->row_node[k / TREE_WIDE] * TREE_WIDE + k % TREE_WIDE;
        const tree_node *node = &t->nodes[slot / TREE_WIDE];
        const uint32_t child = node->child[k % TREE_WIDE];
        if (!(node->power[k % TREE_WIDE] > 0) || child & TREE_LEAF || has_row(t, child)) continue;
        if (asked[slot] >= most) found = slot, most = asked[slot] + 1;
    }
    return found;
}

bool tree_set_rows(tree *t, const uint32_t *asked, uint32_t least, uint32_t most) {
    uint32_t node = 0;
    t->row_node = malloc(most * sizeof *t->row_node), t->row_of = malloc(t->count * sizeof *t->row_of);
    if (!t->row_node || !t->row_of) return false;
    for (uint32_t k = 0; k < t->count; ++k) t->row_of[k] = FATHOM_NONE;
    for (;;) {
        t->row_of[node] = t->rows, t->row_node[t->rows++] = node;
        const uint32_t slot = t->rows < most ? next_slot(t, asked, least) : FATHOM_NONE;
        if (slot == FATHOM_NONE) return true;
        node = t->nodes[slot / TREE_WIDE].child[slot % TREE_WIDE];
    }
}

/* A node's row comes after that of its parent. */
void tree_average(const tree *t, float *factors) {
    for (uint32_t row = t->rows; row-- > 1;) {
        const tree_node *node = &t->nodes[t->row_node[row]];
        double sum = 0, power = 0;
        for (uint32_t i = 0; i < TREE_WIDE; ++i) {
            sum += (double)node->power[i] * (double)factors[row * TREE_WIDE + i];
            power += (double)node->power[i];
        }
        factors[tree_factor_at(t, t->parent[t->row_node[row]])] = (float)(sum / power);
    }
}

uint32_t tree_block(const tree *t, uint32_t slot) {
    while (t->row_of[slot / TREE_WIDE] == FATHOM_NONE) slot = t->parent[slot / TREE_WIDE];
    return tree_factor_at(t, slot);
}
