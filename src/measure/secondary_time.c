#include "measure/secondary_time.h"

#include "measure/replay.h"

#include <stdlib.h>

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
