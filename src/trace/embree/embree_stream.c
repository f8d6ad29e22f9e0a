/* Blocks by Embree's streams, which version 4 has no more. A stream has no mask, so lanes that are not to be
 * traced get an empty interval, in a copy. */
#include "trace/embree/embree.h"
#include "trace/stretch.h"

#if EMBREE_HAS_STREAMS
#include <string.h>

/* Blocks in one stream: 256 rays. */
#define STREAM 16

typedef struct stream {
    trace_block blocks[STREAM];
    struct RTCRayHit rays[STREAM * LANES];
    int valid[STREAM][LANES];
    stretch scale[STREAM];
} stream;

/* The lanes in use of a block, and an empty ray in all others. */
static void stream_load(const embree_tracer *tracer, stream *s, unsigned b, const trace_rays *from,
                        unsigned lanes, uint32_t mask) {
    trace_rays *rays = &s->blocks[b].rays;
    *rays = *from;
    stretch_rays(rays, lanes, &s->scale[b]);
    tracer->kernels->prepare(tracer, rays, lanes, mask, s->valid[b]);
    for (unsigned i = 0; i < LANES; ++i) {
        if (s->valid[b][i]) continue;
        rays->org_x[i] = rays->org_y[i] = rays->org_z[i] = rays->dir_x[i] = rays->dir_y[i] = 0;
        rays->dir_z[i] = 1, rays->time[i] = 0, rays->mask[i] = 0, rays->id[i] = i, rays->flags[i] = 0;
        rays->t_near[i] = INFINITY, rays->t_far[i] = -INFINITY;
    }
    for (unsigned i = 0; i < LANES; ++i) {
        s->blocks[b].hits.geometry[i] = s->blocks[b].hits.instance[i] = RTC_INVALID_GEOMETRY_ID;
    }
}

static void rays_load(stream *s, unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
        const trace_rays *r = &s->blocks[i / LANES].rays;
        unsigned k = i % LANES;
        s->rays[i] = (struct RTCRayHit){
            .ray = {.org_x = r->org_x[k],
                    .org_y = r->org_y[k],
                    .org_z = r->org_z[k],
                    .tnear = r->t_near[k],
                    .dir_x = r->dir_x[k],
                    .dir_y = r->dir_y[k],
                    .dir_z = r->dir_z[k],
                    .tfar = r->t_far[k],
                    .mask = r->mask[k],
                    .id = r->id[k]},
            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    }
}

static void rays_store(stream *s, unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
        trace_block *to = &s->blocks[i / LANES];
        const struct RTCHit *hit = &s->rays[i].hit;
        unsigned k = i % LANES;
        to->rays.t_far[k] = s->rays[i].ray.tfar;
        to->hits.ng_x[k] = hit->Ng_x, to->hits.ng_y[k] = hit->Ng_y, to->hits.ng_z[k] = hit->Ng_z;
        to->hits.u[k] = hit->u, to->hits.v[k] = hit->v;
        to->hits.primitive[k] = hit->primID, to->hits.geometry[k] = hit->geomID;
        to->hits.instance[k] = hit->instID[0];
    }
}

/* A lane of the copy back to where it came from. */
static void lane_store(const embree_tracer *tracer, const trace_block *from, const stretch *scale,
                       trace_block *to, unsigned i) {
    to->hits.geometry[i] = from->hits.geometry[i];
    if (from->hits.geometry[i] == RTC_INVALID_GEOMETRY_ID) return;
    float t = stretch_back(scale, i, from->rays.t_far[i], to->rays.t_near[i], to->rays.t_far[i]);
    to->rays.t_far[i] = embree_move_inside(t, to->rays.t_near[i], embree_last_inside(to->rays.t_far[i]));
    to->hits.ng_x[i] = from->hits.ng_x[i], to->hits.ng_y[i] = from->hits.ng_y[i],
    to->hits.ng_z[i] = from->hits.ng_z[i];
    to->hits.u[i] = from->hits.u[i], to->hits.v[i] = from->hits.v[i];
    to->hits.primitive[i] = from->hits.primitive[i], to->hits.instance[i] = from->hits.instance[i];
    embree_translate(tracer, &to->hits, i);
}

void embree_stream_closest(const trace_tracer *base, trace_block *blocks, trace_fine *fine, size_t count,
                           trace_coherence coherence) {
    (void)fine;
    const embree_tracer *tracer = (const embree_tracer *)base;
    bool coherent = coherence == TRACE_COHERENT;
    size_t total = (count + LANES - 1) / LANES;
    stream s;
    embree_call call;
    embree_call_begin(&call, 0, NULL);
    call.raw = true;
    for (size_t first = 0; first < total; first += STREAM) {
        unsigned n = total - first < STREAM ? (unsigned)(total - first) : STREAM;
        for (unsigned b = 0; b < n; ++b) {
            stream_load(tracer, &s, b, &blocks[first + b].rays, trace_lanes(count, first + b), EMBREE_SEEN);
        }
        if (tracer->spec.calls == TRACE_CALLS_STREAM_NM) {
            embree_intersect_blocks(tracer->scenes[0], &call.context, coherent, s.blocks, n);
        } else {
            rays_load(&s, n * LANES);
            embree_intersect_rays(tracer->scenes[0], &call.context, coherent, s.rays, n * LANES);
            rays_store(&s, n * LANES);
        }
        for (size_t i = first * LANES; i < count && i < (first + n) * LANES; ++i) {
            size_t b = i / LANES;
            lane_store(tracer, &s.blocks[b - first], &s.scale[b - first], &blocks[b], (unsigned)(i % LANES));
        }
    }
}

static void occluded(const embree_tracer *tracer, stream *s, unsigned n, bool coherent) {
    embree_context context;
    embree_context_init(&context);
    if (tracer->spec.calls == TRACE_CALLS_STREAM_NM) {
        embree_occluded_blocks(tracer->scenes[0], &context, coherent, s->blocks, n);
        return;
    }
    rays_load(s, n * LANES);
    embree_occluded_rays(tracer->scenes[0], &context, coherent, s->rays, n * LANES);
    rays_store(s, n * LANES);
}

/* Streams of coherent rays run the packet kernels too: where those may hang, the rays go as incoherent. */
void embree_stream_any(const trace_tracer *base, trace_rays *blocks, size_t count,
                       trace_coherence coherence) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    bool coherent = coherence == TRACE_COHERENT && !embree_may_hang(tracer);
    size_t total = (count + LANES - 1) / LANES;
    stream s;
    for (size_t first = 0; first < total; first += STREAM) {
        unsigned n = total - first < STREAM ? (unsigned)(total - first) : STREAM;
        for (unsigned b = 0; b < n; ++b) {
            stream_load(tracer, &s, b, &blocks[first + b], trace_lanes(count, first + b), EMBREE_SHADOWS);
        }
        occluded(tracer, &s, n, coherent);
        for (size_t i = first * LANES; i < count && i < (first + n) * LANES; ++i) {
            size_t b = i / LANES, lane = i % LANES;
            bool met = s.valid[b - first][lane] && s.blocks[b - first].rays.t_far[lane] < 0;
            if (met) blocks[b].t_far[lane] = -INFINITY;
        }
    }
}

#endif
