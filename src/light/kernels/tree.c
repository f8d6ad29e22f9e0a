/* How much the lights below a node's children may send to a point. */
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

const tree_kernels KERNEL(tree_kernels) = {.weigh = weigh};
