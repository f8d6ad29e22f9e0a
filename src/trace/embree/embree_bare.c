#include "trace/embree/embree_bare.h"

#include "trace/embree/embree.h"
#include "trace/stretch.h"

#include <string.h>

bool embree_bare_possible(const trace_tracer *tracer) {
    return tracer->ops->closest == embree_closest && tracer->ops->any == embree_any;
}

static uint32_t *packet_at(bare_block *block, unsigned first) {
    return &block->rows[EMBREE_BARE_ROWS * first];
}

static void split(const trace_rays *rays, bare_block *out) {
    _Static_assert(EMBREE_RAY_ROWS + EMBREE_HIT_ROWS <= EMBREE_BARE_ROWS, "a packet's rows");
    const char *from = (const char *)rays;
    unsigned width = out->width;
    for (unsigned first = 0; first < TRACE_WIDTH; first += width) {
        uint32_t *rows = packet_at(out, first), *hit = rows + EMBREE_RAY_ROWS * width;
        for (unsigned r = 0; r < EMBREE_RAY_ROWS; ++r) {
            memcpy(&rows[r * width], from + (r * TRACE_WIDTH + first) * sizeof(float), width * sizeof(float));
        }
        for (unsigned i = 0; i < width; ++i) {
            hit[EMBREE_ROW_GEOMETRY * width + i] = hit[EMBREE_ROW_INSTANCE * width + i] =
                RTC_INVALID_GEOMETRY_ID;
        }
    }
}

void embree_bare_load_as(const trace_tracer *base, bare_query query, unsigned width, bool coherent,
                         const trace_rays *rays, unsigned lanes, bare_block *out) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    trace_rays ready = *rays;
    stretch scale;
    if (stretch_needed(&ready, lanes)) stretch_rays(&ready, lanes, &scale);
    tracer->kernels->prepare(tracer, &ready, lanes, query == BARE_ANY ? EMBREE_SHADOWS : EMBREE_SEEN,
                             out->valid);
    bool hangs = query == BARE_ANY && coherent && embree_may_hang(tracer);
    out->lanes = lanes;
    out->width = embree_call_width(tracer, hangs && width > 8 ? 8 : width);
    out->coherent = coherent;
    if (out->width < TRACE_WIDTH) {
        split(&ready, out);
        return;
    }
    out->whole.rays = ready;
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) {
        out->whole.hits.geometry[i] = out->whole.hits.instance[i] = RTC_INVALID_GEOMETRY_ID;
    }
}

void embree_bare_load(const trace_tracer *base, bare_query query, trace_coherence coherence,
                      const trace_rays *rays, unsigned lanes, bare_block *out) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    embree_way way = query == BARE_ANY ? embree_way_any(tracer, coherence)
                                       : embree_way_closest(tracer, rays, lanes, coherence);
    embree_bare_load_as(base, query, way.width, way.coherent, rays, lanes, out);
}

static void trace_block_bare(const embree_tracer *tracer, bare_query query, embree_context *context,
                             bare_block *block) {
    RTCScene scene = tracer->scenes[0];
    for (unsigned first = 0; first < block->lanes; first += block->width) {
        if (block->width == 1 && !block->valid[first]) continue;
        uint32_t *packet = packet_at(block, first);
        if (query == BARE_ANY)
            embree_occluded(block->width, &block->valid[first], scene, context, block->coherent, packet);
        else
            embree_intersect(block->width, &block->valid[first], scene, context, block->coherent, NULL,
                             packet);
    }
}

/* User geometry's callbacks take every context for an embree_call. */
void embree_bare_trace(const trace_tracer *base, bare_query query, bare_block *blocks, size_t count) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    embree_call call;
    memset(&call, 0, sizeof call);
    embree_context_init(&call.context);
    call.raw = true;
    for (size_t b = 0; b < count; ++b) {
        trace_block_bare(tracer, query, &call.context, &blocks[b]);
    }
}

unsigned embree_bare_met(bare_query query, const bare_block *block) {
    unsigned met = 0, width = block->width;
    for (unsigned i = 0; i < block->lanes; ++i) {
        const uint32_t *rows = &block->rows[EMBREE_BARE_ROWS * (i - i % width)];
        if (width == TRACE_WIDTH) rows = block->rows;
        float t_far;
        memcpy(&t_far, &rows[EMBREE_ROW_T_FAR * width + i % width], sizeof t_far);
        uint32_t geometry = rows[(EMBREE_RAY_ROWS + EMBREE_ROW_GEOMETRY) * width + i % width];
        bool hit = query == BARE_ANY ? t_far < 0 : geometry != RTC_INVALID_GEOMETRY_ID;
        met += block->valid[i] && hit;
    }
    return met;
}
