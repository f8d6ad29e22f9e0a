/* Light that the vertices of paths ask for. */
#include "base/kernel.h"
#include "integrate/path_kernels.h"
#include "math/limit.h"

#include <math.h>

static void aim(const surface_block *s, const emitter_sample *light, light_block *restrict ray,
                uint32_t behind[restrict LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float along = 0, to[3], square = 0;
        for (int c = 0; c < 3; ++c) along += light->direction[c][i] * s->ng[c][i];
        behind[i] = along < 0 ? ~0u : 0;
        const float off = along < 0 ? -s->offset[i] : s->offset[i];
        const uint32_t far = light->distance[i] == INFINITY ? ~0u : 0;
        const float distance = chosen(far, 1, light->distance[i]);
        for (int c = 0; c < 3; ++c) {
            const float start = surface_start(s->p[c][i], off, s->ng[c][i]);
            ray->origin[c][i] = start;
            to[c] = light->direction[c][i] * distance - chosen(far, 0, start - s->p[c][i]);
            square += to[c] * to[c];
        }
        const float length = sqrtf(square), inverse = 1 / length;
        const uint32_t there = length > 0 ? ~0u : 0;
        for (int c = 0; c < 3; ++c)
            ray->direction[c][i] = chosen(there, to[c] * inverse, light->direction[c][i]);
        ray->distance[i] = chosen(far, INFINITY, length);
    }
}

static void weigh(const path_block *path, const emitter_sample *light, const lanes3 f,
                  const float density[LANES], const uint32_t done[LANES], float (*restrict gain)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        const uint32_t any = (light->density[i] > 0 ? ~0u : 0) & ~done[i];
        const float asked = chosen(any, light->density[i], 1);
        const float share = chosen(light->sized[i] & any, path_power_heuristic(asked, density[i]), 1);
        const float scale = chosen(any, share / asked, 0);
        for (int c = 0; c < 3; ++c)
            gain[c][i] =
                limited(path->weight[c][i] * limited(f[c][i] * limited(light->radiance[c][i] * scale)));
    }
}

const path_kernels KERNEL(path_kernels) = {.aim = aim, .weigh = weigh};
