#include "trace/trace.h"
#include "trace/planes.h"
#include "trace/tracer.h"

#include <stdio.h>

static fathom_status create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out) {
    switch (spec->kind) {
    case TRACE_LINEAR:
        /* What renders goes by blocks. */
        if (spec->form == TRACE_ROBUST && spec->precision == TRACE_F32) return linear_create(context, w, out);
        return linear_single_create(context, w, spec, out);
    case TRACE_EMBREE: return embree_create(context, w, spec, options, out);
    case TRACE_BVH: return bvh_create(context, w, spec, options, out);
    case TRACE_PLUGIN: return plugin_create(context, w, spec, options, out);
    }
    return fail(context, FATHOM_BAD_USAGE, "trace_spec: kind: %d; expected a trace_kind", (int)spec->kind);
}

fathom_status trace_create(fathom_context *context, const world *w, const trace_options *options,
                           trace_tracer **out) {
    *out = NULL;
    const char *unknown = isa_unknown();
    if (unknown)
        return fail(context, FATHOM_BAD_USAGE,
                    "$FATHOM_ISA: expected sse2, sse4.2, avx, avx2 or avx512, found \"%.40s\"", unknown);
    if (options->spec) return create(context, w, options->spec, options, out);
    const trace_spec embree = {.kind = TRACE_EMBREE, .quality = options->quality};
    switch (options->kind) {
    case FATHOM_TRACER_EMBREE: return create(context, w, &embree, options, out);
    case FATHOM_TRACER_REFERENCE: return linear_create(context, w, out);
    }
    return fail(context, FATHOM_BAD_USAGE, "trace_options: kind: %d; expected a fathom_tracer_kind",
                (int)options->kind);
}

void trace_destroy(trace_tracer *tracer) {
    if (tracer) tracer->ops->destroy(tracer);
}

void trace_closest(const trace_tracer *tracer, trace_block *blocks, size_t count, trace_coherence coherence) {
    tracer->ops->closest(tracer, blocks, NULL, count, coherence);
    if (!tracer->ops->planes) planes_closest(tracer->world, blocks, count);
}

void trace_closest_fine(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                        trace_coherence coherence) {
    tracer->ops->closest(tracer, blocks, fine, count, coherence);
    if (!tracer->ops->planes) planes_closest(tracer->world, blocks, count);
    for (size_t i = 0; i < count; ++i) {
        const trace_block *block = &blocks[i / TRACE_WIDTH];
        trace_fine *to = &fine[i / TRACE_WIDTH];
        size_t lane = i % TRACE_WIDTH;
        bool plane = block->hits.geometry[lane] == TRACE_PLANE;
        if (plane ? tracer->ops->planes : tracer->ops->fine) continue;
        to->t[lane] = (double)block->rays.t_far[lane], to->t_low[lane] = 0;
        to->u[lane] = (double)block->hits.u[lane], to->v[lane] = (double)block->hits.v[lane];
    }
}

void trace_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    tracer->ops->any(tracer, blocks, count, coherence);
    if (!tracer->ops->planes) planes_any(tracer->world, blocks, count);
}

const char *trace_name(const trace_tracer *tracer) { return tracer->name; }
void trace_identity(const trace_tracer *tracer, char out[128]) {
    snprintf(out, 128, "%s%s%s", tracer->name, tracer->way[0] ? ", " : "", tracer->way);
}

uint64_t trace_bvh_bytes(const trace_tracer *tracer) { return tracer->bvh_bytes; }
uint64_t trace_peak_bytes(const trace_tracer *tracer) {
    return tracer->peak_bytes > tracer->bvh_bytes ? tracer->peak_bytes : tracer->bvh_bytes;
}
uint64_t trace_foreseen_bytes(const trace_tracer *tracer) { return tracer->foreseen_bytes; }
double trace_unit(const trace_tracer *tracer) { return tracer->unit; }
