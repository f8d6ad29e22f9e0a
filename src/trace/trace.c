#include "trace/trace.h"
#include "trace/planes.h"
#include "trace/tracer.h"

fathom_status trace_create(fathom_context *context, const world *w, const trace_options *options,
                           trace_tracer **out) {
    *out = NULL;
    switch (options->kind) {
    case FATHOM_TRACER_EMBREE: return embree_create(context, w, options, out);
    case FATHOM_TRACER_REFERENCE: return linear_create(context, w, options, out);
    }
    return fail(context, FATHOM_BAD_USAGE, "trace_options: kind: %d; expected a fathom_tracer_kind",
                (int)options->kind);
}

void trace_destroy(trace_tracer *tracer) {
    if (tracer) tracer->ops->destroy(tracer);
}

void trace_closest(const trace_tracer *tracer, trace_block *blocks, size_t count, trace_coherence coherence) {
    tracer->ops->closest(tracer, blocks, count, coherence);
    planes_closest(tracer->world, blocks, count);
}

void trace_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    tracer->ops->any(tracer, blocks, count, coherence);
    planes_any(tracer->world, blocks, count);
}

const char *trace_name(const trace_tracer *tracer) { return tracer->name; }
uint64_t trace_bvh_bytes(const trace_tracer *tracer) { return tracer->bvh_bytes; }
