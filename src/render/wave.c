#include "render/wave.h"

#include <stdlib.h>
#include <string.h>

/* Embree wants its 16-wide structures aligned to 64 bytes, which realloc does not keep. */
static bool grow(void **items, size_t used, size_t bytes) {
    void *grown = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!grown) return false;
    /* Lanes that no ray fills are handed over as inactive, but are read by vector code all the same. */
    memset(grown, 0, bytes);
    if (used) memcpy(grown, *items, used);
    free(*items);
    *items = grown;
    return true;
}

static size_t grown_capacity(size_t capacity, size_t need) {
    size_t room = capacity + capacity / 2;
    if (room < need) room = need;
    return (room + LANES - 1) / LANES * LANES;
}

static bool grow_blocks(wave *w, void **rays, size_t ray_size, void **paths, size_t *capacity, size_t used,
                        size_t need) {
    if (need <= *capacity) return true;
    size_t room = grown_capacity(*capacity, need), blocks = room / LANES, old = (used + LANES - 1) / LANES;
    if (!grow(rays, old * ray_size, blocks * ray_size) ||
        !grow(paths, old * sizeof(path_block), blocks * sizeof(path_block))) {
        w->out_of_memory = true;
        return false;
    }
    *capacity = room;
    return true;
}

bool wave_reserve_paths(wave *w, path_queue *queue, size_t count) {
    void *rays = queue->rays, *paths = queue->paths;
    bool ok = grow_blocks(w, &rays, sizeof(trace_block), &paths, &queue->capacity, queue->count,
                          queue->count + count);
    queue->rays = rays;
    queue->paths = paths;
    return ok;
}

bool wave_reserve_shadows(wave *w, size_t count) {
    shadow_queue *queue = &w->shadows;
    void *rays = queue->rays, *paths = queue->paths;
    const size_t before = queue->capacity;
    bool ok = grow_blocks(w, &rays, sizeof(trace_rays), &paths, &queue->capacity, 0, count);
    queue->rays = rays;
    queue->paths = paths;
    if (!ok || !w->plan->lifts || queue->capacity == before) return ok;
    free(queue->points);
    queue->points = malloc(queue->capacity * sizeof *queue->points);
    w->out_of_memory = !queue->points;
    return !w->out_of_memory;
}

bool wave_reserve_surfaces(wave *w, size_t count) {
    if (w->surface_count + count <= w->surface_capacity) return true;
    size_t room = grown_capacity(w->surface_capacity, w->surface_count + count);
    size_t used = (w->surface_count + LANES - 1) / LANES * sizeof(surface_block);
    void *surfaces = w->surfaces;
    w->out_of_memory = !grow(&surfaces, used, room / LANES * sizeof(surface_block));
    w->surfaces = surfaces;
    if (!w->out_of_memory) w->surface_capacity = room;
    return !w->out_of_memory;
}

bool wave_reserve_refracted(wave *w, size_t blocks) {
    if (blocks <= w->refracted_capacity) return true;
    void *refracted = w->refracted;
    size_t room = grown_capacity(w->refracted_capacity, blocks);
    w->out_of_memory = !grow(&refracted, 0, room * sizeof *w->refracted);
    w->refracted = refracted;
    if (!w->out_of_memory) w->refracted_capacity = room;
    return !w->out_of_memory;
}

bool wave_create(const render_plan *plan, const atomic_bool *stop, wave *out) {
    *out = (wave){.plan = plan, .stop = stop};
    const bool loses = plan->settings.max_loss > 0 || plan->settings.max_relative_loss > 0;
    float *radiance = calloc((loses ? 6 : 3) * WAVE_SLOTS, sizeof *radiance);
    for (int c = 0; c < 3; ++c) out->radiance[c] = radiance ? radiance + c * WAVE_SLOTS : NULL;
    for (int c = 0; c < 3; ++c) out->lost[c] = radiance && loses ? radiance + (3 + c) * WAVE_SLOTS : NULL;
    const bool hits = plan->first_hits;
    if (hits) out->first = malloc(sizeof *out->first);
    void *gather = NULL;
    if (grow(&gather, 0, sizeof *out->gather)) out->gather = gather;
    bool ok = radiance && out->gather && (out->first || !hits) &&
              wave_reserve_paths(out, &out->now, WAVE_SLOTS) && wave_reserve_surfaces(out, WAVE_SLOTS) &&
              wave_reserve_shadows(out, WAVE_SLOTS);
    if (!ok) wave_destroy(out);
    return ok;
}

void wave_destroy(wave *w) {
    free(w->now.rays);
    free(w->now.paths);
    free(w->next.rays);
    free(w->next.paths);
    free(w->shadows.rays);
    free(w->shadows.paths);
    free(w->shadows.points);
    free(w->surfaces);
    free(w->refracted);
    free(w->gather);
    free(w->radiance[0]);
    free(w->first);
    *w = (wave){.plan = NULL};
}

/* A few instructions for each ray whose answer is possible. */
static void repair(wave *w, size_t first, size_t count) {
    if (!w->plan->watertight) return;
    for (size_t done = 0; done < count; done += LANES) {
        size_t block = (first + done) / LANES, left = count - done;
        w->rays.repaired +=
            watertight_closest(w->plan->watertight, &w->now.rays[block], w->now.paths[block].depth,
                               left < LANES ? (unsigned)left : LANES);
    }
}

/* Rays [begin, end) of those that wait; begin is a multiple of 16. */
static bool trace_part(wave *w, size_t begin, size_t end, trace_coherence coherence) {
    for (size_t done = begin; done < end; done += wave_trace_piece(w)) {
        if (atomic_load_explicit(w->stop, memory_order_relaxed)) return false;
        size_t left = end - done, piece = wave_trace_piece(w);
        if (left < piece) piece = left;
        trace_closest(w->plan->tracer, w->now.rays + done / LANES, piece, coherence);
        repair(w, done, piece);
    }
    return true;
}

static void count_by_square(const wave *w) {
    for (size_t k = 0; w->square_rays && k < w->now.count; ++k)
        ++w->square_rays[w->now.paths[k / LANES].slot[k % LANES] / LANES];
}

/* Mirrored rays of the first hits leave where neighbouring camera rays arrived, and most of them leave the
 * surface for good. Refracted ones cross what they enter, and reach its other side far from one another. */
trace_coherence wave_coherence(uint32_t depth, bool mirrored) {
    if (depth == 0) return TRACE_COHERENT;
    return depth == 1 && mirrored ? TRACE_NEIGHBOURS : TRACE_INCOHERENT;
}

/* A block of both kinds counts as refracted. */
static bool trace_all(wave *w, uint32_t depth) {
    size_t count = w->now.count, mirrored = w->now.mirrored;
    if (depth == 0) mirrored = 0;
    if (mirrored < count) mirrored -= mirrored % LANES;
    return trace_part(w, 0, mirrored, wave_coherence(depth, true)) &&
           trace_part(w, mirrored, count, wave_coherence(depth, false));
}

bool wave_step(wave *w, uint32_t depth) {
    if (!trace_all(w, depth)) return false;
    if (!wave_surfaces(w, depth == 0) || !wave_light(w, depth == 0)) return false;
    w->next.count = 0;
    if (depth < w->plan->max_depth && !wave_bend(w)) return false;
    path_queue spare = w->now;
    w->now = w->next;
    w->next = spare;
    return true;
}

/* Follows the camera's rays that are waiting. */
static bool follow(wave *w) {
    memset(w->radiance[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    if (w->lost[0]) memset(w->lost[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    if (w->square_rays) memset(w->square_rays, 0, WAVE_SQUARES * sizeof *w->square_rays);
    for (uint32_t depth = 0; w->now.count; ++depth) {
        count_by_square(w);
        if (!wave_step(w, depth)) return false;
    }
    return true;
}

bool wave_run_batch(wave *w, const wave_region *region, const wave_batch *batch) {
    return wave_camera_rays(w, region, batch) && follow(w);
}
