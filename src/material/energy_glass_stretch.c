/* Albedos of rough glass whose facets have two alphas; as energy_glass.c, with a viewer at any azimuth. */
#include "material/energy.h"
#include "material/energy_ring.h"
#include "material/energy_tables.h"
#include "material/shader.h"
#include "math/power.h"
#include "math/turn.h"

/* Tables by two alphas, the larger one along, and index. */
enum {
    STEPS = 24,
    ROWS = STEPS + 1,
    PAIRS = ROWS * (ROWS + 1) / 2,
    INDEX_STEPS = 20,
    AROUND = 32,
    ALONG = 64
};
static energy_glass_table tables[PAIRS][INDEX_STEPS + 1];
static bool made[PAIRS][INDEX_STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* ---- integrals ---- */

/* Sums over facets, by their place in the ring: separate sums let the loop vectorise. */
typedef struct ring_sums {
    float low[ALONG], high[ALONG], open[ALONG];
} ring_sums;

/* eta: index of the far side divided by that of the viewer's side. */
static void add_ring(const ring_viewer *m, float eta, float u, ring_sums *sums) {
    const float inverse = 1 / eta;
    float cosine, sine;
    turn_by(u, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        const float q = ((float)k + 0.5f) / ALONG;
        const ring_facet f = ring_facet_at(m, q, cosine, sine);
        const float along = f.along < 1 ? f.along : 1;
        const float far2 = 1 - (1 - along) * (1 + along) * (inverse * inverse);
        const float far = sqrtf(far2 > 0 ? far2 : 0), of_h = along * inverse - far;
        const float mirrored = ring_mirrored(m, &f);
        const float through = ring_seen(m, of_h * f.h[0] - m->v[0] * inverse,
                                        of_h * f.h[1] - m->v[1] * inverse, m->v[2] * inverse - of_h * f.h[2]);
        const float refracted = far2 > 0 ? through : 0, near = eta < 1 ? far : along;
        const float rise = far2 > 0 ? power5(1 - near) : 1;
        sums->low[k] += 2 * q * (mirrored - refracted) * (1 - rise);
        sums->high[k] += 2 * q * (mirrored - refracted) * rise;
        sums->open[k] += 2 * q * refracted;
    }
}

/* The parts of an albedo f0 [0] + f90 [1] + [2]. */
static void albedo(float ax, float ay, float eta, const float v[3], float out[3]) {
    const ring_viewer m = ring_viewer_at(ax, ay, v);
    ring_sums sums = {{0}, {0}, {0}};
    for (int j = 0; j < AROUND; ++j) add_ring(&m, eta, ((float)j + 0.5f) / AROUND, &sums);
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < ALONG; ++k) out[0] += sums.low[k], out[1] += sums.high[k], out[2] += sums.open[k];
    for (int c = 0; c < 3; ++c) out[c] /= AROUND * ALONG;
}

/* ---- tables ---- */

static void fill_node(float ax, float ay, float eta, int node, bool even,
                      int16_t out[ENERGY_TURNS + 1][ENERGY_GLASS_STEPS + 1][3]) {
    const float mu = energy_cosine(node, ENERGY_GLASS_STEPS), flat = sqrtf((1 - mu) * (1 + mu));
    for (int j = 0; j <= ENERGY_TURNS; ++j) {
        const float y = (float)j / ENERGY_TURNS, x = 1 - y, unit = flat / sqrtf(x * x + y * y);
        float parts[3];
        if (j == 0 || !even) albedo(ax, ay, eta, (const float[3]){x * unit, y * unit, mu}, parts);
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
