#include "trace/embree/embree_bare.h"

#include "trace/embree/embree.h"
#include "trace/stretch.h"

#include <string.h>

bool embree_bare_possible(const trace_tracer *tracer) {
    struct RTCBounds bounds;
    if (tracer->ops->closest != embree_closest || tracer->ops->any != embree_any) return false;
    rtcGetSceneBounds(((const embree_tracer *)tracer)->scenes[0], &bounds);
    return bounds.lower_x <= bounds.upper_x;
}

_Static_assert(EMBREE_BARE_ROWS == EMBREE_PACKET_ROWS, "packets as the tracer has them");

void embree_bare_load(const trace_tracer *base, bare_query query, trace_coherence coherence,
                      const trace_rays *rays, unsigned lanes, bare_block *out) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    const embree_way way = query == BARE_ANY ? embree_way_any(tracer, rays, lanes, coherence)
                                             : embree_way_closest(tracer, rays, lanes, coherence);
    trace_block ready = {.rays = *rays};
    stretch scale;
    const float high = tracer->reach.direction;
    if (stretch_needed(&ready.rays, lanes, high)) stretch_rays(&ready.rays, lanes, high, &scale);
    tracer->kernels->prepare(tracer, &ready.rays, lanes, query == BARE_ANY ? EMBREE_SHADOWS : EMBREE_SEEN,
                             out->valid);
    for (unsigned i = 0; i < LANES; ++i)
        ready.hits.geometry[i] = ready.hits.instance[i] = RTC_INVALID_GEOMETRY_ID;
    out->lanes = lanes;
    out->width = way.width;
    out->coherent = way.coherent;
    if (out->width < LANES)
        tracer->kernels->split(&ready.rays, &ready.hits, out->width, (embree_packets *)(void *)out->rows);
    else
        out->whole = ready;
}

static void trace_block_bare(const embree_tracer *tracer, bare_query query, embree_context *context,
                             bare_block *block) {
    RTCScene scene = tracer->scenes[0];
    for (unsigned first = 0; first < block->lanes; first += block->width) {
        if (block->width == 1 && !block->valid[first]) continue;
        uint32_t *packet = &block->rows[EMBREE_BARE_ROWS * first];
        if (query == BARE_ANY)
            embree_occluded(block->width, &block->valid[first], scene, context, block->coherent, packet);
        else
            embree_intersect(block->width, &block->valid[first], scene, context, block->coherent, NULL,
                             packet);
    }
}

/* The context must be an embree_call, because the callbacks of user geometry expect one. */
void embree_bare_trace(const trace_tracer *base, bare_query query, bare_block *blocks, size_t count) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    embree_call call;
    memset(&call, 0, sizeof call);
    embree_context_init(&call.context);
    call.raw = true;
    for (size_t b = 0; b < count; ++b) trace_block_bare(tracer, query, &call.context, &blocks[b]);
}

unsigned embree_bare_met(bare_query query, const bare_block *block) {
    unsigned met = 0, width = block->width;
    for (unsigned i = 0; i < block->lanes; ++i) {
        const uint32_t *rows = &block->rows[EMBREE_BARE_ROWS * (i - i % width)];
        if (width == LANES) rows = block->rows;
        float t_far;
        memcpy(&t_far, &rows[EMBREE_ROW_T_FAR * width + i % width], sizeof t_far);
        uint32_t geometry = rows[(EMBREE_RAY_ROWS + EMBREE_ROW_GEOMETRY) * width + i % width];
        bool hit = query == BARE_ANY ? t_far < 0 : geometry != RTC_INVALID_GEOMETRY_ID;
        met += block->valid[i] && hit;
    }
    return met;
}
