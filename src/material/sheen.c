/* The albedo of the fibres of KHR_materials_sheen, by the midpoint rule over the hemisphere. */
#include "material/kernels/sheen.h"

#include "material/layers.h"
#include "math/turn.h"

#include <pthread.h>

/* The smallest roughness; below it the fibres' lobe is narrower than float cosines resolve. */
#define LEAST 0.07f

enum { ROWS = 24, ALONG = 48, AROUND = 16 };
static float albedos[ROWS + 1][ENERGY_NODES];

static void set_fibres(float roughness, shader *out) {
    const double log2e = 1.4426950408889634, alpha = (double)roughness * (double)roughness;
    const double t = (1 - alpha) * (1 - alpha);
    const double a = 21.5473 + t * (25.3245 - 21.5473), b = 3.82987 + t * (3.32435 - 3.82987);
    const double c = 0.19823 + t * (0.16801 - 0.19823), d = -1.97760 + t * (-1.27393 + 1.97760);
    const double e = -4.32054 + t * (-4.85967 + 4.32054), half = a / (1 + b * pow(0.5, c)) + d * 0.5 + e;
    const double fit[6] = {a * log2e, b, c, d * log2e, e * log2e, 2 * half * log2e};
    for (int k = 0; k < 6; ++k) out->sheen_fit[k] = (float)fit[k];
    out->sheen_alpha = (float)alpha;
}

/* The albedo, as a sum over incident cosines mu = x^2, which are dense where the lobe is. */
static float albedo(const shader *m, const float lambda[ALONG], float z) {
    const float sine = sqrtf((1 - z) * (1 + z)), own = 1 + sheen_lambda(m, z), exponent = 1 / m->sheen_alpha;
    float sum = 0;
    for (int k = 0; k < ALONG; ++k) {
        const float x = ((float)k + 0.5f) / ALONG, lz = x * x, ls = sqrtf((1 - lz) * (1 + lz));
        float ring = 0;
        for (int j = 0; j < AROUND; ++j) {
            float cosine, unused;
            turn_by(0.5f * ((float)j + 0.5f) / AROUND, &cosine, &unused);
            const float up = z + lz, square = 2 + 2 * (z * lz + sine * ls * cosine);
            const float h2 = square > 0x1p-40f ? up * up / square : 1;
            ring += power_one_less(h2 < 1 ? h2 : 1, 0.5f * exponent);
        }
        sum += ring * 2 * x / (4 * z * (own + lambda[k]));
    }
    return sum * (2 + exponent) / (ALONG * AROUND);
}

static void fill(void) {
    for (int r = 0; r <= ROWS; ++r) {
        shader m;
        float lambda[ALONG];
        set_fibres(LEAST + (1 - LEAST) * (float)r / ROWS, &m);
        for (int k = 0; k < ALONG; ++k) {
            const float x = ((float)k + 0.5f) / ALONG;
            lambda[k] = sheen_lambda(&m, x * x);
        }
        for (int k = 0; k < ENERGY_NODES; ++k) {
            const float x = (float)k / ENERGY_STEPS, mu = x * x * (x * x);
            albedos[r][k] = albedo(&m, lambda, mu > 1e-6f ? mu : 1e-6f);
        }
    }
}

static pthread_once_t once = PTHREAD_ONCE_INIT;

void prepare_sheen(const fathom_material *m, shader *out) {
    pthread_once(&once, fill);
    const float roughness = fmaxf(m->sheen_roughness, LEAST), *c = m->sheen_color;
    const float most = fmaxf(c[0], fmaxf(c[1], c[2])), row = (roughness - LEAST) / (1 - LEAST) * ROWS;
    const int r = (int)row < ROWS - 1 ? (int)row : ROWS - 1;
    set_fibres(roughness, out);
    out->sheen_most = most;
    for (int k = 0; k < ENERGY_NODES; ++k) {
        const float low = albedos[r][k], high = albedos[r + 1][k];
        out->sheen_albedo[k] = low + (row - (float)r) * (high - low);
    }
    for (int k = 0; k < 3; ++k) {
        out->sheen[k] = c[k];
        out->albedo[k] = fminf(out->albedo[k] + 0.1f * c[k], 1);
    }
    out->lobes |= SHADER_SHEEN;
}
