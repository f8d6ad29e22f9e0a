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

/* The child at u times the sum of weights, of those with a weight; *u becomes its place within the child. */
static int pick(const float weight[TREE_WIDE], double sum, double *u) {
    double left = *u * sum;
    int last = 0;
    for (int i = 0; i < TREE_WIDE; ++i) {
        double w = (double)weight[i];
        if (!(w > 0)) continue;
        last = i;
        if (left < w) break;
        left -= w;
    }
    double at = left / (double)weight[last];
    *u = at < 0x1.fffffffffffffp-1 ? at : 0x1.fffffffffffffp-1;
    return last;
}

uint32_t tree_choose(const tree *t, vec3_f32 p, vec3_f32 n, double u, double *chance) {
    const tree_kernels *kernels = tree_kernels_best();
    const vec3_f32 at = scaled(t, p);
    uint32_t child = 0;
    *chance = 1;
    while (!(child & TREE_LEAF)) {
        float weight[TREE_WIDE];
        kernels->weigh(&t->nodes[child], at, n, weight);
        const double sum = sum_of(weight);
        if (!(sum > 0)) {
            *chance = 0;
            return 0;
        }
        const int i = pick(weight, sum, &u);
        *chance *= (double)weight[i] / sum;
        child = t->nodes[child].child[i];
    }
    return child & ~TREE_LEAF;
}

double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, uint32_t slot) {
    const tree_kernels *kernels = tree_kernels_best();
    const vec3_f32 at = scaled(t, p);
    double chance = 1;
    for (;;) {
        const uint32_t node = slot / TREE_WIDE;
        float weight[TREE_WIDE];
        kernels->weigh(&t->nodes[node], at, n, weight);
        const double sum = sum_of(weight);
        chance *= sum > 0 ? (double)weight[slot % TREE_WIDE] / sum : 0;
        if (!node || !(chance > 0)) return chance;
        slot = t->parent[node];
    }
}
