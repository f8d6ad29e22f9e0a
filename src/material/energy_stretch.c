/* Albedos of GGX lobes with two alphas; as energy.c, with a viewer at any azimuth. */
#include "material/energy.h"
#include "material/shader.h"
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
    return fmaxf(y * y * (y * y), SHADER_SMOOTH_ALPHA);
}

typedef struct lobe {
    float ax, ay, v[3];
    float s[3],
        smith; /* s: v in the space where the facets are a hemisphere, made unit; smith: its length there */
} lobe;

static void add_facets(const lobe *m, float u, float all[ALONG], float edge[ALONG]) {
    float cosine, sine;
    turn_by(u, &cosine, &sine);
    for (int k = 0; k < ALONG; ++k) {
        float q = ((float)k + 0.5f) / ALONG, up = q * q * (1 + m->s[2]);
        float below = (m->s[0] * m->s[0] + m->s[1] * m->s[1]) / (1 + m->s[2]);
        float square = (1 - q * q) * (1 + m->s[2]) * (below + up), r = sqrtf(square > 0 ? square : 0);
        float hx = m->ax * (m->s[0] + r * cosine), hy = m->ay * (m->s[1] + r * sine);
        float unit = 1 / sqrtf(hx * hx + hy * hy + up * up);
        hx *= unit, hy *= unit, up *= unit;
        float along = m->v[0] * hx + m->v[1] * hy + m->v[2] * up;
        float x = 2 * along * hx - m->v[0], y = 2 * along * hy - m->v[1], z = 2 * along * up - m->v[2];
        z = z > 0 ? z : 0;
        float s = sqrtf(m->ax * m->ax * x * x + m->ay * m->ay * y * y + z * z);
        float part = 2 * q * z * (m->v[2] + m->smith) / (m->v[2] * s + z * m->smith);
        all[k] += part, edge[k] += part * power5(along < 1 ? 1 - along : 0);
    }
}

static void albedo(float ax, float ay, float mu, float x, float y, float out[2]) {
    const float sine = sqrtf((1 - mu) * (1 + mu));
    lobe m = {.ax = ax, .ay = ay, .v = {sine * x, sine * y, mu}};
    const float sx = ax * m.v[0], sy = ay * m.v[1];
    m.smith = sqrtf(sx * sx + sy * sy + mu * mu);
    m.s[0] = sx / m.smith, m.s[1] = sy / m.smith, m.s[2] = mu / m.smith;
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
        const float w = (float)k / ENERGY_STEPS, mu = fmaxf(w * w * (w * w), 1e-6f);
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
    const float x = sqrtf(sqrtf(fminf(alpha, 1))) * STEPS;
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
