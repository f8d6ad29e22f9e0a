#include "integrate/wave/wave.h"

#include <stdlib.h>
#include <string.h>

/* Embree requires its 16-wide structures to be aligned to 64 bytes, which realloc does not preserve. */
static bool grow(void **items, size_t used, size_t bytes) {
    void *grown = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!grown) return false;
    /* Unused lanes are passed as inactive, but vector code still reads them. */
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

/* Two arrays of blocks that grow together. */
typedef struct block_pair {
    void *items[2];
    size_t sizes[2];
} block_pair;

static bool grow_pair(wave *w, block_pair *pair, size_t *capacity, size_t used, size_t need) {
    if (need <= *capacity) return true;
    const size_t room = grown_capacity(*capacity, need), blocks = room / LANES, old = wave_blocks(used);
    for (int k = 0; k < 2; ++k) {
        if (grow(&pair->items[k], old * pair->sizes[k], blocks * pair->sizes[k])) continue;
        w->run.out_of_memory = true;
        return false;
    }
    *capacity = room;
    return true;
}

/* Makes room for `blocks` blocks in an array; the first `used` are kept. */
static bool grow_single(wave *w, void **items, size_t size, size_t used, size_t blocks) {
    if (!grow(items, used * size, blocks * size)) w->run.out_of_memory = true;
    return !w->run.out_of_memory;
}

bool wave_reserve_paths(wave *w, path_queue *queue, size_t count) {
    block_pair pair = {{queue->rays, queue->paths}, {sizeof *queue->rays, sizeof *queue->paths}};
    bool ok = grow_pair(w, &pair, &queue->capacity, queue->count, queue->count + count);
    queue->rays = pair.items[0], queue->paths = pair.items[1];
    return ok;
}

bool wave_reserve_shadows(wave *w, size_t count) {
    shadow_queue *queue = &w->shadows;
    block_pair pair = {{queue->rays, queue->shadows}, {sizeof *queue->rays, sizeof *queue->shadows}};
    const size_t before = queue->capacity;
    bool ok = grow_pair(w, &pair, &queue->capacity, 0, count);
    queue->rays = pair.items[0], queue->shadows = pair.items[1];
    if (!ok || queue->capacity == before) return ok;
    if (wave_walks(w->run.plan)) {
        free(queue->ends);
        queue->ends = malloc(queue->capacity * sizeof *queue->ends);
        w->run.out_of_memory |= !queue->ends;
    }
    if (w->run.samples.layers) {
        free(queue->tags);
        queue->tags = malloc(queue->capacity * sizeof *queue->tags);
        w->run.out_of_memory |= !queue->tags;
    }
    return !w->run.out_of_memory;
}

bool wave_reserve_vertices(wave *w, size_t count) {
    if (w->vertex_count + count <= w->vertex_capacity) return true;
    const size_t room = grown_capacity(w->vertex_capacity, w->vertex_count + count);
    void *items = w->vertices;
    bool ok = grow_single(w, &items, sizeof *w->vertices, wave_blocks(w->vertex_count), room / LANES);
    w->vertices = items;
    items = w->made;
    const bool varies = (w->run.plan->texturing || w->run.plan->nested) && w->run.plan->shaders;
    if (ok && varies)
        ok = grow_single(w, &items, sizeof *w->made, wave_blocks(w->vertex_count), room / LANES);
    w->made = items;
    if (ok) w->vertex_capacity = room;
    return ok;
}

bool wave_reserve_refracted(wave *w, size_t blocks) {
    if (blocks <= w->refracted_capacity) return true;
    const size_t room = grown_capacity(w->refracted_capacity, blocks);
    void *items = w->refracted;
    bool ok = grow_single(w, &items, sizeof *w->refracted, 0, room);
    w->refracted = items;
    if (ok) w->refracted_capacity = room;
    return ok;
}

bool wave_create(const render_plan *plan, const atomic_bool *stop, const wave_stages *stages, wave *out) {
    *out = (wave){.run = {.plan = plan, .stop = stop}, .stages = stages};
    const bool loses = plan->settings.max_loss > 0 || plan->settings.max_relative_loss > 0;
    wave_samples *samples = &out->run.samples;
    float *radiance = calloc((loses ? 6 : 3) * WAVE_SLOTS, sizeof *radiance);
    for (int c = 0; c < 3; ++c) samples->radiance[c] = radiance ? radiance + c * WAVE_SLOTS : NULL;
    for (int c = 0; c < 3; ++c) out->lost[c] = radiance && loses ? radiance + (3 + c) * WAVE_SLOTS : NULL;
    if (plan->parts.hits) samples->first = malloc(sizeof *samples->first);
    if (plan->parts.matte_count) samples->mattes = malloc(plan->parts.matte_count * sizeof *samples->mattes);
    if (plan->parts.layers) samples->layers = malloc(3 * plan->parts.layers * sizeof *samples->layers);
    void *gather = NULL;
    if (grow(&gather, 0, sizeof *out->gather)) out->gather = gather;
    bool ok = radiance && out->gather && (samples->first || !plan->parts.hits) &&
              (samples->layers || !plan->parts.layers) && (samples->mattes || !plan->parts.matte_count) &&
              wave_reserve_paths(out, &out->now, WAVE_SLOTS) &&
              wave_reserve_vertices(out, stages->leave ? LANES : WAVE_SLOTS) &&
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
    free(w->shadows.shadows);
    free(w->shadows.ends);
    free(w->shadows.tags);
    free(w->vertices);
    free(w->made);
    free(w->refracted);
    free(w->gather);
    free(w->times);
    free(w->cameras);
    free(w->run.samples.radiance[0]);
    free(w->run.samples.first);
    free(w->run.samples.layers);
    free(w->run.samples.mattes);
    *w = (wave){.run = {.plan = NULL}};
}

/* Costs only a few instructions for each ray whose result can be right. */
static void repair(wave *w, size_t first, size_t count) {
    if (!w->run.plan->watertight) return;
    for (size_t done = 0; done < count; done += LANES) {
        size_t block = (first + done) / LANES;
        w->run.rays.repaired += watertight_closest(w->run.plan->watertight, &w->now.rays[block],
                                                   w->now.paths[block].depth, wave_lanes(count, done));
    }
}

static void set_times(const wave *w, size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k)
        w->now.rays[k / LANES].rays.time[k % LANES] = w->times[w->now.paths[k / LANES].slot[k % LANES]];
}

bool wave_trace(wave *w, size_t begin, size_t end, trace_coherence coherence) {
    if (w->times) set_times(w, begin, end);
    for (size_t done = begin; done < end; done += trace_piece(w->run.plan->tracer)) {
        if (atomic_load_explicit(w->run.stop, memory_order_relaxed)) return false;
        size_t left = end - done, piece = trace_piece(w->run.plan->tracer);
        if (left < piece) piece = left;
        trace_closest(w->run.plan->tracer, w->now.rays + done / LANES, piece, coherence);
        repair(w, done, piece);
    }
    return true;
}

void wave_begin_samples(wave *w) {
    wave_samples *samples = &w->run.samples;
    memset(samples->radiance[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    if (samples->mattes) memset(samples->mattes, 0, w->run.plan->parts.matte_count * sizeof *samples->mattes);
    if (samples->layers) memset(samples->layers, 0, 3 * w->run.plan->parts.layers * sizeof *samples->layers);
    if (w->run.square_rays) memset(w->run.square_rays, 0, WAVE_SQUARES * sizeof *w->run.square_rays);
}

static void add_layer(wave *w, int layer, uint32_t slot, const float rgb[3]) {
    for (int c = 0; layer >= 0 && c < 3; ++c) w->run.samples.layers[3 * layer + c][slot] += rgb[c];
}

static void add_shares(wave *w, uint32_t slot, vec3_f32 direction, const float rgb[3]) {
    const render_plan *plan = w->run.plan;
    float shares[LIGHT_GROUPS][3];
    emitters_outside_shares(plan->emitters, direction, shares);
    for (uint32_t g = 0; g < plan->groups.count; ++g) {
        for (int c = 0; c < 3; ++c) shares[g][c] *= rgb[c];
        add_layer(w, plan->parts.groups + (int)g, slot, shares[g]);
    }
}

void wave_add_layers(wave *w, uint32_t slot, light_tag tag, vec3_f32 direction, const float rgb[3]) {
    const film_parts *parts = &w->run.plan->parts;
    add_layer(w, parts->kinds[tag.kind], slot, rgb);
    if (parts->groups < 0) return;
    if (tag.group == LIGHT_GROUP_OUTSIDE)
        add_shares(w, slot, direction, rgb);
    else
        add_layer(w, parts->groups + tag.group, slot, rgb);
}

uint8_t wave_hit_group(const wave *w, unsigned i) {
    if (!w->run.plan->groups.count) return 0;
    return light_group_at(&w->run.plan->groups, wave_hit_object(w, i), wave_hit_material(w, i));
}

void wave_keep_mattes(wave *w, uint32_t slot, unsigned i) {
    const render_plan *plan = w->run.plan;
    const int8_t *mattes = plan->parts.mattes;
    if (mattes[MATTE_OBJECT] >= 0)
        w->run.samples.mattes[mattes[MATTE_OBJECT]][slot] = matte_of_object(
            plan->scene, plan->matte_ids[MATTE_OBJECT], wave_hit_object(w, i), wave_hit_instance(w, i));
    if (mattes[MATTE_MATERIAL] >= 0)
        w->run.samples.mattes[mattes[MATTE_MATERIAL]][slot] =
            plan->matte_ids[MATTE_MATERIAL][wave_hit_material(w, i)];
}

void wave_lose_mattes(wave *w, uint32_t slot) {
    for (uint32_t m = 0; m < w->run.plan->parts.matte_count; ++m) w->run.samples.mattes[m][slot] = 0;
}

void wave_count_rays(const wave *w) {
    for (size_t k = 0; w->run.square_rays && k < w->now.count; ++k)
        ++w->run.square_rays[w->now.paths[k / LANES].slot[k % LANES] / LANES];
}
