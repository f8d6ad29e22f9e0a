#include "light/tree.h"

#include "base/kernel.h"

#include <stdlib.h>

KERNEL_BEST(tree_kernels)

void tree_destroy(tree *t) {
    free(t->nodes);
    free(t->parent);
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

double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, uint32_t slot) {
    const vec3_f32 at = scaled(t, p);
    double chance = 1;
    tree_cut cut;
    t->kernels->cut(t, at, n, &cut);
    for (;;) {
        const uint32_t node = slot / TREE_WIDE, k = find_node(&cut, node);
        float weight[TREE_WIDE], unsure[TREE_WIDE];
        if (k == cut.count) t->kernels->weigh(&t->nodes[node], at, n, weight, unsure);
        const float own = k < cut.count ? cut.weight[k][slot % TREE_WIDE] : weight[slot % TREE_WIDE];
        const double sum = k < cut.count ? cut_sum(&cut) : sum_of(weight);
        chance *= sum > 0 ? (double)own / sum : 0;
        if (k < cut.count || !(chance > 0)) return chance;
        slot = t->parent[node];
    }
}
