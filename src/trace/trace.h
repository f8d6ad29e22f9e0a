/* Closest and any hit over blocks of 16 rays: the interface of every tracer.
 *
 * Coordinates are the world's (see world.h), not the scene's. Rays must not contain a NaN or an infinity
 * (except t_far), and no direction may be zero: Debian's Embree can abort on those. 0 <= t_near. A hit has t
 * in the open interval (t_near, t_far), as the tracer computes it. Our own intersectors report a hit exactly
 * if this t is inside. Embree's t has an error of 8 unit roundoffs divided by the cosine to the normal;
 * within this distance of an end of the interval, it may report or miss a hit. */
#pragma once

#include "math/lanes.h"
#include "scene/world/world.h"
#include "trace/spec.h"

#include <stddef.h>

/* Rays as a structure of arrays, laid out as Embree's RTCRay16. */
typedef struct trace_rays {
    _Alignas(64) float org_x[16];
    float org_y[16], org_z[16], t_near[16];
    float dir_x[16], dir_y[16], dir_z[16];
    float time[16];  /* shutter time in [0, 1]; read only if the world moves, else the tracer may write
                        here */
    float t_far[16]; /* closest: becomes the hit's t; any: becomes -infinity on a hit */
    uint32_t mask[16], id[16], flags[16]; /* the tracer's own; callers need not set them */
} trace_rays;

/* Ray coordinates as rows: x, y, z. */
typedef const float (*trace_rows)[LANES];
static inline trace_rows trace_origins(const trace_rays *rays) {
    return (trace_rows)(const void *)((const char *)rays + offsetof(trace_rays, org_x));
}
static inline trace_rows trace_directions(const trace_rays *rays) {
    return (trace_rows)(const void *)((const char *)rays + offsetof(trace_rays, dir_x));
}

/* Copies the fields of a ray that callers set. */
static inline void trace_rays_move(const trace_rays *from, size_t i, trace_rays *to, size_t k) {
    to->org_x[k] = from->org_x[i], to->org_y[k] = from->org_y[i], to->org_z[k] = from->org_z[i];
    to->dir_x[k] = from->dir_x[i], to->dir_y[k] = from->dir_y[i], to->dir_z[k] = from->dir_z[i];
    to->t_near[k] = from->t_near[i], to->t_far[k] = from->t_far[i];
}

/* Hits, laid out as Embree's RTCHit16. After trace_closest() the ids are the world's. */
typedef struct trace_hits {
    _Alignas(64) float ng_x[16];
    float ng_y[16], ng_z[16], u[16], v[16]; /* as the tracer computed them; the renderer computes its own */
    uint32_t primitive[16];                 /* within the geometry; of a plane: its index */
    uint32_t geometry[16]; /* index into world.geometries, TRACE_PLANE, or FATHOM_NONE: no hit */
    uint32_t instance[16]; /* index into world.instances, or FATHOM_NONE */
    uint32_t reserved[16]; /* Embree 4 writes here */
} trace_hits;

#define TRACE_PLANE (FATHOM_NONE - 1)

typedef struct trace_block {
    trace_rays rays;
    trace_hits hits;
} trace_block;

/* Number of lanes in use in a block, for `count` rays in all. */
static inline unsigned trace_lanes(size_t count, size_t block) {
    size_t left = count - block * LANES;
    return left < LANES ? (unsigned)left : LANES;
}
static inline vec3_f32 trace_org(const trace_rays *r, size_t i) {
    return (vec3_f32){r->org_x[i], r->org_y[i], r->org_z[i]};
}
static inline vec3_f32 trace_dir(const trace_rays *r, size_t i) {
    return (vec3_f32){r->dir_x[i], r->dir_y[i], r->dir_z[i]};
}

/* The hits of a block in the tracer's own precision. */
typedef struct trace_fine {
    double t[16], t_low[16]; /* t + t_low is the hit's t; t_low is 0 except in quadruple precision */
    double u[16], v[16];
} trace_fine;

typedef struct trace_options {
    const trace_spec *spec; /* NULL: use words */
    const char *words;      /* for trace_spec_parse(); NULL: "embree", compact if memory is short */
    unsigned width;         /* rays per Embree call: 1, 4, 8 or 16; 0 means 1. Hits do not depend on it */
    unsigned threads;       /* for building; 0: the context's */
    bool timed;             /* the caller's rays have times; required for a world that moves */
    bool tell_opaque;       /* trace_any() shall tell opaque surfaces from others, if the tracer can */
    uint64_t expected_rays; /* of all kinds; 0: unknown, treated as many */
    trace_quality quality;
    uint64_t memory;  /* bytes for building and for the structure; 0: no limit */
    uint64_t besides; /* bytes of program, meshes and images, for the message about a limit */
    bool (*progress)(void *user, double fraction); /* called while building, from any thread; false stops the
                                                      build; may be NULL */
    void *user;
} trace_options;

typedef struct trace_tracer trace_tracer;

/* Chooses Embree's build quality from the numbers of rays and primitives; 0 rays: unknown, treated as
 * many. */
trace_quality trace_quality_auto(uint64_t expected_rays, const world *w);

/* FATHOM_INTERRUPTED when progress returned false. The world must outlive the tracer. */
fathom_status trace_create(fathom_context *context, const world *w, const trace_options *options,
                           trace_tracer **out);
void trace_destroy(trace_tracer *tracer);

/* Each rendering thread calls this before its first ray: it makes the processor flush denormals to zero, as
 * Embree requires. Returns the state for trace_thread_end(). */
unsigned trace_thread_begin(void);
void trace_thread_end(unsigned state);

/* What the caller knows about the rays of a block. It affects only speed. */
typedef enum trace_coherence {
    TRACE_INCOHERENT, /* nothing */
    TRACE_NEIGHBOURS, /* origins are close together; directions may differ */
    TRACE_COHERENT    /* origins and directions are similar */
} trace_coherence;

/* Traces the first `count` lanes of the blocks, 16 per block; other lanes stay unchanged. The caller sets the
 * rays; hits may be uninitialised. */
void trace_closest(const trace_tracer *tracer, trace_block *blocks, size_t count, trace_coherence coherence);
/* Same, and also sets the lanes that hit in `fine`, one for each block. */
void trace_closest_fine(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                        trace_coherence coherence);
/* Rays that hit anything that casts a shadow get t_far = -infinity, or TRACE_NOT_OPAQUE. */
void trace_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence);
/* If trace_tells_opaque(), trace_any() sets this where it met no surface that stops all light, but others, or
 * does not know. -infinity: some surface stops all light. It also sets `flags` of the rays. */
#define TRACE_NOT_OPAQUE (-1.0f)
enum { TRACE_PASSED_SOME = 1, TRACE_PASSED_ALL = 2 }; /* light passed some surface in part, or as a whole */
bool trace_tells_opaque(const trace_tracer *tracer);
/* How much light passes straight through a point, or through a triangle: of some of its points all or a part,
 * of each none, of each all. */
typedef enum trace_passes { TRACE_PASSES_SOME, TRACE_PASSES_NONE, TRACE_PASSES_ALL } trace_passes;
/* Where light passes. Geometries and instances are the world's; instance: or FATHOM_NONE. */
typedef struct trace_passing {
    /* trace_passes, by geometry and triangle of a mesh; NULL: all are TRACE_PASSES_SOME. */
    const uint8_t *const *triangles;
    /* At the point of a triangle, or of a half quad, with these barycentric coordinates. Thread-safe. */
    trace_passes (*at)(const void *user, uint32_t geometry, uint32_t triangle, uint32_t instance, float u,
                       float v);
    const void *user;
} trace_passing;
/* trace_any() then stops at points that pass no light, and skips those that pass all. Call it before rays are
 * traced, if at all. `triangles` and `user` have to outlive the rays. */
void trace_know_passing(trace_tracer *tracer, const trace_passing *passing);

/* "Embree 3.13.5, AVX-512", "reference": for the statistics. */
const char *trace_name(const trace_tracer *tracer);
/* Number of rays to trace between two checks of a stop flag, a multiple of 16: linear search may take
 * milliseconds per ray. */
size_t trace_piece(const trace_tracer *tracer);
/* The default name of the Embree tracer on this machine. */
void trace_embree_name(char *out, size_t size);
/* The name and all choices that hits depend on: "Embree 3.13.5, AVX-512, triangles, robust, settled". */
void trace_identity(const trace_tracer *tracer, char out[128]);
uint64_t trace_bvh_bytes(const trace_tracer *tracer);
/* Peak memory during the build, and the estimate made before it; 0: unknown. */
uint64_t trace_peak_bytes(const trace_tracer *tracer);
uint64_t trace_foreseen_bytes(const trace_tracer *tracer);
/* The unit roundoff of the arithmetic in which t is computed: 2^-24 for float. */
double trace_unit(const trace_tracer *tracer);
