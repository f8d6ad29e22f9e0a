/* Albedos of rough glass: GGX facets that reflect and refract (Walter et al. 2007). */
#include "material/energy.h"
#include "material/energy_tables.h"
#include "material/shader.h"
#include "math/power.h"
#include "math/turn.h"

/* Tables by alpha and index. */
enum { ROUGH_STEPS = 36, INDEX_STEPS = 32, AROUND = 24, ALONG = 96 };

/* An albedo f0 low + f90 high + open, for Schlick's reflectance. */
typedef struct albedo_parts {
    float low, high, open;
} albedo_parts;

/* For a viewer in the thinner medium, and for one in the denser medium. */
typedef struct glass_table {
    albedo_parts node[2][ENERGY_NODES];
} glass_table;

static glass_table tables[ROUGH_STEPS + 1][INDEX_STEPS + 1];
static bool made[ROUGH_STEPS + 1][INDEX_STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* ---- integrals ---- */

/* As in energy.c; eta: index of the far side divided by that of the viewer's side. */
typedef struct viewer {
    float x, z, stretched_x, stretched_z, alpha, smith, eta;
} viewer;

/* G2/G1 of a direction at this cosine; 0 on the wrong side. */
static float seen_at(const viewer *v, float cosine) {
    const float z = cosine > 0 ? cosine : 0, sine2 = 1 - z * z;
    const float smith = sqrtf(z * z + v->alpha * v->alpha * (sine2 > 0 ? sine2 : 0));
    return z * (v->z + v->smith) / (v->z * smith + z * v->smith);
}

/* Sums over facets, by their place in the ring: separate sums let the loop vectorise. */
typedef struct ring_sums {
    float low[ALONG], high[ALONG], open[ALONG];
} ring_sums;

/* Adds the light that visible facets around the azimuth u reflect and transmit. The parametrisation is
 * that of energy.c. `along` is the cosine between viewer and facet. Total reflection has Schlick's factor
 * 1. */
static void add_ring(const viewer *v, float u, ring_sums *sums) {
    const float inverse = 1 / v->eta, below = v->stretched_x * v->stretched_x / (1 + v->stretched_z);
    float cosine, sine;
    turn_by(u, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        const float q = ((float)k + 0.5f) / ALONG, up = q * q * (1 + v->stretched_z);
        const float square = (1 - q * q) * (1 + v->stretched_z) * (below + up);
        const float r = sqrtf(square > 0 ? square : 0);
        const float hx = v->alpha * (v->stretched_x + r * cosine), hy = v->alpha * r * sine;
        const float unit = 1 / sqrtf(hx * hx + hy * hy + up * up), all = (v->x * hx + v->z * up) * unit;
        const float along = all < 1 ? all : 1, far2 = 1 - (1 - along) * (1 + along) * (inverse * inverse);
        const float far = sqrtf(far2 > 0 ? far2 : 0);
        const float mirrored = seen_at(v, 2 * along * up * unit - v->z);
        const float through = seen_at(v, v->z * inverse - (along * inverse - far) * up * unit);
        const float refracted = far2 > 0 ? through : 0, near = v->eta < 1 ? far : along;
        const float rise = far2 > 0 ? power5(1 - near) : 1;
        sums->low[k] += 2 * q * (mirrored - refracted) * (1 - rise);
        sums->high[k] += 2 * q * (mirrored - refracted) * rise;
        sums->open[k] += 2 * q * refracted;
    }
}

static albedo_parts albedo(float alpha, float eta, float mu) {
    viewer v = {.x = sqrtf((1 - mu) * (1 + mu)), .z = mu, .alpha = alpha, .eta = eta};
    v.smith = sqrtf(alpha * alpha * v.x * v.x + mu * mu);
    v.stretched_x = alpha * v.x / v.smith, v.stretched_z = mu / v.smith;
    ring_sums sums = {{0}, {0}, {0}};
    albedo_parts all = {0, 0, 0};
    for (int j = 0; j < AROUND; ++j) add_ring(&v, 0.5f * ((float)j + 0.5f) / AROUND, &sums);
    for (int k = 0; k < ALONG; ++k)
        all.low += sums.low[k], all.high += sums.high[k], all.open += sums.open[k];
    const float part = 1.0f / (AROUND * ALONG);
    return (albedo_parts){all.low * part, all.high * part, all.open * part};
}

/* ---- tables ---- */

static void fill(const int *rows, void *table) {
    const float alpha = most(energy_fourth(rows[0], ROUGH_STEPS), SHADER_SMOOTH_ALPHA);
    const float eta = energy_index(rows[1], INDEX_STEPS);
    glass_table *out = table;
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float mu = energy_cosine(k, ENERGY_STEPS);
        out->node[0][k] = albedo(alpha, eta, mu);
        out->node[1][k] = albedo(alpha, 1 / eta, mu);
    }
}

static const glass_table *table_at(int rough, int index) {
    return energy_table_once(&made[rough][index], &lock, fill, (int[]){rough, index}, &tables[rough][index]);
}

void energy_glass(float alpha, float eta, float f0, float f90, float missing[2][ENERGY_NODES]) {
    float s, t;
    const int j = energy_alpha_row(alpha, ROUGH_STEPS, &s), k = energy_index_row(eta, INDEX_STEPS, &t);
    for (int side = 0; side < 2; ++side) {
        for (int n = 0; n < ENERGY_NODES; ++n) missing[side][n] = 1;
    }
    for (int r = 0; r < 4; ++r) {
        const glass_table *table = table_at(j + (r & 1), k + (r >> 1));
        const float weight = (r & 1 ? s : 1 - s) * (r >> 1 ? t : 1 - t);
        for (int side = 0; side < 2; ++side) {
            const albedo_parts *from = table->node[side ^ (eta < 1)];
            for (int n = 0; n < ENERGY_NODES; ++n)
                missing[side][n] -= weight * (f0 * from[n].low + f90 * from[n].high + from[n].open);
        }
    }
    for (int side = 0; side < 2; ++side) {
        for (int n = 0; n < ENERGY_NODES; ++n) missing[side][n] = most(missing[side][n], 0);
    }
}
