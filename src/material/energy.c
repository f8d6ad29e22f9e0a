#include "material/energy.h"

#include "base/kernel.h"
#include "material/energy_kernels.h"
#include "material/energy_tables.h"
#include "material/shader.h"
#include "math/power.h"

KERNEL_BEST(energy_kernels)

/* Curves at roughnesses (j / ROUGH_STEPS)^2; the first is that of a mirror. */
enum { ROUGH_STEPS = 72, AROUND = 12 };
static energy_node nodes[ROUGH_STEPS][ENERGY_NODES];
static float means[ROUGH_STEPS + 1][2];
static double parts[ENERGY_STEPS], slopes[ENERGY_STEPS]; /* weights of the mean */

/* With mu = x^4: 8 ∫ f x^7 dx, exact for curves that are linear in x. */
static void fill_parts(void) {
    for (int k = 0; k < ENERGY_STEPS; ++k) {
        const double a = (double)k / ENERGY_STEPS, b = (k + 1.0) / ENERGY_STEPS;
        parts[k] = (pow(b, 8) - pow(a, 8)) / 8;
        slopes[k] = (pow(b, 9) - pow(a, 9)) / 9 - a * parts[k];
    }
}

/* The integral from node k to the next. */
static double step_of(const float curve[ENERGY_NODES], int k) {
    const double slope = ((double)curve[k + 1] - (double)curve[k]) * ENERGY_STEPS;
    return 8 * ((double)curve[k] * parts[k] + slope * slopes[k]);
}

static float mean_of(const float curve[ENERGY_NODES]) {
    double sum = 0;
    for (int k = 0; k < ENERGY_STEPS; ++k) sum += step_of(curve, k);
    return (float)sum;
}

static void fill(void) {
    const energy_kernels *kernels = energy_kernels_best();
    float tables[2][2][ENERGY_NODES];
    fill_parts();
    for (int j = 0; j <= ROUGH_STEPS; ++j) {
        float(*const now)[ENERGY_NODES] = tables[j % 2], (*const before)[ENERGY_NODES] = tables[(j + 1) % 2];
        const float alpha = energy_fourth(j, ROUGH_STEPS);
        for (int k = 0; k < ENERGY_NODES; ++k) {
            const float mu = energy_cosine(k, ENERGY_STEPS);
            float both[2] = {1, power5(1 - mu)};
            if (alpha > 0.5f * SHADER_SMOOTH_ALPHA)
                kernels->mirror(&(energy_view){alpha, alpha, {energy_sine(mu), 0, mu}, AROUND}, both);
            now[0][k] = both[0], now[1][k] = both[1];
            if (j > 0)
                nodes[j - 1][k] = (energy_node){before[0][k], before[1][k], now[0][k] - before[0][k],
                                                now[1][k] - before[1][k]};
        }
        for (int c = 0; c < 2; ++c) means[j][c] = mean_of(now[c]);
    }
}

static pthread_once_t once = PTHREAD_ONCE_INIT;

static const energy_node zeros[ENERGY_NODES];
const energy_curve energy_none = {zeros, 0};

energy_curve energy_curve_of(float alpha) {
    pthread_once(&once, fill);
    float part;
    const int j = energy_alpha_row(alpha < SHADER_SMOOTH_ALPHA ? 0 : alpha, ROUGH_STEPS, &part);
    return (energy_curve){nodes[j], part};
}

void energy_means(const energy_curve *c, float *all, float *edge) {
    const ptrdiff_t j = (c->nodes - nodes[0]) / ENERGY_NODES;
    const float t = c->part;
    *all = means[j][0] + t * (means[j + 1][0] - means[j][0]);
    *edge = means[j][1] + t * (means[j + 1][1] - means[j][1]);
}

float energy_mean(const float curve[ENERGY_NODES]) {
    pthread_once(&once, fill);
    return mean_of(curve);
}

void energy_sums(const float curve[ENERGY_NODES], float sums[ENERGY_NODES]) {
    pthread_once(&once, fill);
    double sum = 0;
    for (int k = 0; k < ENERGY_STEPS; ++k) {
        sums[k] = (float)sum;
        sum += step_of(curve, k);
    }
    for (int k = 0; k < ENERGY_STEPS; ++k) sums[k] = sum > 0 ? (float)((double)sums[k] / sum) : 0;
    sums[ENERGY_STEPS] = 1;
}
