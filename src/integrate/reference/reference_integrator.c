/* The reference with the interface of integrators: one sample at a time. */
#include "integrate/integrator.h"
#include "integrate/reference/reference.h"
#include "math/limit.h"

#include <stdlib.h>
#include <string.h>

static bool add_sample(integration *state, const wave_square *square, uint32_t slot) {
    const uint32_t lane = slot % LANES, index = square->index * SAMPLE_GROUPS + square->group;
    vec3_f64 rgb;
    if (!reference_sample(state->plan->reference, square->left + lane % 4, square->top + lane / 4, index,
                          &rgb))
        return false;
    state->samples.radiance[0][slot] = limited((float)rgb.x);
    state->samples.radiance[1][slot] = limited((float)rgb.y);
    state->samples.radiance[2][slot] = limited((float)rgb.z);
    ++state->rays.camera;
    return true;
}

static bool run(integration *state, const wave_region *region, const wave_batch *batch) {
    memset(state->samples.radiance[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    for (uint32_t s = 0; s < batch->count; ++s) {
        uint32_t left = wave_square_pixels(region, &batch->squares[s]);
        if (state->square_rays) state->square_rays[s] = (uint32_t)__builtin_popcount(left);
        for (; left; left &= left - 1) {
            const uint32_t slot = s * LANES + (uint32_t)__builtin_ctz(left);
            if (atomic_load_explicit(state->stop, memory_order_relaxed)) return false;
            if (!add_sample(state, &batch->squares[s], slot)) return false;
        }
    }
    return true;
}

static void destroy(integration *state) {
    if (!state) return;
    free(state->samples.radiance[0]);
    free(state);
}

static integration *create(const render_plan *plan, const atomic_bool *stop) {
    integration *state = calloc(1, sizeof *state);
    float *radiance = calloc(3 * WAVE_SLOTS, sizeof *radiance);
    if (!state || !radiance) {
        free(state);
        free(radiance);
        return NULL;
    }
    *state = (integration){.plan = plan, .stop = stop};
    for (int c = 0; c < 3; ++c) state->samples.radiance[c] = radiance + c * WAVE_SLOTS;
    return state;
}

const integrator integrator_reference = {create, run, destroy};
