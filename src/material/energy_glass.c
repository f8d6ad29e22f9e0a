/* Albedos of rough glass: GGX facets that reflect and refract (Walter et al. 2007). */
#include "material/energy_kernels.h"
#include "material/energy_tables.h"
#include "material/shader.h"

/* Tables by alpha and index. */
enum { ROUGH_STEPS = 36, INDEX_STEPS = 32, AROUND = 24 };

/* Parts of albedos, as energy_kernels.glass() has them, for a viewer in the thinner medium, and for one in
 * the denser medium. */
typedef struct glass_table {
    float node[2][ENERGY_NODES][3];
} glass_table;

static glass_table tables[ROUGH_STEPS + 1][INDEX_STEPS + 1];
static bool made[ROUGH_STEPS + 1][INDEX_STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void fill(const int *rows, void *table) {
    const float alpha = most(energy_fourth(rows[0], ROUGH_STEPS), SHADER_SMOOTH_ALPHA);
    const float eta = energy_index(rows[1], INDEX_STEPS);
    const energy_kernels *kernels = energy_kernels_best();
    glass_table *out = table;
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float mu = energy_cosine(k, ENERGY_STEPS);
        const energy_view view = {alpha, alpha, {energy_sine(mu), 0, mu}, AROUND};
        kernels->glass(&view, eta, out->node[0][k]);
        kernels->glass(&view, 1 / eta, out->node[1][k]);
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
            const float(*from)[3] = table->node[side ^ (eta < 1)];
            for (int n = 0; n < ENERGY_NODES; ++n)
                missing[side][n] -= weight * (f0 * from[n][0] + f90 * from[n][1] + from[n][2]);
        }
    }
    for (int side = 0; side < 2; ++side) {
        for (int n = 0; n < ENERGY_NODES; ++n) missing[side][n] = most(missing[side][n], 0);
    }
}
