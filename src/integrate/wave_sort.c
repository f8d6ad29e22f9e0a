/* Hits brought together by geometry. Scattered rays meet now this object, now that one, and some nothing: by
 * themselves few of their blocks could be gathered as a whole. */
#include "integrate/wave.h"

enum { BIN_OTHERS = 62, BIN_MISSED, BINS };

/* Instances and planes are gathered one by one in any order. */
static unsigned bin_of(const trace_hits *hits, size_t i) {
    const uint32_t geometry = hits->geometry[i];
    if (geometry == FATHOM_NONE) return BIN_MISSED;
    return geometry == TRACE_PLANE || hits->instance[i] != FATHOM_NONE ? BIN_OTHERS : geometry % BIN_OTHERS;
}

/* The rows that are read of traced rays. */
static void move(const wave *w, size_t from, size_t to) {
    const trace_block *a = &w->now.rays[from / LANES];
    trace_block *b = &w->next.rays[to / LANES];
    const path_block *p = &w->now.paths[from / LANES];
    path_block *q = &w->next.paths[to / LANES];
    const size_t i = from % LANES, k = to % LANES;
    trace_rays_move(&a->rays, i, &b->rays, k);
    if (w->times) b->rays.time[k] = a->rays.time[i];
    b->hits.geometry[k] = a->hits.geometry[i];
    b->hits.primitive[k] = a->hits.primitive[i];
    b->hits.instance[k] = a->hits.instance[i];
    for (int c = 0; c < 3; ++c) q->weight[c][k] = p->weight[c][i];
    q->slot[k] = p->slot[i];
    q->depth[k] = p->depth[i];
}

bool wave_sort_hits(wave *w) {
    uint8_t bin[WAVE_SLOTS];
    size_t place[BINS + 1] = {0};
    const size_t count = w->now.count;
    if (w->run.plan->watertight) return true; /* it reads more of the hits */
    w->next.count = 0;
    if (!wave_reserve_paths(w, &w->next, count)) return false;
    for (size_t k = 0; k < count; ++k) {
        bin[k] = (uint8_t)bin_of(&w->now.rays[k / LANES].hits, k % LANES);
        ++place[bin[k] + 1];
    }
    for (unsigned b = 1; b <= BINS; ++b) place[b] += place[b - 1];
    for (size_t k = 0; k < count; ++k) move(w, k, place[bin[k]]++);
    const path_queue sorted = w->next;
    w->next = w->now;
    w->now = sorted;
    w->now.count = count;
    return true;
}
