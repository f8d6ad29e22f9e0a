/* Integrators: compute the radiance of pixel samples. Work units, threads and the film use only this
 * interface. */
#pragma once

#include "integrate/plan.h"

#include <stdatomic.h>

typedef struct ray_counts {
    uint64_t camera, shadow, reflection, refraction;
    uint64_t repaired; /* of these: results corrected by trace/watertight */
    uint64_t unlit;    /* skipped shadow rays: their light contributes nothing */
    uint64_t faint;    /* skipped shadow rays: their light contributes too little */
} ray_counts;

/* Adds all counts `times` times. */
static inline void ray_counts_add(const ray_counts *from, int times, ray_counts *to) {
    const uint64_t *a = (const uint64_t *)from;
    uint64_t *sum = (uint64_t *)to;
    for (size_t i = 0; i < sizeof *from / sizeof *a; ++i) sum[i] += a[i] * (uint64_t)times;
}

/* Rays that were traced. */
static inline uint64_t ray_counts_total(const ray_counts *r) {
    return r->camera + r->shadow + r->reflection + r->refraction;
}

/* The state of one thread. Integrators place it at the start of their own state. */
typedef struct integration {
    const render_plan *plan;
    const atomic_bool *stop;
    wave_samples samples;  /* of the last batch */
    uint32_t *square_rays; /* [WAVE_SQUARES], of the last batch, by square: camera, mirrored and refracted
                              rays; NULL: not counted */
    ray_counts rays;       /* of all batches */
    bool out_of_memory;
} integration;

typedef struct integrator {
    /* Creates the state of one thread, which runs until stop becomes true; NULL if out of memory. */
    integration *(*create)(const render_plan *plan, const atomic_bool *stop);
    /* Computes the samples of the squares' pixels that lie in the region; writes their radiance and first
     * hits by slot. A sample's radiance depends only on its key and the plan. False if it was stopped, ran
     * out of memory, or met what the reference does not support: the results must not be used then. */
    bool (*run)(integration *state, const wave_region *region, const wave_batch *batch);
    void (*destroy)(integration *state);
} integrator;

/* Classic recursive ray tracing (Whitted 1980): point and directional lights, mirrors and clear glass. Each
 * path splits into its mirrored and refracted rays. */
extern const integrator integrator_classic;

/* Unidirectional path tracing with next event estimation: global illumination. Its expected value is the
 * solution of the rendering equation. */
extern const integrator integrator_path;

/* A second, independent implementation of path tracing: slow, in double; see reference.h. It writes no
 * AOVs. */
extern const integrator integrator_reference;
