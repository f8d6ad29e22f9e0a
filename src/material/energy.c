#include "material/energy.h"

#include "material/energy_tables.h"
#include "material/shader.h"
#include "math/power.h"
#include "math/turn.h"

/* Curves at roughnesses (j / ROUGH_STEPS)^2; the first is that of a mirror. */
enum { ROUGH_STEPS = 72, AROUND = 12, ALONG = 32 };
static energy_node nodes[ROUGH_STEPS][ENERGY_NODES];
static float means[ROUGH_STEPS + 1][2];
static double parts[ENERGY_STEPS], slopes[ENERGY_STEPS]; /* weights of the mean */

/* A viewer in the plane y = 0, and the same direction in the space where the facets are a hemisphere, of unit
 * length. */
typedef struct viewer {
    float x, z, stretched_x, stretched_z, alpha;
    float smith; /* sqrt(cos^2 + alpha^2 sin^2) */
} viewer;

/* Adds G2/G1 of the directions that visible facets mirror, around the azimuth u, and the same times Schlick's
 * factor. Facets are parametrised as by Dupuy & Benyoub (2023), but uniformly in q = sqrt(1 - u'), because
 * G2/G1 changes fast if q is small. The formulas are those of kernels/shader.c. */
static void add_facets(const viewer *v, float u, float all[ALONG], float edge[ALONG]) {
    float cosine, sine;
    turn_by(u, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        float q = ((float)k + 0.5f) / ALONG, up = q * q * (1 + v->stretched_z);
        float below = v->stretched_x * v->stretched_x / (1 + v->stretched_z);
        float square = (1 - q * q) * (1 + v->stretched_z) * (below + up);
        float r = sqrtf(square > 0 ? square : 0);
        float hx = v->alpha * (v->stretched_x + r * cosine), hy = v->alpha * r * sine;
        float unit = 1 / sqrtf(hx * hx + hy * hy + up * up);
        float along = (v->x * hx + v->z * up) * unit, z = 2 * along * up * unit - v->z;
        float above = z > 0 ? z : 0, sine2 = 1 - above * above;
        float s = sqrtf(above * above + v->alpha * v->alpha * (sine2 > 0 ? sine2 : 0));
        float part = 2 * q * above * (v->z + v->smith) / (v->z * s + above * v->smith);
        all[k] += part, edge[k] += part * power5(along < 1 ? 1 - along : 0);
    }
}

/* Midpoint rule: the integrand goes to 0 at the horizon, so it has no steps. Both halves of the azimuth are
 * equal. */
static void albedo(float alpha, float mu, float *out_all, float *out_edge) {
    viewer v = {.x = sqrtf((1 - mu) * (1 + mu)), .z = mu, .alpha = alpha};
    v.smith = sqrtf(alpha * alpha * v.x * v.x + mu * mu);
    v.stretched_x = alpha * v.x / v.smith, v.stretched_z = mu / v.smith;
    float all[ALONG] = {0}, edge[ALONG] = {0}, sum = 0, rise = 0;
    for (int j = 0; j < AROUND; ++j) add_facets(&v, 0.5f * ((float)j + 0.5f) / AROUND, all, edge);
    for (int k = 0; k < ALONG; ++k) sum += all[k], rise += edge[k];
    *out_all = sum / (AROUND * ALONG), *out_edge = rise / (AROUND * ALONG);
}

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
    float tables[2][2][ENERGY_NODES];
    fill_parts();
    for (int j = 0; j <= ROUGH_STEPS; ++j) {
        float(*const now)[ENERGY_NODES] = tables[j % 2], (*const before)[ENERGY_NODES] = tables[(j + 1) % 2];
        const float alpha = energy_fourth(j, ROUGH_STEPS);
        for (int k = 0; k < ENERGY_NODES; ++k) {
            const float mu = energy_cosine(k, ENERGY_STEPS);
            now[0][k] = 1, now[1][k] = power5(1 - mu);
            if (alpha > 0.5f * SHADER_SMOOTH_ALPHA) albedo(alpha, mu, &now[0][k], &now[1][k]);
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
