/* Shared by the files of the Embree tracer. */
#pragma once

#include "trace/embree/embree_api.h"
#include "trace/embree/embree_clusters.h"
#include "trace/embree/embree_limits.h"
#include "trace/embree/embree_spheres.h"
#include "trace/tracer.h"

#include <float.h>
#include <stdatomic.h>
#include <string.h>

/* Ray and geometry masks: for camera and mirrored rays, for shadow rays, and for the rays of embree_repair.c,
 * which test only Embree's own triangles. */
#define EMBREE_SEEN 1u
#define EMBREE_SHADOWS 2u
#define EMBREE_MESHES 4u
#define EMBREE_MESH_SHADOWS 8u

typedef struct embree_kernels embree_kernels;

/* A geometry, for the filter of any-hit queries. */
typedef struct embree_passing {
    const struct embree_tracer *tracer; /* NULL: light does not pass it straight */
    uint32_t geometry;
} embree_passing;

typedef struct embree_tracer {
    trace_tracer base;
    const embree_kernels *kernels;
    RTCDevice device;
    RTCScene *scenes; /* one for each group of the world; [0] is the root; NULL if empty or never used */
    uint32_t *halved; /* by the world's geometries, 1: its quads are Embree's triangles; NULL: none are */
    few_spheres *few; /* the root's spheres, kept out of the scene; NULL: they are in it */
    const few_kernels *few_kernels;
    sphere_clusters *clusters; /* by the world's geometries: of the spheres that are in scenes; NULL: none */
    embree_passing *passing;   /* by geometry; NULL: light passes none straight */
    bool *clear;               /* by material, with `passing`: light may pass it straight */
    enum RTCBuildQuality quality;
    unsigned width;            /* rays in one call, no more than the kernels take */
    trace_reach reach;         /* of the rays that Embree may get */
    RTCFilterFunctionN filter; /* NULL: ties are not settled */
    _Atomic int64_t bytes;     /* held by Embree, and by clusters */
    _Atomic int64_t peak;      /* maximum of `bytes` */
    uint64_t most_bytes;       /* limit of `bytes`; 0: none */
    _Atomic int error;         /* the first RTCError that the device reported */
    char error_text[256];      /* its message; written once, by the thread that set error */
    fathom_context *context;   /* while building */
    const trace_options *options;
    trace_spec spec;
    _Atomic double work, work_done; /* primitives to build, and built; read by Embree's threads */
    _Atomic double work_now;        /* of the scene being built */
} embree_tracer;

/* ---- embree_limits.c ---- */

/* Switches to compact structures if the usual ones exceed options->memory and the caller chose none.
 * FATHOM_OUT_OF_RESOURCES if nothing fits. */
fathom_status embree_fit_memory(embree_tracer *tracer);

/* ---- embree_build.c ---- */

/* Fills tracer->scenes. FATHOM_INTERRUPTED when progress returned false. */
fathom_status embree_build(embree_tracer *tracer);

/* True if light may pass the material of a sphere or quad straight. instance: as Embree numbers them. */
bool embree_lets_pass(const embree_passing *p, uint32_t primitive, uint32_t instance);

/* ---- embree_shapes.c ---- */

/* User geometry that calls the hand-written intersectors; NULL when Embree is out of memory. geometry: the
 * world's index. */
RTCGeometry embree_user_geometry(const embree_tracer *tracer, uint32_t geometry);

/* ---- embree_native.c ---- */

/* True if Embree's own intersectors handle the geometry. */
bool embree_is_native(const trace_spec *spec, const world *w, const world_geometry *geometry);
/* True for quads that are traced as triangles, primitives 2 k and 2 k + 1 for quad k: only in robust scenes,
 * because in others rays slip through between the halves. */
bool embree_is_halved(const trace_spec *spec, const world *w, const world_geometry *geometry);

/* Embree's own triangles, of a mesh or of quads; NULL when Embree is out of memory. */
RTCGeometry embree_native_geometry(RTCDevice device, const world *w, const world_geometry *geometry);

/* ---- embree_settle.c: which of several candidates is the closest hit ---- */

/* Candidates within half the window of the best one are compared by the reference intersector
 * (embree_vote.h). */
#define EMBREE_WINDOW (1 + 0x1p-14f)
#define EMBREE_HALF_WINDOW (1 + 0x1p-15f)

/* The state of a closest-hit call behind Embree's own context, by lane of the block (the ray's id). */
typedef struct embree_call {
    embree_context context;         /* first, so that a callback's context is the call */
    _Alignas(64) float best[LANES]; /* nearest t offered so far */
    float far[LANES];               /* t_far of the query */
    int tied[LANES];                /* not 0: the hit is ambiguous; see embree_settle.c */
    struct embree_vote *vote;       /* not NULL: the call settles one tied ray */
    bool raw;                       /* no ties are recorded: the nearest candidate wins, of equals the last */
} embree_call;

/* The filter for triangles in calls of this width. */
RTCFilterFunctionN embree_filter(unsigned width);

/* Offers a candidate of a user geometry at t; `hit` has rows of n numbers. Returns the ray's new t_far. */
float embree_offer(embree_call *call, unsigned lane, const float *hit, unsigned n, float t);

/* In box tests, Embree clamps the magnitude of each direction component to at least 1e-18. */
#define EMBREE_LEAST_DIRECTION 0x1p-58f

/* Traces a tied lane again and decides it. t_far: of the original query. */
void embree_settle(const embree_tracer *tracer, trace_block *block, unsigned lane, float t_far);

/* ---- embree_way.c ---- */

/* How a block is passed to Embree: rays per packet, and whether its kernels for coherent packets are used. */
typedef struct embree_way {
    unsigned width;
    bool coherent;
} embree_way;
embree_way embree_way_closest(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                              trace_coherence coherence);
embree_way embree_way_any(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                          trace_coherence coherence);

/* ---- embree.c ---- */

/* The widest packet, up to `asked`, that Embree's kernels process as a whole. */
unsigned embree_call_width(const embree_tracer *tracer, unsigned asked);

/* ---- embree_trace.c ---- */

/* A block's intervals before the call. */
typedef struct embree_asked {
    _Alignas(64) int valid[LANES]; /* -1: the lane is traced; else 0 */
    float t_near[LANES], t_far[LANES];
} embree_asked;

/* Our intervals are open, Embree's may be closed. So Embree gets the last float below t_far (infinity and
 * non-positive numbers stay). Embree may report a triangle hit at t_near itself; such a t is moved inside, by
 * less than Embree's own error. A ray that starts in a triangle gets t = 0 exactly, which is no hit: so
 * Embree's t_near is at least the smallest normal float, on threads that flush denormals to zero. */
static inline float embree_last_inside(float t_far) {
    uint32_t bits;
    memcpy(&bits, &t_far, sizeof bits);
    bits -= bits - 1 < 0x7f7fffffu;
    memcpy(&t_far, &bits, sizeof bits);
    return t_far;
}
static inline float embree_t_near(float t_near) { return t_near < FLT_MIN ? FLT_MIN : t_near; }
/* `last` is embree_last_inside() of t_far. */
static inline float embree_move_inside(float t, float t_near, float last) {
    uint32_t bits;
    float first = embree_t_near(t_near);
    memcpy(&bits, &first, sizeof bits);
    bits += t_near >= FLT_MIN;
    memcpy(&first, &bits, sizeof first);
    t = t < first ? first : t;
    return t > last ? last : t;
}

/* A block as aligned packets of fewer than 16 rays, one after the other. */
#define EMBREE_PACKET_ROWS 24
typedef struct embree_packets {
    _Alignas(64) uint32_t rows[EMBREE_PACKET_ROWS * LANES];
} embree_packets;
_Static_assert(EMBREE_RAY_ROWS + EMBREE_HIT_ROWS <= EMBREE_PACKET_ROWS, "a packet's rows");
/* The packet whose first ray is the block's lane `first`. */
static inline uint32_t *embree_packet(embree_packets *packets, unsigned first) {
    return &packets->rows[EMBREE_PACKET_ROWS * first];
}

/* Difference between the directions of a block and its first: |Δx| + |Δy| + |Δz| divided by the first's |x| +
 * |y| + |z|. See embree_way.c. */
#define EMBREE_ALIKE 0.05f
#define EMBREE_SIMILAR 0.5f
typedef enum embree_spread {
    EMBREE_SPREAD_ALIKE,   /* all within EMBREE_ALIKE */
    EMBREE_SPREAD_SIMILAR, /* within EMBREE_SIMILAR */
    EMBREE_SPREAD_WIDE
} embree_spread;

/* The work on a block before and after Embree's call; kernels/embree_block.c. */
struct embree_kernels {
    /* Marks the lanes to trace (within Embree's range, with a non-empty interval) and converts their
     * intervals to Embree's. */
    void (*prepare)(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, uint32_t mask,
                    int valid[LANES]);
    /* Same, and prepares the call except its context, vote and raw. False: nothing was done, because
     * stretch.h must scale the directions first. scaled: they are already scaled. */
    bool (*begin_closest)(const embree_tracer *tracer, trace_block *block, unsigned lanes, bool scaled,
                          embree_asked *asked, embree_call *call);
    /* Sets t_far and restores t_near. True when some lanes are tied. */
    bool (*end_closest)(trace_block *block, unsigned lanes, const embree_asked *asked, embree_call *call);
    /* embree_join_half() for all hits of a block. */
    void (*join_halves)(const uint32_t *halved, trace_hits *hits, unsigned lanes);
    bool (*begin_any)(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, bool scaled,
                      embree_asked *asked);
    void (*end_any)(trace_rays *rays, unsigned lanes, const embree_asked *asked);
    embree_spread (*spread)(const trace_rays *rays, unsigned lanes);
    /* split: copies all sixteen lanes to packets of 1, 4 or 8 rays. join: copies t_far and the hits back.
     * hits may be NULL. */
    void (*split)(const trace_rays *rays, const trace_hits *hits, unsigned width, embree_packets *out);
    void (*join)(const embree_packets *from, unsigned width, trace_rays *rays, trace_hits *hits);
};
const embree_kernels *embree_kernels_best(void);
/* Closest hits of a prepared block, in packets of the way's width. */
void embree_closest_packets(const embree_tracer *tracer, trace_block *block, const int *valid, unsigned lanes,
                            const embree_way *way, embree_context *context, RTCFilterFunctionN filter);
/* Converts Embree's ids of an instance and a geometry in the group's scene to the world's ids. */
static inline void embree_world_ids(const world *w, uint32_t group, uint32_t *instance, uint32_t *geometry) {
    if (*instance != RTC_INVALID_GEOMETRY_ID) {
        *instance -= w->groups.items[0].count;
        group = w->instances.items[*instance].group;
    }
    *geometry += w->groups.items[group].first;
}
/* For a hit on a quad that is traced as two triangles: converts primitive, u and v to the quad's, and returns
 * the half, 0 or 1. Other hits stay, and it returns 0. */
static inline uint32_t embree_join_half(const embree_tracer *tracer, uint32_t geometry, uint32_t *primitive,
                                        float *u, float *v) {
    if (!tracer->halved || !tracer->halved[geometry]) return 0;
    const uint32_t half = *primitive & 1;
    if (half) *u = 1 - *u, *v = 1 - *v;
    *primitive /= 2;
    return half;
}
/* A single ray without a hit. */
static inline struct RTCRayHit embree_alone(vec3_f32 org, vec3_f32 dir, float t_near, float t_far,
                                            uint32_t mask) {
    return (struct RTCRayHit){
        .ray = {.org_x = org.x,
                .org_y = org.y,
                .org_z = org.z,
                .tnear = t_near,
                .dir_x = dir.x,
                .dir_y = dir.y,
                .dir_z = dir.z,
                .tfar = t_far,
                .mask = mask},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
}
/* True if packets of 16 coherent shadow rays may make Embree hang. */
bool embree_may_hang(const embree_tracer *tracer);

void embree_closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence);
void embree_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence);

/* ---- embree_spheres.c ---- */

/* Sets tracer->few if the root has few enough spheres and shapes are not `user`. */
fathom_status embree_spheres_choose(embree_tracer *tracer);
/* Tests the spheres after Embree's call. The block's hits already have the world's ids. Needs tracer->few. */
void embree_spheres_closest(const embree_tracer *tracer, trace_block *block, unsigned lanes,
                            const embree_asked *asked);
void embree_spheres_any(const embree_tracer *tracer, trace_rays *rays, unsigned lanes,
                        const embree_asked *asked);

/* ---- embree_repair.c ---- */

/* NULL if Embree does not intersect the triangles itself, or if hits are not settled (TRACE_RAW). */
const trace_retry *embree_retry(const trace_spec *spec);
