#include "trace/bvh/bvh.h"

#include <stdio.h>
#include <stdlib.h>

static void tree_free(bvh_tree *tree) {
    free(tree->nodes);
    free(tree->blocks);
    free(tree->items);
}

static uint64_t tree_bytes(const bvh_tree *tree) {
    return tree->node_count * sizeof *tree->nodes +
           tree->count * (tree->blocks ? sizeof *tree->blocks : sizeof *tree->items);
}

void bvh_destroy(trace_tracer *base) {
    bvh_tracer *tracer = (bvh_tracer *)base;
    const world *w = base->world;
    for (size_t g = 0; tracer->geometries && g < w->geometries.count; ++g) tree_free(&tracer->geometries[g]);
    for (size_t g = 0; tracer->groups && g < w->groups.count; ++g) tree_free(&tracer->groups[g]);
    free(tracer->geometries);
    free(tracer->groups);
    free(tracer);
}

fathom_status bvh_create(fathom_context *context, const world *w, const trace_spec *spec,
                         const trace_options *options, trace_tracer **out) {
    static const struct {
        const trace_ops *ops;
        double unit;
        const char *name;
    } precisions[] = {[TRACE_F32] = {&bvh_ops_f32, 0x1p-24, "f32"},
                      [TRACE_F64] = {&bvh_ops_f64, 0x1p-53, "f64"},
                      [TRACE_F128] = {&bvh_ops_f128, 0x1p-113, "f128"}};
    bvh_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = precisions[spec->precision].ops;
    tracer->base.world = w;
    tracer->base.unit = precisions[spec->precision].unit;
    snprintf(tracer->base.name, sizeof tracer->base.name, "reference BVH, %s",
             precisions[spec->precision].name);
    bvh_build build = {.context = context,
                       .threads = options->threads ? options->threads : fathom_context_threads(context),
                       .go_on = options->progress,
                       .user = options->user};
    fathom_status status = bvh_world_build(&build, tracer);
    if (status != FATHOM_OK) {
        bvh_destroy(&tracer->base);
        return status;
    }
    for (size_t g = 0; g < w->geometries.count; ++g)
        tracer->base.bvh_bytes += tree_bytes(&tracer->geometries[g]);
    for (size_t g = 0; g < w->groups.count; ++g) tracer->base.bvh_bytes += tree_bytes(&tracer->groups[g]);
    *out = &tracer->base;
    return FATHOM_OK;
}
