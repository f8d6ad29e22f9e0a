#include "integrate/wave/wave.h"

#include <string.h>

/* ---- the queue ---- */

bool wave_begin_shadows(wave *w, size_t vertices) {
    w->shadows.blocks = w->shadows.filled = 0;
    return wave_reserve_shadows(w, vertices + LANES);
}

static void fill(shadow_block *shadows, const vertex_block *v, const shadow_depths *depths, lanes3 gain) {
    memcpy(shadows->gain, gain, sizeof shadows->gain);
    memcpy(shadows->slot, v->path.slot, sizeof shadows->slot);
    memcpy(shadows->depth, depths->start, sizeof shadows->depth);
    memcpy(shadows->end_depth, depths->end, sizeof shadows->end_depth);
    memcpy(shadows->sized, depths->sized, sizeof shadows->sized);
}

/* The rays are already at the position of the next block. */
static void push_block(shadow_queue *queue, const vertex_block *v, const shadow_depths *depths, lanes3 gain) {
    shadow_block *shadows = &queue->shadows[queue->blocks];
    if (queue->tags) memcpy(queue->tags + queue->blocks * LANES, depths->tag, sizeof depths->tag);
    ++queue->blocks;
    fill(shadows, v, depths, gain);
}

/* Appends lanes for which the open block has room. */
static void push_some(shadow_queue *queue, const integrate_kernels *kernels, const trace_rays *rays,
                      const shadow_block *from, const light_tag *tags, uint32_t lanes) {
    if (!queue->filled) queue->open = queue->blocks++;
    shadow_block *shadows = &queue->shadows[queue->open];
    kernels->append(rays, ROWS_OF_RAYS, lanes, &queue->rays[queue->open], queue->filled);
    kernels->append(from, ROWS_OF_PATHS, lanes, shadows, queue->filled);
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes), lane = queue->filled;
        shadows->depth[lane] = from->depth[i];
        shadows->end_depth[lane] = from->end_depth[i], shadows->sized[lane] = from->sized[i];
        if (queue->tags) queue->tags[queue->open * LANES + lane] = tags[i];
        queue->filled = (lane + 1) % LANES;
    }
}

/* Blocks in which all rays have a gain stay whole: camera rays always, because each has its own sample; other
 * rays only if no block is open, because the order of rays is the order of sums. Rays are made in place at
 * the next free block: a block of vertices adds at most one block of rays. If that block is opened for single
 * rays, its lanes are compacted in order, and no lane moves to a higher position than its own. */
void wave_push_shadows(wave *w, size_t block, const light_block *to, const shadow_depths *depths, lanes3 gain,
                       bool first) {
    const render_plan *plan = w->run.plan;
    shadow_queue *queue = &w->shadows;
    const vertex_block *v = &w->vertices[block];
    trace_rays *rays = &queue->rays[queue->blocks];
    uint32_t lanes = plan->kernels->shadow_rays(to, gain, plan->t_near, rays);
    lanes &= (1u << v->surface.count) - 1;
    if (!lanes) return;
    if (lanes == (1u << LANES) - 1 && (first || !queue->filled)) {
        push_block(queue, v, depths, gain);
        return;
    }
    shadow_block shadows;
    const uint32_t room = lowest_lanes(lanes, LANES - queue->filled);
    fill(&shadows, v, depths, gain);
    push_some(queue, plan->kernels, rays, &shadows, depths->tag, room);
    if (room != lanes) push_some(queue, plan->kernels, rays, &shadows, depths->tag, lanes & ~room);
}

static void swap_tags(light_tag *tags, size_t a, size_t b) {
    light_tag kept[LANES];
    memcpy(kept, tags + a * LANES, sizeof kept);
    memcpy(tags + a * LANES, tags + b * LANES, sizeof kept);
    memcpy(tags + b * LANES, kept, sizeof kept);
}

/* Moves the open block to the end. */
static void close_queue(shadow_queue *queue) {
    queue->count = queue->blocks * LANES;
    if (!queue->filled) return;
    const size_t last = queue->blocks - 1, open = queue->open;
    if (open != last) {
        trace_rays rays = queue->rays[last];
        shadow_block shadows = queue->shadows[last];
        queue->rays[last] = queue->rays[open], queue->shadows[last] = queue->shadows[open];
        queue->rays[open] = rays, queue->shadows[open] = shadows;
        if (queue->tags) swap_tags(queue->tags, last, open);
    }
    queue->count -= LANES - queue->filled;
}

/* ---- tracing ---- */

static void repair(wave *w) {
    const shadow_queue *queue = &w->shadows;
    for (size_t done = 0; done < queue->count; done += LANES) {
        shadow_block *shadows = &queue->shadows[done / LANES];
        w->run.rays.repaired +=
            watertight_any(w->run.plan->watertight, &queue->rays[done / LANES], shadows->depth,
                           shadows->end_depth, wave_lanes(queue->count, done));
    }
}

static void add_seen(wave *w) {
    const shadow_queue *queue = &w->shadows;
    for (size_t done = 0; done < queue->count; done += LANES)
        w->run.plan->kernels->add_seen(&queue->rays[done / LANES], &queue->shadows[done / LANES],
                                       wave_lanes(queue->count, done), w->run.samples.radiance);
}

static void add_seen_layers(wave *w) {
    const shadow_queue *queue = &w->shadows;
    for (size_t k = 0; k < queue->count; ++k) {
        const shadow_block *s = &queue->shadows[k / LANES];
        const size_t i = k % LANES;
        const float gain[3] = {s->gain[0][i], s->gain[1][i], s->gain[2][i]};
        if (queue->rays[k / LANES].t_far[i] < 0) continue;
        wave_add_layers(w, s->slot[i], queue->tags[k], trace_dir(&queue->rays[k / LANES], i), gain);
    }
}

bool wave_cast_shadows(wave *w, trace_coherence coherence) {
    shadow_queue *queue = &w->shadows;
    const size_t piece = trace_piece(w->run.plan->tracer);
    const bool walks = wave_walks(w->run.plan);
    close_queue(queue);
    for (size_t k = 0; w->times && k < queue->count; ++k)
        queue->rays[k / LANES].time[k % LANES] = w->times[queue->shadows[k / LANES].slot[k % LANES]];
    if (walks && !wave_note_ends(w)) return false;
    for (size_t done = 0; done < queue->count; done += piece) {
        if (atomic_load_explicit(w->run.stop, memory_order_relaxed)) return false;
        size_t left = queue->count - done;
        trace_any(w->run.plan->tracer, queue->rays + done / LANES, left < piece ? left : piece, coherence);
    }
    if (w->run.plan->watertight) repair(w);
    w->run.rays.shadow += queue->count;
    if (walks) wave_take_shadows(w);
    add_seen(w);
    if (queue->tags) add_seen_layers(w);
    return !walks || wave_walk_shadows(w);
}
