/* Sorts hits by geometry. Neighbouring scattered rays hit different objects, and some hit nothing. Without
 * sorting, few blocks of hits could be gathered as a whole. */
#include "integrate/wave/wave.h"

#include "math/lane.h"

enum { BIN_OTHERS = 62, BIN_MISSED, BINS };

/* Geometries first, then instances. The bin BIN_OTHERS is for planes and for geometries and instances beyond
 * the number of bins: the gatherer takes these one by one, in any order. */
static uint32_t bin_of(const world *w, uint32_t geometry, uint32_t instance) {
    const uint64_t own = instance == FATHOM_NONE ? geometry : w->geometries.count + (uint64_t)instance;
    const uint32_t bin = own < BIN_OTHERS ? (uint32_t)own : BIN_OTHERS;
    return geometry == FATHOM_NONE ? BIN_MISSED : bin;
}

/* Moves the data that watertight_sides_of() reads. */
static void move_depths(const wave *w, size_t block, uint32_t lanes, size_t to) {
    const uint8_t *from = w->now.paths[block].depth;
    uint8_t *depth = &w->next.paths[to / LANES].depth[to % LANES];
    if (w->run.plan->crosses || wave_looks_through(w))
        w->run.plan->kernels->append(w->now.rays[block].hits.ng_x, ROWS_OF_NORMALS, lanes,
                                     w->next.rays[to / LANES].hits.ng_x, (unsigned)(to % LANES));
    for (; lanes; lanes &= lanes - 1) *depth++ = from[lane_first(lanes)];
}

/* Moves lanes of a block of `now` to the positions from `to` on in one block of `next`. Hits keep only the
 * members that are read later. */
static void move(const wave *w, size_t block, uint32_t lanes, size_t to) {
    const integrate_kernels *kernels = w->run.plan->kernels;
    const trace_block *a = &w->now.rays[block];
    trace_block *b = &w->next.rays[to / LANES];
    const unsigned at = (unsigned)(to % LANES);
    kernels->append(&a->rays, ROWS_OF_RAYS, lanes, &b->rays, at);
    kernels->append(a->hits.primitive, ROWS_OF_IDS, lanes, b->hits.primitive, at);
    kernels->append(&w->now.paths[block], ROWS_OF_PATHS, lanes, &w->next.paths[to / LANES], at);
    if (w->run.plan->watertight) move_depths(w, block, lanes, to);
}

/* Moves lanes of a block that share a bin. */
static void move_all(const wave *w, size_t block, uint32_t lanes, size_t *place) {
    const uint32_t room = lowest_lanes(lanes, (unsigned)(LANES - *place % LANES));
    move(w, block, room, *place);
    *place += (unsigned)__builtin_popcount(room);
    if (room == lanes) return;
    move(w, block, lanes & ~room, *place);
    *place += (unsigned)__builtin_popcount(lanes & ~room);
}

static void move_block(const wave *w, size_t block, const uint32_t bin[LANES], uint32_t lanes,
                       size_t *place) {
    while (lanes) {
        const uint32_t one = bin[__builtin_ctz(lanes)];
        const uint32_t mine = lanes & w->run.plan->kernels->alike(bin, one);
        move_all(w, block, mine, &place[one]);
        lanes &= ~mine;
    }
}

bool wave_sort_hits(wave *w) {
    uint32_t bin[WAVE_SLOTS];
    size_t place[BINS + 1] = {0};
    const size_t count = w->now.count;
    w->next.count = 0;
    if (!wave_reserve_paths(w, &w->next, count)) return false;
    for (size_t k = 0; k < count; ++k) {
        const trace_hits *hits = &w->now.rays[k / LANES].hits;
        bin[k] = bin_of(w->run.plan->world, hits->geometry[k % LANES], hits->instance[k % LANES]);
        ++place[bin[k] + 1];
    }
    for (unsigned b = 1; b <= BINS; ++b) place[b] += place[b - 1];
    for (size_t done = 0; done < count; done += LANES)
        move_block(w, done / LANES, bin + done, (1u << wave_lanes(count, done)) - 1, place);
    const path_queue sorted = w->next;
    w->next = w->now;
    w->now = sorted;
    w->now.count = count;
    return true;
}
