/* Albedos of GGX lobes with two alphas; as energy.c, with a viewer at any azimuth. */
#include "material/energy.h"
#include "material/energy_ring.h"
#include "material/shader.h"
#include "math/limit.h"
#include "math/power.h"
#include "math/turn.h"

#include <math.h>
#include <pthread.h>

/* Tables at alphas (j / STEPS)^4. */
enum { STEPS = 36, AROUND = 32, ALONG = 32 };
static energy_table tables[STEPS + 1][STEPS + 1]; /* along, across */
static bool made[STEPS + 1][STEPS + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static float alpha_at(int j) {
    const float y = (float)j / STEPS;
    return most(y * y * (y * y), SHADER_SMOOTH_ALPHA);
}

static void add_facets(const ring_viewer *m, float u, float all[ALONG], float edge[ALONG]) {
    float cosine, sine;
    turn_by(u, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        const float q = ((float)k + 0.5f) / ALONG;
        const ring_facet f = ring_facet_at(m, q, cosine, sine);
        const float part = 2 * q * ring_mirrored(m, &f);
        all[k] += part, edge[k] += part * power5(f.along < 1 ? 1 - f.along : 0);
    }
}

static void albedo(float ax, float ay, float mu, float x, float y, float out[2]) {
    const float sine = sqrtf((1 - mu) * (1 + mu));
    const ring_viewer m = ring_viewer_at(ax, ay, (float[3]){sine * x, sine * y, mu});
    float all[ALONG] = {0}, edge[ALONG] = {0};
    for (int j = 0; j < AROUND; ++j) add_facets(&m, ((float)j + 0.5f) / AROUND, all, edge);
    out[0] = out[1] = 0;
    for (int k = 0; k < ALONG; ++k) out[0] += all[k], out[1] += edge[k];
    out[0] /= AROUND * ALONG, out[1] /= AROUND * ALONG;
}

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

static void fill(float ax, float ay, energy_table *out) {
    float part[ENERGY_TURNS + 1];
    energy_turn_parts(part);
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float w = (float)k / ENERGY_STEPS, mu = most(w * w * (w * w), 1e-6f);
        for (int j = 0; j <= ENERGY_TURNS; ++j) {
            const float y = (float)j / ENERGY_TURNS, x = 1 - y, unit = 1 / sqrtf(x * x + y * y);
            float both[2];
            albedo(ax, ay, mu, x * unit, y * unit, both);
            for (int c = 0; c < 2; ++c) {
                out->albedo[c][j][k] = both[c];
                out->around[c][k] += part[j] * both[c];
            }
        }
    }
}

static const energy_table *table_at(int along, int across) {
    bool *done = &made[along][across];
    if (!__atomic_load_n(done, __ATOMIC_ACQUIRE)) {
        pthread_mutex_lock(&lock);
        if (!*done) {
            fill(alpha_at(along), alpha_at(across), &tables[along][across]);
            __atomic_store_n(done, true, __ATOMIC_RELEASE);
        }
        pthread_mutex_unlock(&lock);
    }
    return &tables[along][across];
}

static int row_of(float alpha, float *part) {
    const float x = sqrtf(sqrtf(least(alpha, 1))) * STEPS;
    const int j = x < STEPS - 1 ? (int)x : STEPS - 1;
    *part = x - (float)j;
    return j;
}

void energy_stretched(float along, float across, energy_stretch *out) {
    float s, t;
    const int j = row_of(along, &s), k = row_of(across, &t);
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
