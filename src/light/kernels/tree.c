/* How much the lights below a node's children may send to a point, and which of them it asks. */
#include "light/tree.h"
#include "base/kernel.h"

static inline float positive(float x) { return x > 0 ? x : 0; }

/* cos(a - b), and 1 where a <= b, of angles in [0, pi] by their cosines and the sine of b. */
static inline float cos_less(float cos_a, float cos_b, float sin_b) {
    float less = cos_a * cos_b + sqrtf(positive(1 - cos_a * cos_a)) * sin_b;
    return cos_a >= cos_b ? 1 : less;
}

/* Power times the least cosines over the squared distance. Distances less than half the radius tell nothing
 * about where the lights are; so they count as that. */
static void weigh(const tree_node *node, vec3_f32 p, vec3_f32 n, float weight[TREE_WIDE]) {
    const float one_sided = n.x != 0 || n.y != 0 || n.z != 0 ? 1 : 0;
    for (int i = 0; i < TREE_WIDE; ++i) {
        float x = node->x[i] - p.x, y = node->y[i] - p.y, z = node->z[i] - p.z, r = node->radius[i];
        float square = x * x + y * y + z * z, inverse = 1 / sqrtf(square + 0x1p-120f);
        float seen = r * inverse, sin_u = seen < 1 ? seen : 1, cos_u = sqrtf(1 - sin_u * sin_u);
        float spread = node->spread[i], sin_o = sqrtf(positive(1 - spread * spread));
        float cos_ou = spread * cos_u - sin_o * sin_u, sin_ou = sin_o * cos_u + spread * sin_u;
        float leaving = fabsf(x * node->axis_x[i] + y * node->axis_y[i] + z * node->axis_z[i]) * inverse;
        float arriving = (x * n.x + y * n.y + z * n.z) * inverse;
        float sent = cos_less(leaving, cos_ou, sin_ou), met = positive(cos_less(arriving, cos_u, sin_u));
        float within = 0.25f * r * r, far = square > within ? square : within;
        met = one_sided > 0 ? met : 1;
        met = seen < 1 ? met : 1;
        weight[i] = node->power[i] * sent * met / (far + 0x1p-120f);
    }
}

/* The child at u times the sum of weights: the first up to which more than that has been summed up, so one
 * with a weight. *u becomes its place within the child. */
static int pick(const float weight[TREE_WIDE], double *u, double *chance) {
    double below[TREE_WIDE + 1] = {0};
    for (int i = 0; i < TREE_WIDE; ++i) below[i + 1] = below[i] + (double)weight[i];
    const double sum = below[TREE_WIDE], at = *u * sum, most = sum * (1 - 0x1p-53);
    const double left = at < most ? at : most;
    if (!(sum > 0)) return -1;
    int found = 0;
    for (int i = 1; i < TREE_WIDE; ++i) found += left >= below[i];
    const double part = (left - below[found]) / (double)weight[found];
    *u = part < 1 - 0x1p-53 ? part : 1 - 0x1p-53;
    *chance *= (double)weight[found] / sum;
    return found;
}

/* Level by level: the processor works on several lanes' nodes at once while they come from memory. */
static void choose(const tree *t, const lanes3 p, const lanes3 n, unsigned lanes, double u[LANES],
                   uint32_t light[LANES], double chance[LANES]) {
    for (int i = 0; i < LANES; ++i) light[i] = 0, chance[i] = 1;
    while (lanes) {
        for (unsigned left = lanes; left; left &= left - 1) {
            const int i = __builtin_ctz(left);
            const vec3_f32 at = {t->scale * p[0][i], t->scale * p[1][i], t->scale * p[2][i]};
            const tree_node *node = &t->nodes[light[i]];
            float weight[TREE_WIDE];
            weigh(node, at, (vec3_f32){n[0][i], n[1][i], n[2][i]}, weight);
            const int child = pick(weight, &u[i], &chance[i]);
            if (child >= 0) light[i] = node->child[child];
            if (child < 0) chance[i] = 0;
            if (child < 0 || light[i] & TREE_LEAF)
                lanes &= ~(1u << i);
            else
                for (int k = 0; k < 5; ++k) __builtin_prefetch((const char *)&t->nodes[light[i]] + 64 * k);
        }
    }
    for (int i = 0; i < LANES; ++i) light[i] &= ~TREE_LEAF;
}

const tree_kernels KERNEL(tree_kernels) = {.weigh = weigh, .choose = choose};
