/* How light moves: from samples of pixels to their radiance. Work units, threads and the film know
 * integrators by this interface alone. */
#ifndef INTEGRATE_INTEGRATOR_H
#define INTEGRATE_INTEGRATOR_H

#include "integrate/plan.h"

#include <stdatomic.h>

typedef struct ray_counts {
    uint64_t camera, shadow, reflection, refraction;
    uint64_t repaired; /* of these: answers put right by trace/watertight */
    uint64_t unlit;    /* shadow rays that nothing was to be gained from */
    uint64_t faint;    /* and too little */
} ray_counts;

static inline void ray_counts_add(const ray_counts *from, ray_counts *to) {
    to->camera += from->camera;
    to->shadow += from->shadow;
    to->reflection += from->reflection;
    to->refraction += from->refraction;
    to->repaired += from->repaired;
    to->unlit += from->unlit;
    to->faint += from->faint;
}

/* One thread's work: integrators put this in front of their own state. */
typedef struct integration {
    const render_plan *plan;
    const atomic_bool *stop;
    wave_samples samples;  /* of the last batch */
    uint32_t *square_rays; /* [WAVE_SQUARES], of the last batch by place: the camera's, mirrored and
                              refracted; NULL: not counted */
    ray_counts rays;       /* of all batches */
    bool out_of_memory;
} integration;

typedef struct integrator {
    /* For one thread, until stop becomes true; NULL when out of memory. */
    integration *(*create)(const render_plan *plan, const atomic_bool *stop);
    /* Takes the samples of those pixels of the squares that lie in the region, and leaves their radiance, and
     * first hits, by slot. A sample's radiance depends on its key and the plan alone. False when it was
     * stopped or ran out of memory: then nothing of it may be used. */
    bool (*run)(integration *state, const wave_region *region, const wave_batch *batch);
    void (*destroy)(integration *state);
} integrator;

/* Classic recursive ray tracing (Whitted 1980): lights of no size, mirrors and clear glass. Each path splits
 * into its mirrored and refracted rays. */
extern const integrator integrator_classic;

/* Unidirectional path tracing with next event estimation: global illumination. Its expectation is the
 * rendering equation's solution. */
extern const integrator integrator_path;

/* The same light in double, slowly, by a second implementation; see reference.h. It makes no AOVs. */
extern const integrator integrator_reference;

#endif
