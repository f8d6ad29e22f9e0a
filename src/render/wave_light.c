#include "render/wave.h"

/* The shadow ray ends just short of the light: a surface that holds the light does not shade itself. Two
 * roundings enter the distance, and one the product. */
static const float before_light = 1 - 4 * 0x1p-24f;

static void push_shadow(wave *w, const light_block *from, const surface_block *s, uint32_t i) {
    size_t block = w->shadows.count / LANES, lane = w->shadows.count % LANES;
    trace_rays *rays = &w->shadows.rays[block];
    path_block *path = &w->shadows.paths[block];
    rays->org_x[lane] = from->origin[0][i];
    rays->org_y[lane] = from->origin[1][i];
    rays->org_z[lane] = from->origin[2][i];
    rays->dir_x[lane] = from->direction[0][i];
    rays->dir_y[lane] = from->direction[1][i];
    rays->dir_z[lane] = from->direction[2][i];
    rays->t_near[lane] = w->plan->t_near;
    rays->t_far[lane] = from->distance[i] * before_light;
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = from->radiance[c][i];
    path->slot[lane] = s->slot[i];
    path->depth[lane] = s->depth[i];
    ++w->shadows.count;
}

/* Rays only where there is something to gain. */
static void push_shadows(wave *w, const light_block *from, const surface_block *s) {
    const float least = w->plan->parts & FATHOM_PART_UNLIT ? -1 : 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        float gain = from->radiance[0][i] + from->radiance[1][i] + from->radiance[2][i];
        if (gain > least && from->distance[i] > 0) push_shadow(w, from, s, i);
    }
}

static void add_seen(wave *w) {
    for (size_t k = 0; k < w->shadows.count; ++k) {
        size_t block = k / LANES, lane = k % LANES;
        if (w->shadows.rays[block].t_far[lane] < 0) continue;
        const path_block *path = &w->shadows.paths[block];
        for (int c = 0; c < 3; ++c) w->radiance[c][path->slot[lane]] += path->weight[c][lane];
    }
}

static void repair_shadows(wave *w, uint8_t light_depth) {
    for (size_t done = 0; done < w->shadows.count; done += LANES) {
        size_t block = done / LANES, left = w->shadows.count - done;
        w->rays.repaired +=
            watertight_any(w->plan->watertight, &w->shadows.rays[block], w->shadows.paths[block].depth,
                           light_depth, left < LANES ? (unsigned)left : LANES);
    }
}

static bool trace_shadows(wave *w, uint32_t light, trace_coherence coherence) {
    size_t piece = wave_trace_piece(w);
    for (size_t done = 0; done < w->shadows.count; done += piece) {
        if (atomic_load_explicit(w->stop, memory_order_relaxed)) return false;
        size_t left = w->shadows.count - done;
        trace_any(w->plan->tracer, w->shadows.rays + done / LANES, left < piece ? left : piece, coherence);
    }
    if (w->plan->watertight) repair_shadows(w, w->plan->light_depths[light]);
    w->rays.shadow += w->shadows.count;
    add_seen(w);
    return true;
}

/* Light by light: rays of one queue all run towards the same point. */
static bool add_light(wave *w, uint32_t index, trace_coherence coherence) {
    const render_plan *plan = w->plan;
    const shade_light *light = &plan->lights[index];
    w->shadows.count = 0;
    if (!wave_reserve_shadows(w, w->surface_count)) return false;
    for (size_t b = 0; b * LANES < w->surface_count; ++b) {
        const surface_block *s = &w->surfaces[b];
        material_block materials;
        light_block arriving;
        plan->kernels->material_gather(plan->scene->materials.items, s, &materials);
        plan->kernels->light_evaluate(light, s, &materials, (plan->parts & FATHOM_PART_HIGHLIGHTS) != 0,
                                      &arriving);
        push_shadows(w, &arriving, s);
    }
    w->rays.unlit += w->surface_count - w->shadows.count;
    return trace_shadows(w, index, coherence);
}

bool wave_light(wave *w, bool first) {
    const render_plan *plan = w->plan;
    for (size_t b = 0; plan->parts & FATHOM_PART_GLOW && b * LANES < w->surface_count; ++b) {
        material_block materials;
        plan->kernels->material_gather(plan->scene->materials.items, &w->surfaces[b], &materials);
        material_add_constant(&materials, &w->surfaces[b], plan->scene->ambient, w->radiance);
    }
    for (uint32_t i = 0; i < plan->light_count; ++i) {
        if (!add_light(w, i, first ? TRACE_COHERENT : TRACE_INCOHERENT)) return false;
    }
    return true;
}
