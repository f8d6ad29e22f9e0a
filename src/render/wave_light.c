#include "render/wave.h"

#include <string.h>

/* ---- the queue ---- */

/* Rays that lie where the next block begins. first: the place of the block among the surfaces, in points. */
static void push_block(shadow_queue *queue, const light_block *from, const surface_block *s, uint32_t first) {
    path_block *path = &queue->paths[queue->blocks];
    for (uint32_t i = 0; queue->points && i < LANES; ++i)
        queue->points[queue->blocks * LANES + i] = first + i;
    ++queue->blocks;
    memcpy(path->weight, from->radiance, sizeof path->weight);
    memcpy(path->slot, s->slot, sizeof path->slot);
    memcpy(path->depth, s->depth, sizeof path->depth);
}

static void push_lane(shadow_queue *queue, const trace_rays *rays, const light_block *from,
                      const surface_block *s, uint32_t first, uint32_t i) {
    if (!queue->filled) queue->open = queue->blocks++;
    unsigned lane = queue->filled;
    if (queue->points) queue->points[queue->open * LANES + lane] = first + i;
    path_block *path = &queue->paths[queue->open];
    trace_rays_move(rays, i, &queue->rays[queue->open], lane);
    for (int c = 0; c < 3; ++c) path->weight[c][lane] = from->radiance[c][i];
    path->slot[lane] = s->slot[i];
    path->depth[lane] = s->depth[i];
    queue->filled = (lane + 1) % LANES;
}

/* Blocks whose rays all have something to gain stay as they are: of camera rays, which have a sample each,
 * in any order; of others, whose order is that of their sums, where none waits. Each block of surfaces adds
 * one block of rays at most, and its rays are made there: one that opens meanwhile takes lanes in order, none
 * to a place behind its own. */
static void push_shadows(wave *w, const light_block *from, size_t block, bool first) {
    shadow_queue *queue = &w->shadows;
    const surface_block *s = &w->surfaces[block];
    const uint32_t points = (uint32_t)(block * LANES);
    trace_rays *rays = &queue->rays[queue->blocks];
    uint32_t lanes = w->plan->blocks->shadow_rays(from, 0, w->plan->t_near, rays);
    lanes &= (1u << s->count) - 1;
    if (lanes == (1u << LANES) - 1 && (first || !queue->filled)) {
        push_block(queue, from, s, points);
        return;
    }
    for (; lanes; lanes &= lanes - 1) push_lane(queue, rays, from, s, points, (uint32_t)__builtin_ctz(lanes));
}

static void swap_points(uint32_t *points, size_t a, size_t b) {
    uint32_t kept[LANES];
    memcpy(kept, points + a * LANES, sizeof kept);
    memcpy(points + a * LANES, points + b * LANES, sizeof kept);
    memcpy(points + b * LANES, kept, sizeof kept);
}

/* The open block becomes the last one. */
static void close_queue(shadow_queue *queue) {
    queue->count = queue->blocks * LANES;
    if (!queue->filled) return;
    size_t last = queue->blocks - 1;
    if (queue->open != last) {
        trace_rays rays = queue->rays[last];
        path_block path = queue->paths[last];
        queue->rays[last] = queue->rays[queue->open], queue->paths[last] = queue->paths[queue->open];
        queue->rays[queue->open] = rays, queue->paths[queue->open] = path;
        if (queue->points) swap_points(queue->points, last, queue->open);
    }
    queue->count -= LANES - queue->filled;
}

/* ---- tracing ---- */

static unsigned lanes_from(const shadow_queue *queue, size_t done) {
    return queue->count - done < LANES ? (unsigned)(queue->count - done) : LANES;
}

static void add_seen(wave *w) {
    for (size_t done = 0; done < w->shadows.count; done += LANES) {
        const path_block *path = &w->shadows.paths[done / LANES];
        w->plan->blocks->add_seen(&w->shadows.rays[done / LANES], path->weight, path->slot,
                                  lanes_from(&w->shadows, done), w->radiance);
    }
}

static void repair_shadows(wave *w, uint8_t light_depth) {
    for (size_t done = 0; done < w->shadows.count; done += LANES) {
        size_t block = done / LANES;
        w->rays.repaired +=
            watertight_any(w->plan->watertight, &w->shadows.rays[block], w->shadows.paths[block].depth,
                           light_depth, lanes_from(&w->shadows, done));
    }
}

static bool trace_shadows(wave *w, uint32_t light, trace_coherence coherence) {
    size_t piece = wave_trace_piece(w);
    for (size_t done = 0; done < w->shadows.count; done += piece) {
        if (atomic_load_explicit(w->stop, memory_order_relaxed)) return false;
        size_t left = w->shadows.count - done;
        trace_any(w->plan->tracer, w->shadows.rays + done / LANES, left < piece ? left : piece, coherence);
    }
    if (w->plan->watertight && w->plan->light_depths[light] != PLAN_DEPTH_UNSURE)
        repair_shadows(w, w->plan->light_depths[light]);
    w->rays.shadow += w->shadows.count;
    if (w->plan->lifts) wave_look_from_facets(w, light, coherence);
    add_seen(w);
    return true;
}

/* Light by light: rays of one queue all run towards the same point. */
static bool add_light(wave *w, uint32_t index, bool first) {
    const render_plan *plan = w->plan;
    const shade_light *light = &plan->lights[index];
    const uint64_t faint = w->rays.faint;
    w->shadows.blocks = w->shadows.filled = 0;
    if (!wave_reserve_shadows(w, w->surface_count + LANES)) return false;
    for (size_t b = 0; b * LANES < w->surface_count; ++b) {
        const surface_block *s = &w->surfaces[b];
        material_block materials;
        light_block arriving;
        plan->kernels->material_gather(plan->scene->materials.items, s, &materials);
        plan->kernels->light_evaluate(light, s, &materials, &arriving);
        if (w->lost[0]) wave_spare_faint(w, s, &arriving);
        push_shadows(w, &arriving, b, first);
    }
    close_queue(&w->shadows);
    w->rays.unlit += w->surface_count - w->shadows.count - (w->rays.faint - faint);
    return trace_shadows(w, index, first ? TRACE_COHERENT : TRACE_INCOHERENT);
}

bool wave_light(wave *w, bool first) {
    const render_plan *plan = w->plan;
    for (size_t b = 0; b * LANES < w->surface_count; ++b) {
        material_block materials;
        plan->kernels->material_gather(plan->scene->materials.items, &w->surfaces[b], &materials);
        material_add_constant(&materials, &w->surfaces[b], plan->scene->ambient, w->radiance);
    }
    for (uint32_t i = 0; i < plan->light_count; ++i) {
        if (!add_light(w, i, first)) return false;
    }
    return true;
}
