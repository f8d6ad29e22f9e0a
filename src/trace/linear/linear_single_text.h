/* The one text that linear_single.c stamps for each precision. Included with REAL and FN(name) defined. */

static void FN(single_group)(FN(search) * s, uint32_t group, uint32_t instance) {
    const world *w = s->world;
    FN(search_enter)(s, instance);
    for (uint32_t g = 0; g < w->groups.items[group].count && !(s->any && s->met); ++g) {
        s->at[1] = w->groups.items[group].first + g;
        const world_geometry *geometry = &w->geometries.items[s->at[1]];
        if (s->any && geometry->flags & FATHOM_CASTS_NO_SHADOW) continue;
        for (uint32_t k = 0; k < geometry->count && !(s->any && s->met); ++k)
            FN(search_primitive)(s, geometry, k);
    }
}

static void FN(single_world)(FN(search) * s, const trace_tracer *tracer) {
    const world *w = tracer->world;
    FN(single_group)(s, 0, FATHOM_NONE);
    for (size_t k = 0; k < w->instances.count && !(s->any && s->met); ++k)
        FN(single_group)(s, w->instances.items[k].group, (uint32_t)k);
}

static void FN(single_closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine,
                               size_t count, trace_coherence coherence) {
    (void)coherence;
    FN(search_closest)(tracer, ((const single_tracer *)tracer)->form, blocks, fine, count, FN(single_world));
}

static void FN(single_any)(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                           trace_coherence coherence) {
    (void)coherence;
    FN(search_any)(tracer, ((const single_tracer *)tracer)->form, blocks, count, FN(single_world));
}

#undef REAL
#undef FN
