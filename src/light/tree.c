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

double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, uint32_t slot) {
    const vec3_f32 at = scaled(t, p);
    double chance = 1;
    for (;;) {
        const uint32_t node = slot / TREE_WIDE;
        float weight[TREE_WIDE];
        t->kernels->weigh(&t->nodes[node], at, n, weight);
        const double sum = sum_of(weight);
        chance *= sum > 0 ? (double)weight[slot % TREE_WIDE] / sum : 0;
        if (!node || !(chance > 0)) return chance;
        slot = t->parent[node];
    }
}
