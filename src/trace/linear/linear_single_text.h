/* The one text that linear_single.c stamps for each precision. Included with REAL and FN(name) defined. */

static void FN(single_geometry)(FN(search) * s, const world_geometry *geometry) {
    const world *w = s->world;
    for (uint32_t k = 0; k < geometry->count && !(s->any && s->met); ++k) {
        switch (geometry->kind) {
        case WORLD_SPHERES: FN(search_sphere)(s, &w->spheres.items[geometry->first + k], k); break;
        case WORLD_QUADS: FN(search_quad)(s, &w->quads.items[geometry->first + k], k); break;
        case WORLD_MESH: {
            vec3_f32 v[3];
            search_corners(&w->meshes.items[geometry->first], k, v);
            FN(search_triangle)(s, v, k);
            break;
        }
        }
    }
}

static void FN(single_group)(FN(search) * s, uint32_t group, uint32_t instance) {
    const world *w = s->world;
    FN(search_enter)(s, instance);
    for (uint32_t g = 0; g < w->groups.items[group].count && !(s->any && s->met); ++g) {
        s->at[1] = w->groups.items[group].first + g;
        const world_geometry *geometry = &w->geometries.items[s->at[1]];
        if (s->any && geometry->flags & FATHOM_CASTS_NO_SHADOW) continue;
        FN(single_geometry)(s, geometry);
    }
}

static void FN(single_world)(FN(search) * s) {
    const world *w = s->world;
    FN(single_group)(s, 0, FATHOM_NONE);
    for (size_t k = 0; k < w->instances.count && !(s->any && s->met); ++k) {
        FN(single_group)(s, w->instances.items[k].group, (uint32_t)k);
    }
    FN(search_planes)(s);
}

static void FN(single_closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine,
                               size_t count, trace_coherence coherence) {
    (void)coherence;
    for (size_t i = 0; i < count; ++i) {
        trace_block *block = &blocks[i / TRACE_WIDTH];
        FN(search) s;
        if (FN(search_begin)(&s, tracer->world, ((const single_tracer *)tracer)->form, &block->rays,
                             i % TRACE_WIDTH, false)) {
            FN(single_world)(&s);
        }
        FN(search_end)(&s, block, fine ? &fine[i / TRACE_WIDTH] : NULL, i % TRACE_WIDTH);
    }
}

static void FN(single_any)(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                           trace_coherence coherence) {
    (void)coherence;
    for (size_t i = 0; i < count; ++i) {
        trace_rays *rays = &blocks[i / TRACE_WIDTH];
        FN(search) s;
        if (!FN(search_begin)(&s, tracer->world, ((const single_tracer *)tracer)->form, rays, i % TRACE_WIDTH,
                              true)) {
            continue;
        }
        FN(single_world)(&s);
        if (s.met) rays->t_far[i % TRACE_WIDTH] = -INFINITY;
    }
}

#undef REAL
#undef FN
