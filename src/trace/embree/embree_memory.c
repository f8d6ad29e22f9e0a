/* Whether what is to be built fits into what may be used. */
#include "trace/embree/embree.h"
#include "trace/need.h"

#define RESERVE 64000000u

static double total(trace_need need) { return need.kept + need.passed; }

static fathom_status refuse(const embree_tracer *tracer, double need) {
    return fail(tracer->context, FATHOM_OUT_OF_RESOURCES,
                "out of memory: building takes about %.2f GB, and %.2f GB are left beside program, meshes "
                "and image; raise the limit, render on a machine with more memory, or place repeated parts "
                "as instances",
                need * 1e-9, (double)tracer->options->memory * 1e-9);
}

fathom_status embree_fit_memory(embree_tracer *tracer) {
    const world *w = tracer->base.world;
    double room = (double)tracer->options->memory;
    bool chosen = tracer->spec.flags == TRACE_SCENE_COMPACT, free_to_choose = !tracer->options->spec;
    double need = total(trace_need_of(w, chosen)), less = total(trace_need_of(w, true));
    tracer->base.foreseen_bytes = (uint64_t)need;
    if (!tracer->options->memory) return FATHOM_OK;
    /* Embree reserves up to twice what it comes to touch. This is for estimates that are far off. */
    tracer->most_bytes = 2 * tracer->options->memory + RESERVE;
    if (need <= room) return FATHOM_OK;
    if (!free_to_choose || less > room) return refuse(tracer, free_to_choose ? less : need);
    tracer->base.foreseen_bytes = (uint64_t)less;
    tracer->spec.flags = TRACE_SCENE_COMPACT;
    tracer->spec.quality = TRACE_QUALITY_MEDIUM; /* low passes as much as the usual structures */
    warn(tracer->context,
         "the usual acceleration structure would take about %.2f GB, and %.2f GB are left beside program, "
         "meshes and image: a compact one of %.2f GB is built, which is slower to trace",
         need * 1e-9, room * 1e-9, less * 1e-9);
    return FATHOM_OK;
}
