/* Albedos of GGX lobes with two alphas; as energy.c, with a viewer at any azimuth. */
#include "material/energy_kernels.h"
#include "material/energy_tables.h"
#include "material/shader.h"

/* Tables at alphas (j / STEPS)^4. */
enum { STEPS = 36, AROUND = 32 };
static energy_table tables[STEPS + 1][STEPS + 1]; /* along, across */
static bool made[STEPS + 1][STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static float alpha_at(int j) { return most(energy_fourth(j, STEPS), SHADER_SMOOTH_ALPHA); }

/* The fraction of a quarter turn that a node represents: the integral of its hat function, by the midpoint
 * rule. */
static float part_of(int node) {
    enum { FINE = 64 };
    double sum = 0;
    for (int k = 0; k < FINE * ENERGY_TURNS; ++k) {
        const double t = (k + 0.5) / FINE, hat = 1 - fabs(t - node);
        const double a = t / ENERGY_TURNS, b = 1 - a; /* the angle is atan(a / b) */
        sum += fmax(hat, 0) / (a * a + b * b);
    }
    return (float)(sum / (FINE * ENERGY_TURNS) * (2 / 3.14159265358979));
}

void energy_turn_parts(float parts[ENERGY_TURNS + 1]) {
    for (int j = 0; j <= ENERGY_TURNS; ++j) parts[j] = part_of(j);
}

static void fill(const int *rows, void *table) {
    const float ax = alpha_at(rows[0]), ay = alpha_at(rows[1]);
    const energy_kernels *kernels = energy_kernels_best();
    energy_table *out = table;
    float part[ENERGY_TURNS + 1];
    energy_turn_parts(part);
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float mu = energy_cosine(k, ENERGY_STEPS), flat = energy_sine(mu);
        for (int j = 0; j <= ENERGY_TURNS; ++j) {
            const float y = (float)j / ENERGY_TURNS, x = 1 - y, unit = flat / sqrtf(x * x + y * y);
            float both[2];
            kernels->mirror(&(energy_view){ax, ay, {x * unit, y * unit, mu}, AROUND}, both);
            for (int c = 0; c < 2; ++c) {
                out->albedo[c][j][k] = both[c];
                out->around[c][k] += part[j] * both[c];
            }
        }
    }
}

static const energy_table *table_at(int along, int across) {
    return energy_table_once(&made[along][across], &lock, fill, (int[]){along, across},
                             &tables[along][across]);
}

void energy_stretched(float along, float across, energy_stretch *out) {
    float s, t;
    const int j = energy_alpha_row(along, STEPS, &s), k = energy_alpha_row(across, STEPS, &t);
    for (int r = 0; r < 4; ++r) {
        out->table[r] = table_at(j + (r & 1), k + (r >> 1));
        out->weight[r] = (r & 1 ? s : 1 - s) * (r >> 1 ? t : 1 - t);
    }
}

void energy_stretched_curves(const energy_stretch *s, float all[ENERGY_NODES], float edge[ENERGY_NODES]) {
    for (int k = 0; k < ENERGY_NODES; ++k) {
        all[k] = edge[k] = 0;
        for (int r = 0; r < 4; ++r) {
            all[k] += s->weight[r] * s->table[r]->around[0][k];
            edge[k] += s->weight[r] * s->table[r]->around[1][k];
        }
    }
}
