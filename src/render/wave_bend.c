#include "render/wave.h"

/* A path whose weight can no longer change the image ends here. */
static bool worth_tracing(const wave *w, const bend_block *from, uint32_t i) {
    float limit = w->plan->settings.min_weight;
    return from->weight[0][i] > limit || from->weight[1][i] > limit || from->weight[2][i] > limit;
}

static void push_path(wave *w, const bend_block *from, uint32_t slot, uint8_t depth, uint32_t i) {
    size_t block = w->next.count / LANES, lane = w->next.count % LANES;
    trace_rays *rays = &w->next.rays[block].rays;
    path_block *path = &w->next.paths[block];
    rays->org_x[lane] = from->origin[0][i];
    rays->org_y[lane] = from->origin[1][i];
    rays->org_z[lane] = from->origin[2][i];
    rays->dir_x[lane] = from->direction[0][i];
    rays->dir_y[lane] = from->direction[1][i];
    rays->dir_z[lane] = from->direction[2][i];
    rays->t_near[lane] = w->plan->t_near;
    rays->t_far[lane] = INFINITY;
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = from->weight[c][i];
    path->slot[lane] = slot;
    path->depth[lane] = depth;
    ++w->next.count;
}

static bool push_paths(wave *w, const bend_block *from, const surface_block *s, const uint8_t *depths) {
    if (!wave_reserve_paths(w, &w->next, LANES)) return false;
    for (uint32_t i = 0; i < s->count; ++i) {
        if (worth_tracing(w, from, i)) push_path(w, from, s->slot[i], depths[i], i);
    }
    return true;
}

bool wave_bend(wave *w) {
    const shade_kernels *kernels = w->plan->kernels;
    const scene_named_material *table = w->plan->scene->materials.items;
    const bool refracts = (w->plan->features & MATERIAL_REFRACT) != 0;
    const size_t blocks = (w->surface_count + LANES - 1) / LANES;
    if (refracts && !wave_reserve_refracted(w, blocks)) return false;
    for (size_t b = 0; b < blocks; ++b) {
        const surface_block *s = &w->surfaces[b];
        material_block materials;
        bend_block mirrored, none;
        kernels->material_gather(table, s, &materials);
        kernels->bend_rays(s, &materials, &mirrored, refracts ? &w->refracted[b] : &none);
        if (!push_paths(w, &mirrored, s, s->depth)) return false;
    }
    w->next.mirrored = w->next.count;
    for (size_t b = 0; refracts && b < blocks; ++b) {
        const surface_block *s = &w->surfaces[b];
        if (!push_paths(w, &w->refracted[b], s, s->depth_behind)) return false;
    }
    w->rays.reflection += w->next.mirrored;
    w->rays.refraction += w->next.count - w->next.mirrored;
    return true;
}
