/* Albedos of GGX facets with any reflectance: how much of the light that a viewer sees comes from facets at
 * each cosine to the viewer. This does not depend on the reflectance, so films are cheap where their
 * thickness varies. */
#include "material/energy_kernels.h"
#include "material/energy_tables.h"
#include "material/shader.h"
#include "math/turn.h"

/* Tables at alphas (j / STEPS)^4, the larger one first. */
enum { STEPS = 24, ROWS = STEPS + 1, NODES = ENERGY_FACETS_STEPS + 1, AROUND = 24, TURNS = 8 };
typedef struct weights {
    float of[NODES][NODES]; /* by the viewer's cosine, by that of viewer and facet */
} weights;
static weights tables[ROWS * (ROWS + 1) / 2];
static bool made[ROWS * (ROWS + 1) / 2];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* All azimuths have the same value if the alphas are equal. */
static void fill(const int *rows, void *table) {
    const energy_kernels *kernels = energy_kernels_best();
    weights *out = table;
    const int turns = rows[0] == rows[1] ? 1 : TURNS;
    const float ax = energy_fourth(rows[0], STEPS),
                ay = most(energy_fourth(rows[1], STEPS), SHADER_SMOOTH_ALPHA);
    for (int k = 0; k < NODES; ++k) {
        const float x = (float)k / ENERGY_FACETS_STEPS, mu = most(x * x, 1e-6f), sine = energy_sine(mu);
        if (ax < SHADER_SMOOTH_ALPHA) out->of[k][k] = 1;
        for (int j = 0; j < turns && ax >= SHADER_SMOOTH_ALPHA; ++j) {
            float c, s;
            turn_by(turns > 1 ? 0.25f * ((float)j + 0.5f) / TURNS : 0, &c, &s);
            kernels->facets(&(energy_view){ax, ay, {sine * c, sine * s, mu}, AROUND}, 1.0f / (float)turns,
                            out->of[k]);
        }
    }
}

static const weights *table_at(int along, int across) {
    const int place = along * (along + 1) / 2 + across;
    return energy_table_once(&made[place], &lock, fill, (int[]){along, across}, &tables[place]);
}

static void add_table(int a, int b, float weight, const float *curve, float *out) {
    if (!(weight > 0)) return;
    const weights *table = table_at(a > b ? a : b, a > b ? b : a);
    for (int k = 0; k < NODES; ++k) {
        float sums[8] = {0}, sum = 0; /* several sums let the loop vectorise */
        for (int i = 0; i < NODES - 1; i += 8) {
            for (int n = 0; n < 8; ++n) sums[n] += table->of[k][i + n] * curve[i + n];
        }
        for (int n = 0; n < 8; ++n) sum += sums[n];
        out[k] += weight * (sum + table->of[k][NODES - 1] * curve[NODES - 1]);
    }
}

void energy_facets(float along, float across, const float curve[NODES], float out[NODES]) {
    float s, t;
    const int j = energy_alpha_row(along, STEPS, &s), k = energy_alpha_row(across, STEPS, &t);
    if (along == across) {
        add_table(j, j, 1 - s, curve, out), add_table(j + 1, j + 1, s, curve, out);
        return;
    }
    for (int r = 0; r < 4; ++r)
        add_table(j + (r & 1), k + (r >> 1), (r & 1 ? s : 1 - s) * (r >> 1 ? t : 1 - t), curve, out);
}
