/* Steps of path tracing for a block of sixteen vertices at once; see base/kernel.h. */
#pragma once

#include "base/kernel.h"
#include "integrate/kernels.h"
#include "light/emitters.h"
#include "material/shader.h"
#include "surface/surface.h"

/* The weight of a light sample of density a, and of a scattered ray if a and b are exchanged. `a` may be
 * infinite but not 0. The power heuristic suits lamps and suns; light samples of skies are made for the
 * balance heuristic (light/sky.h). sky: all ones for light of skies and backgrounds. */
static inline float path_share(float a, float b, uint32_t sky) {
    const float ratio = b / a;
    return 1 / (1 + chosen(sky, ratio, ratio * ratio));
}

typedef struct path_kernels {
    /* Shadow rays start clear of the surface, on the light's side, and end at the light sample. n: shading
     * normals, as in shader_block. Where these face a light below the horizon of a smooth mesh's facet, the
     * ray starts at `lift` (surface/surface.h). */
    void (*aim)(const surface_block *s, const lanes3 n, const emitter_sample *light, light_block *ray,
                uint32_t behind[LANES]);

    /* The contribution of light samples. f and density: of the BSDFs, for the sampled direction. factor: see
     * emitters_mis_factor(). done: all ones for paths that have reached the maximum number of bounces. */
    void (*weigh)(const path_block *path, const emitter_sample *light, const lanes3 f,
                  const float density[LANES], float factor, const uint32_t done[LANES], lanes3 gain);

    /* The weights of paths after the scattering `to`. */
    void (*carry)(const path_block *path, const shader_sample *to, lanes3 weight);

    /* Returns bits: lanes whose paths continue. u: for Russian roulette, which increases the weight of
     * surviving paths; NULL: no roulette. safe: all ones for paths that it does not end. */
    uint32_t (*survive)(const float u[LANES], const uint32_t safe[LANES], lanes3 weight);

    /* The rays of the scattered paths. */
    void (*depart)(const surface_block *s, const shader_sample *to, float t_near, trace_rays *out);
} path_kernels;

const path_kernels *path_kernels_best(void);
