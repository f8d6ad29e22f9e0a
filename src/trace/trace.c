#include "trace/trace.h"

#include "reference/reference.h"
#include "trace/tracer.h"

#include <stdio.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#define FLUSH_TO_ZERO 0x8000u
#define DENORMALS_ARE_ZERO 0x0040u

unsigned trace_thread_begin(void) {
    unsigned state = _mm_getcsr();
    _mm_setcsr(state | FLUSH_TO_ZERO | DENORMALS_ARE_ZERO);
    return state;
}
void trace_thread_end(unsigned state) { _mm_setcsr(state); }
#else
unsigned trace_thread_begin(void) { return 0; }
void trace_thread_end(unsigned state) { (void)state; }
#endif

/* ---- infinite planes: they have no bounds, so they are tested outside the tracer's own structure ---- */

/* Computes t of each lane without branches, then again for the few lanes whose signs are not certain. */
static void planes_distances(const world_plane *plane, const trace_rays *rays, unsigned lanes,
                             float t[LANES]) {
    int doubt[LANES], any = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        bool sure;
        t[i] = plane_ratio_f32(plane->point, plane->normal,
                               vec_f32(rays->org_x[i], rays->org_y[i], rays->org_z[i]),
                               vec_f32(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]), &sure);
        doubt[i] = !sure & (i < lanes);
    }
    for (unsigned i = 0; i < LANES; ++i) any |= doubt[i];
    if (!any) return;
    for (unsigned i = 0; i < LANES; ++i) {
        if (!doubt[i]) continue;
        t[i] = plane_wide_f32(plane->point, plane->normal, trace_org(rays, i), trace_dir(rays, i));
    }
}

static void set_hit(trace_block *block, unsigned lane, const world_plane *plane, uint32_t index, float t) {
    block->rays.t_far[lane] = t;
    trace_hits *hits = &block->hits;
    hits->ng_x[lane] = plane->normal.x, hits->ng_y[lane] = plane->normal.y,
    hits->ng_z[lane] = plane->normal.z;
    hits->u[lane] = hits->v[lane] = 0;
    hits->primitive[lane] = index;
    hits->geometry[lane] = TRACE_PLANE;
    hits->instance[lane] = FATHOM_NONE;
}

/* Closest hits of `block`, or any hits of `rays` if block is NULL. On equal t the earlier hit stays: geometry
 * wins over planes, and a plane wins over later ones. */
static void trace_planes(const trace_tracer *tracer, trace_rays *rays, trace_block *block, unsigned lanes) {
    const world *w = tracer->world;
    for (size_t p = 0; p < w->planes.count; ++p) {
        const world_plane *plane = &w->planes.items[p];
        if (!block && plane->flags & FATHOM_CASTS_NO_SHADOW) continue;
        const float end = tracer->tells_opaque && plane->passes ? TRACE_NOT_OPAQUE : -INFINITY;
        float t[LANES];
        planes_distances(plane, rays, lanes, t);
        for (unsigned i = 0; i < lanes; ++i) {
            if (!(t[i] > rays->t_near[i] && t[i] < rays->t_far[i])) continue;
            if (block)
                set_hit(block, i, plane, (uint32_t)p, t[i]);
            else
                rays->t_far[i] = end;
        }
    }
}

static void closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    tracer->ops->closest(tracer, blocks, fine, count, coherence);
    for (size_t b = 0; !tracer->ops->planes && b * LANES < count; ++b)
        trace_planes(tracer, &blocks[b].rays, &blocks[b], trace_lanes(count, b));
}

/* ---- tracers ---- */

/* Tracers without support for motion are refused, so that they do not give wrong images. */
static fathom_status check_motion(fathom_context *context, const world *w, const trace_spec *spec,
                                  const trace_options *options) {
    if (!w->moves) return FATHOM_OK;
    const char *who = NULL;
    switch (spec->kind) {
    case TRACE_LINEAR: break;
    case TRACE_EMBREE: who = spec->shapes == TRACE_SHAPES_USER ? "tracer embree:user" : NULL; break;
    case TRACE_BVH: who = "tracer bvh"; break;
    case TRACE_PLUGIN: who = "a plug-in"; break;
    }
    if (!options->timed) who = "the classic integrator, validation, bench trace and rays of your own";
    if (!who) return FATHOM_OK;
    return fail_field(
        context, FATHOM_BAD_INPUT, "camera.shutter",
        "something moves while it is open, from %g to %g, which %s cannot follow; expected path "
        "tracing by embree or linear, or a shutter that opens and closes at one time",
        w->scene->camera.shutter[0], w->scene->camera.shutter[1], who);
}

static fathom_status create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out) {
    fathom_status status = check_motion(context, w, spec, options);
    if (status != FATHOM_OK) return status;
    switch (spec->kind) {
    case TRACE_LINEAR: return linear_create(context, w, spec, out);
    case TRACE_EMBREE: return embree_create(context, w, spec, options, out);
    case TRACE_BVH: return bvh_create(context, w, spec, options, out);
    case TRACE_PLUGIN: return plugin_create(context, w, spec, options, out);
    }
    return fail(context, FATHOM_BAD_USAGE, "trace_spec: kind: %d; expected a trace_kind", (int)spec->kind);
}

fathom_status trace_create(fathom_context *context, const world *w, const trace_options *options,
                           trace_tracer **out) {
    *out = NULL;
    const char *unknown = isa_unknown();
    if (unknown)
        return fail(context, FATHOM_BAD_USAGE,
                    "$FATHOM_ISA: expected sse2, sse4.2, avx, avx2 or avx512, found \"%.40s\"", unknown);
    if (options->spec) return create(context, w, options->spec, options, out);
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, options->words, &spec);
    if (status != FATHOM_OK) return status;
    if (spec.kind == TRACE_EMBREE && spec.quality == TRACE_QUALITY_AUTO) spec.quality = options->quality;
    return create(context, w, &spec, options, out);
}

void trace_destroy(trace_tracer *tracer) {
    if (tracer) tracer->ops->destroy(tracer);
}

void trace_closest(const trace_tracer *tracer, trace_block *blocks, size_t count, trace_coherence coherence) {
    closest(tracer, blocks, NULL, count, coherence);
}

void trace_closest_fine(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                        trace_coherence coherence) {
    closest(tracer, blocks, fine, count, coherence);
    for (size_t i = 0; i < count; ++i) {
        const trace_block *block = &blocks[i / LANES];
        trace_fine *to = &fine[i / LANES];
        size_t lane = i % LANES;
        bool plane = block->hits.geometry[lane] == TRACE_PLANE;
        if (plane ? tracer->ops->planes : tracer->ops->fine) continue;
        to->t[lane] = (double)block->rays.t_far[lane], to->t_low[lane] = 0;
        to->u[lane] = (double)block->hits.u[lane], to->v[lane] = (double)block->hits.v[lane];
    }
}

void trace_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    tracer->ops->any(tracer, blocks, count, coherence);
    for (size_t b = 0; !tracer->ops->planes && b * LANES < count; ++b)
        trace_planes(tracer, &blocks[b], NULL, trace_lanes(count, b));
}

bool trace_tells_opaque(const trace_tracer *tracer) { return tracer->tells_opaque; }

void trace_know_passing(trace_tracer *tracer, const trace_passing *passing) { tracer->passing = *passing; }

const char *trace_name(const trace_tracer *tracer) { return tracer->name; }
size_t trace_piece(const trace_tracer *tracer) { return tracer->slow ? LANES : 4096; }
void trace_identity(const trace_tracer *tracer, char out[128]) {
    snprintf(out, 128, "%s%s%s", tracer->name, tracer->way[0] ? ", " : "", tracer->way);
}

uint64_t trace_bvh_bytes(const trace_tracer *tracer) { return tracer->bvh_bytes; }
uint64_t trace_peak_bytes(const trace_tracer *tracer) {
    return tracer->peak_bytes > tracer->bvh_bytes ? tracer->peak_bytes : tracer->bvh_bytes;
}
uint64_t trace_foreseen_bytes(const trace_tracer *tracer) { return tracer->foreseen_bytes; }
double trace_unit(const trace_tracer *tracer) { return tracer->unit; }
