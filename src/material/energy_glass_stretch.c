/* Albedos of rough glass whose facets have two alphas; as energy_glass.c, with a viewer at any azimuth. */
#include "material/energy_kernels.h"
#include "material/energy_tables.h"
#include "material/shader.h"

/* Tables by two alphas, the larger one along, and index. */
enum { STEPS = 24, ROWS = STEPS + 1, PAIRS = ROWS * (ROWS + 1) / 2, INDEX_STEPS = 20, AROUND = 32 };
static energy_glass_table tables[PAIRS][INDEX_STEPS + 1];
static bool made[PAIRS][INDEX_STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void fill_node(float ax, float ay, float eta, int node, bool even,
                      int16_t out[ENERGY_TURNS + 1][ENERGY_GLASS_STEPS + 1][3]) {
    const energy_kernels *kernels = energy_kernels_best();
    const float mu = energy_cosine(node, ENERGY_GLASS_STEPS), flat = energy_sine(mu);
    for (int j = 0; j <= ENERGY_TURNS; ++j) {
        const float y = (float)j / ENERGY_TURNS, x = 1 - y, unit = flat / sqrtf(x * x + y * y);
        float parts[3];
        if (j == 0 || !even)
            kernels->glass(&(energy_view){ax, ay, {x * unit, y * unit, mu}, AROUND}, eta, parts);
        for (int c = 0; c < 3; ++c) out[j][node][c] = (int16_t)lrintf(most(least(parts[c], 1), -1) * 32767);
    }
}

static void fill(const int *rows, void *table) {
    const float ax = most(energy_fourth(rows[0], STEPS), SHADER_SMOOTH_ALPHA),
                ay = most(energy_fourth(rows[1], STEPS), SHADER_SMOOTH_ALPHA),
                eta = energy_index(rows[2], INDEX_STEPS);
    const bool even = rows[0] == rows[1];
    energy_glass_table *out = table;
    for (int k = 0; k <= ENERGY_GLASS_STEPS; ++k) {
        fill_node(ax, ay, eta, k, even, out->part[0]);
        fill_node(ax, ay, 1 / eta, k, even, out->part[1]);
    }
}

static const energy_glass_table *table_at(int along, int across, int index) {
    const int pair = along * (along + 1) / 2 + across;
    return energy_table_once(&made[pair][index], &lock, fill, (int[]){along, across, index},
                             &tables[pair][index]);
}

void energy_glass_stretched(float along, float across, float eta, float f0, float f90,
                            energy_glass_stretch *out) {
    float s, t, u;
    const int a = energy_alpha_row(along, STEPS, &s), b = energy_alpha_row(across, STEPS, &t),
              k = energy_index_row(eta, INDEX_STEPS, &u);
    out->f0 = f0, out->f90 = f90, out->swapped = eta < 1;
    for (int r = 0; r < 8; ++r) {
        const int x = a + (r & 1), y = b + (r >> 1 & 1);
        const float weight = (r & 1 ? s : 1 - s) * (r & 2 ? t : 1 - t) * (r & 4 ? u : 1 - u);
        out->table[r] = table_at(x > y ? x : y, x > y ? y : x, k + (r >> 2));
        out->weight[r] = weight * (1 / 32767.0f);
        out->turned[r] = y > x;
    }
}

void energy_glass_stretched_curves(const energy_glass_stretch *g, float missing[2][ENERGY_NODES]) {
    float part[ENERGY_TURNS + 1];
    energy_turn_parts(part);
    for (int side = 0; side < 2; ++side) {
        for (int k = 0; k <= ENERGY_STEPS; ++k) missing[side][k] = 0;
        for (int k = 0; k <= ENERGY_GLASS_STEPS; ++k) {
            for (int j = 0; j <= ENERGY_TURNS; ++j)
                missing[side][2 * k] += part[j] * energy_glass_node(g, side, j, k);
        }
        for (int k = 1; k < ENERGY_STEPS; k += 2)
            missing[side][k] = 0.5f * (missing[side][k - 1] + missing[side][k + 1]);
    }
}
