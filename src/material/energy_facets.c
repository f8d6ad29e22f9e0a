/* Albedos of GGX facets with any reflectance: how much of the light that a viewer sees comes from facets at
 * each cosine to the viewer. This does not depend on the reflectance, so films are cheap where their
 * thickness varies. */
#include "material/energy.h"
#include "material/shader.h"
#include "math/turn.h"

#include <math.h>
#include <pthread.h>

/* Tables at alphas (j / STEPS)^4, the larger one first. */
enum { STEPS = 24, ROWS = STEPS + 1, NODES = ENERGY_FACETS_STEPS + 1, AROUND = 24, ALONG = 32, TURNS = 8 };
typedef struct weights {
    float of[NODES][NODES]; /* by the viewer's cosine, by that of viewer and facet */
} weights;
static weights tables[ROWS * (ROWS + 1) / 2];
static bool made[ROWS * (ROWS + 1) / 2];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* s: the viewer in the space where the facets are a hemisphere, made unit; smith: its length there. */
typedef struct viewer {
    float ax, ay, v[3], s[3], smith;
} viewer;

static viewer viewer_at(float ax, float ay, float mu, float turn) {
    const float sine = sqrtf((1 - mu) * (1 + mu));
    float x, y;
    turn_by(turn, &x, &y);
    viewer m = {.ax = ax, .ay = ay, .v = {sine * x, sine * y, mu}};
    const float sx = ax * m.v[0], sy = ay * m.v[1];
    m.smith = sqrtf(sx * sx + sy * sy + mu * mu);
    m.s[0] = sx / m.smith, m.s[1] = sy / m.smith, m.s[2] = mu / m.smith;
    return m;
}

/* The parametrisation of energy.c. */
static void add_ring(const viewer *m, float u, float part, float out[NODES]) {
    float cosine, sine, share[ALONG], place[ALONG];
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
        share[k] = part * 2 * q * z * (m->v[2] + m->smith) / (m->v[2] * s + z * m->smith);
        place[k] = sqrtf(along > 0 ? (along < 1 ? along : 1) : 0) * ENERGY_FACETS_STEPS;
    }
    for (int k = 0; k < ALONG; ++k) {
        const int node = place[k] < ENERGY_FACETS_STEPS - 1 ? (int)place[k] : ENERGY_FACETS_STEPS - 1;
        const float t = place[k] - (float)node;
        out[node] += (1 - t) * share[k], out[node + 1] += t * share[k];
    }
}

static float alpha_at(int j) {
    const float y = (float)j / STEPS;
    return y * y * (y * y);
}

/* All azimuths are alike if the alphas are equal, and both halves of the rings. */
static void fill(int along, int across, weights *out) {
    const int turns = along == across ? 1 : TURNS;
    const float ax = alpha_at(along), ay = fmaxf(alpha_at(across), SHADER_SMOOTH_ALPHA);
    for (int k = 0; k < NODES; ++k) {
        const float x = (float)k / ENERGY_FACETS_STEPS, mu = fmaxf(x * x, 1e-6f);
        if (ax < SHADER_SMOOTH_ALPHA) out->of[k][k] = 1;
        for (int j = 0; j < turns && ax >= SHADER_SMOOTH_ALPHA; ++j) {
            const viewer m = viewer_at(ax, ay, mu, turns > 1 ? 0.25f * ((float)j + 0.5f) / TURNS : 0);
            for (int i = 0; i < AROUND; ++i)
                add_ring(&m, (turns > 1 ? 1 : 0.5f) * ((float)i + 0.5f) / AROUND,
                         1.0f / (float)(turns * AROUND * ALONG), out->of[k]);
        }
    }
}

static const weights *table_at(int along, int across) {
    const int place = along * (along + 1) / 2 + across;
    bool *done = &made[place];
    if (!__atomic_load_n(done, __ATOMIC_ACQUIRE)) {
        pthread_mutex_lock(&lock);
        if (!*done) {
            fill(along, across, &tables[place]);
            __atomic_store_n(done, true, __ATOMIC_RELEASE);
        }
        pthread_mutex_unlock(&lock);
    }
    return &tables[place];
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

static int row_of(float alpha, float *part) {
    const float x = sqrtf(sqrtf(fminf(alpha, 1))) * STEPS;
    const int j = x < STEPS - 1 ? (int)x : STEPS - 1;
    *part = x - (float)j;
    return j;
}

void energy_facets(float along, float across, const float curve[NODES], float out[NODES]) {
    float s, t;
    const int j = row_of(along, &s), k = row_of(across, &t);
    if (along == across) {
        add_table(j, j, 1 - s, curve, out), add_table(j + 1, j + 1, s, curve, out);
        return;
    }
    for (int r = 0; r < 4; ++r)
        add_table(j + (r & 1), k + (r >> 1), (r & 1 ? s : 1 - s) * (r >> 1 ? t : 1 - t), curve, out);
}
