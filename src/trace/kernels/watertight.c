#include "trace/watertight/watertight.h"

#include "base/kernel.h"

#define ALWAYS_INLINE inline __attribute__((always_inline))

/* d·n of each lane in the space of the instance; n is the geometric normal. */
static ALWAYS_INLINE void along_in(const float m[3][4], const trace_block *block, float out[LANES]) {
    const trace_rays *r = &block->rays;
    const trace_hits *h = &block->hits;
    for (unsigned i = 0; i < LANES; ++i) {
        float x = m[0][0] * r->dir_x[i] + m[0][1] * r->dir_y[i] + m[0][2] * r->dir_z[i];
        float y = m[1][0] * r->dir_x[i] + m[1][1] * r->dir_y[i] + m[1][2] * r->dir_z[i];
        float z = m[2][0] * r->dir_x[i] + m[2][1] * r->dir_y[i] + m[2][2] * r->dir_z[i];
        out[i] = h->ng_x[i] * x + h->ng_y[i] * y + h->ng_z[i] * z;
    }
}

static ALWAYS_INLINE bool any_back_lanes(const world *w, bool turned, const trace_block *block,
                                         unsigned lanes) {
    const trace_rays *r = &block->rays;
    const trace_hits *h = &block->hits;
    int placed = 0, back = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float along = h->ng_x[i] * r->dir_x[i] + h->ng_y[i] * r->dir_y[i] + h->ng_z[i] * r->dir_z[i];
        int met = h->geometry[i] != FATHOM_NONE, moved = h->instance[i] != FATHOM_NONE;
        placed |= met & moved;
        back |= met & !(moved & turned) & (along > 0);
    }
    if (back || !placed || !turned) return back != 0;
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t instance = h->instance[i];
        if (h->geometry[i] == FATHOM_NONE || instance == FATHOM_NONE) continue;
        if (i && instance == h->instance[i - 1]) continue; /* neighbours usually hit the same instance */
        float along[LANES];
        along_in(w->instances.items[instance].to_object, block, along);
        for (unsigned k = 0; k < LANES; ++k) back |= (h->instance[k] == instance) & (along[k] > 0);
    }
    return back != 0;
}

static bool any_back(const world *w, bool turned, const trace_block *block, unsigned lanes) {
    return lanes == LANES ? any_back_lanes(w, turned, block, LANES) : any_back_lanes(w, turned, block, lanes);
}

const watertight_kernels KERNEL(watertight_kernels) = {.any_back = any_back};
