/* A wave: up to 1024 paths, one per sample, that go through the stages together in blocks of 16. Queues and
 * stages that integrators share.
 *
 * Every queue keeps the order of its parents. The contributions to a sample, and the order of their sum,
 * depend on nothing else. */
#pragma once

#include "integrate/integrator.h"
#include "surface/gather.h"

/* Rays waiting for their closest hit. */
typedef struct path_queue {
    trace_block *rays;
    path_block *paths;
    size_t count, capacity; /* in rays; capacity is a multiple of 16 */
    size_t mirrored; /* after the first wave: this many rays, at the front, are mirrored; all others are
                        refracted */
} path_queue;

/* Sixteen path vertices: surface points, their BSDFs, and what the paths carry. */
typedef struct vertex_block {
    surface_block surface;
    union { /* depends on the integrator */
        bsdf_block bsdf;
        shader_block shader;
    };
    path_block path;             /* arriving paths; depth: on the viewer's side */
    uint8_t depth_behind[LANES]; /* depth on the other side; depths are set if trace/watertight is in use */
    uint8_t group[LANES];        /* light groups of the surfaces; set by the classic integrator for AOVs */
} vertex_block;

/* The layers to which light is added in addition to its sample: see film_parts. */
typedef struct light_tag {
    uint8_t kind;  /* light_kind */
    uint8_t group; /* of light_groups; LIGHT_GROUP_OUTSIDE */
} light_tag;

/* Length of a shadow ray, and whether other rays can hit its light. */
typedef struct shadow_end {
    float length;
    bool sized;
    light_tag tag;
} shadow_end;

/* Queue of shadow rays. While it is filled, whole blocks and single rays alternate: single rays go to the
 * open block, which can be anywhere in the queue. */
typedef struct shadow_queue {
    trace_rays *rays;
    shadow_block *shadows;
    size_t blocks, open; /* blocks includes the open block */
    unsigned filled;     /* used lanes of the open block; 0: no block is open */
    size_t count;        /* number of rays, once the queue is closed: all blocks but the last are full */
    size_t capacity;     /* in rays, a multiple of 16 */
    shadow_end *ends;    /* by ray; NULL: no ray is walked (wave_walk.c) */
    light_tag *tags;     /* by ray; NULL: there are no layers */
} shadow_queue;

/* Number of closed meshes around the two ends of a block's shadow rays (see trace/watertight/watertight.h),
 * whether other rays can hit their lights, and if there are layers, the tags of their light. */
typedef struct shadow_depths {
    uint8_t start[LANES], end[LANES], sized[LANES];
    light_tag tag[LANES];
} shadow_depths;

typedef struct wave wave;

/* What an integrator does with the hits of a wave. */
typedef struct wave_stages {
    /* Called for a block of vertices, complete except for the materials' part; its hits are still in
     * w->gather. */
    void (*vertices)(wave *w, vertex_block *v);
    /* Called for lanes of a block of rays, as bits, that left a scene whose background or environments
     * emit. */
    void (*misses)(wave *w, const trace_block *block, const path_block *path, uint32_t missed);
    /* Makes the rays that leave a block of vertices, after AOVs have read it. The next block then reuses
     * its memory, which is still in the cache. NULL: all blocks are kept. */
    void (*leave)(wave *w, vertex_block *v);
    /* Whether the ray in this slot left the camera and has since only passed surfaces by their opacity, or
     * backs of one-sided surfaces. Asked only while `passing`. */
    bool (*in_view)(const wave *w, uint32_t slot);
} wave_stages;

struct wave {
    integration run; /* must be first: the integrator's interface points to it */
    const wave_stages *stages;
    path_queue now, next;
    shadow_queue shadows;
    vertex_block *vertices;               /* with stages->leave, only the latest block */
    surface_gather *gather;               /* hits for the next block of vertices */
    uint32_t partial[WAVE_SQUARES];       /* blocks of rays of which only some have hits */
    size_t vertex_count, vertex_capacity; /* in points */
    scatter_block *refracted;             /* for each block of vertices; NULL if nothing refracts */
    size_t refracted_capacity;            /* in blocks */
    shader (*made)[LANES]; /* by block of vertices, if materials vary over surfaces; else NULL */
    float *times;          /* by slot, time of the shutter; NULL: nothing moves */
    shade_camera *cameras; /* for motion vectors; NULL: not requested, or nothing moves */
    float *lost[3];        /* by slot, the light that was skipped; NULL: skipping is not allowed */
    uint32_t bounces;      /* for the classic integrator: bounces of the rays of `now` */
    /* For path tracing: rays of `now` may pass surfaces straight, or their paths have done so and may have
     * scattered less often than others. Without it only the camera's own rays are in view. */
    bool passing;
};

/* The backs of one-sided surfaces may let rays of `now` pass. */
static inline bool wave_looks_through(const wave *w) { return w->run.plan->one_sided && w->passing; }

bool wave_create(const render_plan *plan, const atomic_bool *stop, const wave_stages *stages, wave *out);
void wave_destroy(wave *w);

/* Makes room for `count` more rays or points; false, and run.out_of_memory is set, if out of memory. */
bool wave_reserve_paths(wave *w, path_queue *queue, size_t count);
/* Makes room for `count` rays in all; the queue's contents are lost. */
bool wave_reserve_shadows(wave *w, size_t count);
bool wave_reserve_vertices(wave *w, size_t count);
bool wave_reserve_refracted(wave *w, size_t blocks);

static inline size_t wave_blocks(size_t count) { return (count + LANES - 1) / LANES; }
/* Lanes of the block that begins at `done`, of a queue of `count`. */
static inline unsigned wave_lanes(size_t count, size_t done) {
    return count - done < LANES ? (unsigned)(count - done) : LANES;
}

/* The first `count` of these lanes, as bits. */
static inline uint32_t lowest_lanes(uint32_t lanes, unsigned count) {
    uint32_t others = lanes;
    for (; others && count; --count) others &= others - 1;
    return lanes & ~others;
}

/* ---- the stages, in order ---- */

/* Clears the light of all samples and the counts of rays. */
void wave_begin_samples(wave *w);
/* Fills `now` with the camera rays of a batch. */
bool wave_camera_rays(wave *w, const wave_region *region, const wave_batch *batch);
/* The time of a sample, in [0, 1) of the shutter, and the camera at that time. */
float wave_time_of(const render_plan *plan, sample_key key);
void wave_camera_when(const render_plan *plan, float time, shade_camera *out);
/* The point from which the ray sees, such as on the near plane. */
vec3_f32 wave_start(const trace_rays *rays, size_t i);
/* The camera's rays through a square. */
void wave_square_rays(const render_plan *plan, const wave_square *s, trace_rays *out);
/* Closest hits of the rays [begin, end) of `now`; begin is a multiple of 16. False: stopped. */
bool wave_trace(wave *w, size_t begin, size_t end, trace_coherence coherence);
/* Groups hits by geometry. Only allowed if each sample has one ray, so that its sums do not depend on the
 * order of rays. False: out of memory. */
bool wave_sort_hits(wave *w);
/* Makes vertices of all hits of `now`, and calls the integrator's stages for them and for misses. first:
 * these are camera rays. */
bool wave_surfaces(wave *w, bool first);
/* Empties the queue of shadow rays, and makes room for one ray from each of this many vertices. */
bool wave_begin_shadows(wave *w, size_t vertices);
/* Adds shadow rays from a block of vertices to a light that contributes `gain`. Blocks of vertices must come
 * in order. */
void wave_push_shadows(wave *w, size_t block, const light_block *to, const shadow_depths *depths, lanes3 gain,
                       bool first);
/* Traces the shadow rays, and adds the gains of the unoccluded ones. False: stopped. */
bool wave_cast_shadows(wave *w, trace_coherence coherence);

/* ---- layers: components of the light that AOVs request ---- */

/* The kind of light after this many scatterings. */
static inline light_kind light_kind_of(uint32_t scattered) {
    return scattered > 1 ? LIGHT_INDIRECT : scattered ? LIGHT_DIRECT : LIGHT_EMISSION;
}
/* Only if there are layers: adds to them the same light as to samples.radiance, in the same order. direction:
 * towards the light; used only for light from outside. */
void wave_add_layers(wave *w, uint32_t slot, light_tag tag, vec3_f32 direction, const float rgb[3]);
/* The light group of lane i of the gathered hits; 0 if groups are not requested. */
uint8_t wave_hit_group(const wave *w, unsigned i);
/* Only if mattes are requested: sets the sample's object and material to lane i of the gathered hits, or to
 * nothing. */
void wave_keep_mattes(wave *w, uint32_t slot, unsigned i);
void wave_lose_mattes(wave *w, uint32_t slot);
/* Only if first hits are kept: lane i of a block's gathered hits gives the sample's normal, and its albedo
 * times `tint`. */
void wave_keep_features(wave *w, const vertex_block *v, unsigned i, const float tint[3]);

/* ---- motion vectors ---- */

/* Prepares motion vectors if they are requested and something moves; false: out of memory. */
bool wave_create_vectors(wave *w);
/* Only if prepared: sets the vectors of lane i of a block's gathered hits, and of points at infinity. */
void wave_keep_vectors(wave *w, unsigned i, uint32_t slot);
void wave_keep_far_vectors(wave *w, vec3_f32 direction, uint32_t slot);

/* Some shadow rays are walked; see wave_walk.c. */
static inline bool wave_walks(const render_plan *plan) {
    return plan->covered || plan->unshadowed || plan->to_camera;
}
/* Before tracing: keeps their lengths. False: out of memory. */
bool wave_note_ends(wave *w);
/* After tracing: moves the rays to walk into `now`; in the queue they count as occluded from then on. */
void wave_take_shadows(wave *w);
/* Walks them, and adds the gains of those that reach their light. False: stopped. */
bool wave_walk_shadows(wave *w);
/* The material of lane i of the gathered hits. */
fathom_id wave_hit_material(const wave *w, unsigned i);
/* The object of lane i of the gathered hits. */
fathom_id wave_hit_object(const wave *w, unsigned i);
/* The scene's instance that places it, the innermost of nested ones; FATHOM_NONE for planes, and in the root.
 */
fathom_id wave_hit_instance(const wave *w, unsigned i);

/* Counts rays of `now` by square, if requested. */
void wave_count_rays(const wave *w);
