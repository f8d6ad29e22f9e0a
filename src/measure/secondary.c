#include "measure/secondary.h"

#include "integrate/wave.h"

#include <stdlib.h>
#include <string.h>

const char *secondary_name(secondary_kind kind) {
    static const char *const names[SECONDARY_KINDS] = {"camera", "mirrored", "refracted", "shadow"};
    return names[kind];
}

void secondary_free(secondary_rays *rays) {
    for (int d = 0; d < SECONDARY_DEPTHS; ++d) {
        for (int k = 0; k < SECONDARY_KINDS; ++k) record_free(&rays->of[d][k]);
    }
}

/* ---- from a render ---- */

typedef struct recording {
    const render_plan *plan;
    trace_tracer *recorder;
    wave wave;
    uint64_t enough;
    secondary_rays *out;
} recording;

/* NULL when it has enough. */
static record *wanted(const recording *r, uint32_t depth, secondary_kind kind) {
    if (depth >= SECONDARY_DEPTHS) return NULL;
    record *to = &r->out->of[depth][kind];
    return record_rays(to, kind == SECONDARY_SHADOW ? BARE_ANY : BARE_CLOSEST) < r->enough ? to : NULL;
}

/* Rays [begin, end) of the queue, packed anew. */
static bool keep_part(const recording *r, uint32_t depth, secondary_kind kind, size_t begin, size_t end) {
    record *to = wanted(r, depth, kind);
    if (!to || begin == end) return true;
    size_t blocks = (end - begin + LANES - 1) / LANES;
    trace_rays *rays = aligned_alloc(64, blocks * sizeof *rays);
    if (!rays) return false;
    memset(rays, 0, blocks * sizeof *rays);
    for (size_t i = begin; i < end; ++i) {
        size_t k = i - begin;
        trace_rays_move(&r->wave.now.rays[i / LANES].rays, i % LANES, &rays[k / LANES], k % LANES);
    }
    record_keep(to, BARE_CLOSEST, classic_coherence(depth, kind == SECONDARY_MIRRORED), rays, sizeof *rays,
                end - begin);
    free(rays);
    return !to->out_of_memory;
}

static bool keep_waiting(const recording *r, uint32_t depth) {
    const path_queue *now = &r->wave.now;
    if (depth == 0) return keep_part(r, depth, SECONDARY_CAMERA, 0, now->count);
    return keep_part(r, depth, SECONDARY_MIRRORED, 0, now->mirrored) &&
           keep_part(r, depth, SECONDARY_REFRACTED, now->mirrored, now->count);
}

static bool record_wave(recording *r, const wave_region *region) {
    memset(r->wave.run.samples.radiance[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    wave_batch batch;
    batch.count = wave_list_squares(region, wave_region_bits(region), batch.squares);
    if (!wave_camera_rays(&r->wave, region, &batch)) return false;
    for (uint32_t depth = 0; r->wave.now.count; ++depth) {
        record *shadows = wanted(r, depth, SECONDARY_SHADOW);
        record_redirect(r->recorder, NULL, shadows);
        if (!keep_waiting(r, depth) || !classic_step(&r->wave, depth)) return false;
        if (shadows && shadows->out_of_memory) return false;
    }
    return true;
}

static bool all_enough(const recording *r) {
    for (uint32_t d = 0; d < SECONDARY_DEPTHS; ++d) {
        for (int k = 0; k < SECONDARY_KINDS; ++k) {
            if (wanted(r, d, (secondary_kind)k)) return false;
        }
    }
    return true;
}

/* Steps of a prime that no image has for a factor of its waves, nearly: wave after wave is far away. */
static bool record_waves(recording *r) {
    const fathom_settings *s = &r->plan->settings;
    const wave_grid grid = wave_grid_of(0, 0, s->width, s->height);
    const uint64_t prime = grid.count % 7919 ? 7919 : 1;
    for (uint64_t k = 0; k < grid.count && !all_enough(r); ++k) {
        const wave_region region = wave_grid_region(&grid, (uint32_t)(k * prime % grid.count));
        if (!record_wave(r, &region)) return false;
    }
    return true;
}

fathom_status secondary_record(fathom_context *context, const render_plan *plan, uint64_t enough,
                               secondary_rays *out) {
    static const atomic_bool never = false;
    render_plan recorded = *plan;
    recording r = {.plan = plan, .enough = enough, .out = out};
    memset(out, 0, sizeof *out);
    r.recorder = record_tracer(plan->tracer, NULL);
    recorded.tracer = r.recorder;
    bool ok = r.recorder && wave_create(&recorded, &never, &classic_stages, &r.wave);
    if (ok) {
        unsigned state = trace_thread_begin();
        ok = record_waves(&r);
        trace_thread_end(state);
        wave_destroy(&r.wave);
    }
    trace_destroy(r.recorder);
    if (!ok) secondary_free(out);
    return ok ? FATHOM_OK : fail_memory(context, (size_t)enough * sizeof(trace_rays) / LANES);
}

/* ---- sorted ---- */

typedef struct place {
    uint64_t key;
    size_t index;
} place;

static int by_key(const void *a, const void *b) {
    const place *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Ten bits, two places between each. */
static uint32_t apart(uint32_t v) {
    v = (v | v << 16) & 0x30000ffu;
    v = (v | v << 8) & 0x300f00fu;
    v = (v | v << 4) & 0x30c30c3u;
    return (v | v << 2) & 0x9249249u;
}

typedef struct box {
    float low[3], high[3];
} box;

static float coordinate(const trace_rays *rays, size_t lane, int c) { return trace_origins(rays)[c][lane]; }

static box box_of(const record *r, const record_call *call) {
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < call->rays; ++i) {
        const trace_rays *rays = record_block(r, call->first + i / LANES);
        for (int c = 0; c < 3; ++c) {
            b.low[c] = fminf(b.low[c], coordinate(rays, i % LANES, c));
            b.high[c] = fmaxf(b.high[c], coordinate(rays, i % LANES, c));
        }
    }
    return b;
}

static uint64_t key_of(const trace_rays *rays, size_t k, const box *b) {
    const unsigned x = rays->dir_x[k] < 0, y = rays->dir_y[k] < 0, z = rays->dir_z[k] < 0;
    uint64_t octant = x | y << 1 | z << 2;
    uint32_t morton = 0;
    for (int c = 0; c < 3; ++c) {
        float size = b->high[c] - b->low[c], at = coordinate(rays, k, c) - b->low[c];
        if (size > 0) morton |= apart((uint32_t)(1023 * (at / size))) << c;
    }
    return octant << 30 | morton;
}

static void sort_call(const record *from, const record_call *call, place *places, trace_rays *rays) {
    const box b = box_of(from, call);
    for (size_t i = 0; i < call->rays; ++i) {
        const trace_rays *block = record_block(from, call->first + i / LANES);
        places[i] = (place){key_of(block, i % LANES, &b), i};
    }
    qsort(places, call->rays, sizeof *places, by_key);
    for (size_t i = 0; i < call->rays; ++i) {
        size_t k = places[i].index;
        trace_rays_move(record_block(from, call->first + k / LANES), k % LANES, &rays[i / LANES], i % LANES);
    }
}

bool secondary_sorted(const record *from, record *out) {
    size_t most = 0;
    for (size_t i = 0; i < from->calls.count; ++i) {
        if (from->calls.items[i].rays > most) most = from->calls.items[i].rays;
    }
    size_t blocks = most / LANES + 1;
    place *places = malloc((most + 1) * sizeof *places);
    trace_rays *rays = aligned_alloc(64, blocks * sizeof *rays);
    *out = (record){.blocks = 0};
    if (places && rays) memset(rays, 0, blocks * sizeof *rays);
    for (size_t i = 0; places && rays && i < from->calls.count; ++i) {
        const record_call *call = &from->calls.items[i];
        sort_call(from, call, places, rays);
        record_keep(out, call->query, call->coherence, rays, sizeof *rays, call->rays);
    }
    bool ok = places && rays && !out->out_of_memory;
    free(places);
    free(rays);
    if (!ok) record_free(out);
    return ok;
}

/* ---- timed ---- */

static const struct {
    const char *name;
    unsigned width; /* 0: by trace.h */
    bool coherent, sorted;
} ways[SECONDARY_WAYS] = {[SECONDARY_RENDER] = {"render", 0, false, false},
                          [SECONDARY_SINGLE] = {"single", 1, false, false},
                          [SECONDARY_4] = {"4", 4, false, false},
                          [SECONDARY_8] = {"8", 8, false, false},
                          [SECONDARY_8_COHERENT] = {"8 coherent", 8, true, false},
                          [SECONDARY_16] = {"16", 16, false, false},
                          [SECONDARY_16_COHERENT] = {"16 coherent", 16, true, false},
                          [SECONDARY_RENDER_SORTED] = {"render sorted", 0, false, true},
                          [SECONDARY_SINGLE_SORTED] = {"single sorted", 1, false, true}};

const char *secondary_way_name(secondary_way way) { return ways[way].name; }

typedef struct samples {
    double ns[SECONDARY_WAYS][SECONDARY_REPEATS_MAX], to_single[SECONDARY_REPEATS_MAX];
} samples;

static bool take_turn(const trace_tracer *tracer, const record *rays, int way, replay_result *out) {
    if (!ways[way].width) return replay_traced(rays, tracer, out);
    return replay_bare_as(rays, tracer, ways[way].width, ways[way].coherent, out);
}

/* Ways take turns, each repetition beginning with another one. The render's way and single rays follow one
 * another, so that what changes with the time favours neither. */
static bool measure_row(const trace_tracer *tracer, const record *rays, const record *sorted,
                        unsigned repeats, const bench_watch *watch, samples *s, secondary_row *row) {
    bare_query query = row->kind == SECONDARY_SHADOW ? BARE_ANY : BARE_CLOSEST;
    for (unsigned k = 0; k < repeats; ++k) {
        for (int i = 0; i < SECONDARY_WAYS; ++i) {
            int way = k % 2 ? SECONDARY_WAYS - 1 - i : i;
            replay_result result;
            if (!take_turn(tracer, ways[way].sorted ? sorted : rays, way, &result)) return false;
            s->ns[way][k] = 1e9 * result.cpu_seconds / (double)row->rays;
            if (way == SECONDARY_SINGLE) row->met = result.met[query];
        }
        s->to_single[k] = s->ns[SECONDARY_RENDER][k] / s->ns[SECONDARY_SINGLE][k];
        bench_watch_tell(watch, k + 1, repeats);
    }
    for (int way = 0; way < SECONDARY_WAYS; ++way) row->ns[way] = quartiles_of(s->ns[way], repeats);
    row->to_single = quartiles_of(s->to_single, repeats);
    return true;
}

static uint64_t rays_of(const record *r) { return record_rays(r, BARE_CLOSEST) + record_rays(r, BARE_ANY); }

static uint64_t all_rays(const secondary_rays *rays) {
    uint64_t sum = 0;
    for (uint32_t d = 0; d < SECONDARY_DEPTHS; ++d) {
        for (int k = 0; k < SECONDARY_KINDS; ++k) sum += rays_of(&rays->of[d][k]);
    }
    return sum;
}

fathom_status secondary_measure(fathom_context *context, const trace_tracer *tracer,
                                const secondary_rays *rays, unsigned repeats, const bench_watch *watch,
                                secondary_time *out) {
    const double all = (double)all_rays(rays);
    double done = 0;
    out->count = 0;
    bench_watch_tell(watch, 0, all);
    samples *s = malloc(sizeof *s);
    bool ok = s != NULL;
    for (uint32_t d = 0; d < SECONDARY_DEPTHS; ++d) {
        for (int k = 0; k < SECONDARY_KINDS && ok; ++k) {
            const record *r = &rays->of[d][k];
            uint64_t count = rays_of(r);
            if (!count) continue;
            const bench_watch part = bench_watch_part(watch, done / all, (done + (double)count) / all);
            done += (double)count;
            record sorted;
            secondary_row *row = &out->rows[out->count++];
            *row = (secondary_row){.depth = d, .kind = (secondary_kind)k, .rays = count};
            ok = secondary_sorted(r, &sorted);
            if (!ok) break;
            ok = measure_row(tracer, r, &sorted, repeats, &part, s, row);
            record_free(&sorted);
        }
    }
    free(s);
    return ok ? FATHOM_OK : fail_memory(context, sizeof *s);
}
