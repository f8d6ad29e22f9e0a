/* A wave: up to 1024 paths, a sample each, that go through the stages together in blocks of 16. Queues and
 * stages that integrators share.
 *
 * Every queue keeps the order of its parents: what is added to a sample, and in which order, depends on
 * nothing else. */
#ifndef INTEGRATE_WAVE_H
#define INTEGRATE_WAVE_H

#include "integrate/integrator.h"
#include "surface/gather.h"

/* Rays waiting for their closest hit. */
typedef struct path_queue {
    trace_block *rays;
    path_block *paths;
    size_t count, capacity; /* in rays; capacity is a multiple of 16 */
    size_t mirrored;        /* after the first wave: the first so many are mirrored, all others refracted */
} path_queue;

/* Sixteen vertices of paths: where they are, what the surface does with light, and what the paths carry. */
typedef struct vertex_block {
    surface_block surface;
    union { /* by the integrator */
        bsdf_block bsdf;
        shader_block shader;
    };
    path_block path;             /* arriving; its depth is of the viewer's side */
    uint8_t depth_behind[LANES]; /* of the other side; depths are set where trace/watertight is in use */
} vertex_block;

/* The vertex and the light of a shadow ray. */
typedef struct shadow_source {
    uint32_t vertex, light;
} shadow_source;

/* Where light counts besides in its sample: see film_parts. */
typedef struct light_tag {
    uint8_t kind;  /* light_kind */
    uint8_t group; /* of light_groups; LIGHT_GROUP_OUTSIDE */
} light_tag;

/* How long a shadow ray is, and whether rays can meet its light by chance. */
typedef struct shadow_end {
    float length;
    bool sized;
    light_tag tag;
} shadow_end;

/* Shadow rays. While it is filled, whole blocks and single rays come in turns: one block is open, wherever it
 * lies. */
typedef struct shadow_queue {
    trace_rays *rays;
    shadow_block *shadows;
    size_t blocks, open;    /* the open one is among them */
    unsigned filled;        /* lanes of the open block; 0: none is open */
    size_t count;           /* of rays, once it is closed: all blocks but the last are full */
    size_t capacity;        /* in rays, a multiple of 16 */
    shadow_source *sources; /* by ray; NULL: no vertex is lifted off its facet */
    shadow_end *ends;       /* by ray; NULL: no ray is walked */
    light_tag *tags;        /* by ray; NULL: there are no layers */
} shadow_queue;

/* Closed meshes around the two ends of a block's shadow rays (see trace/watertight/watertight.h), whether
 * rays can meet their lights by chance, and where there are layers the tags of their light. */
typedef struct shadow_depths {
    uint8_t start[LANES], end[LANES], sized[LANES];
    light_tag tag[LANES];
} shadow_depths;

typedef struct wave wave;

/* What an integrator does with what the rays of a wave met. */
typedef struct wave_stages {
    /* A block of vertices, complete but for its materials' part; its hits are still in w->gather. */
    void (*vertices)(wave *w, vertex_block *v);
    /* Lanes of a block of rays, as bits, that left a scene whose surroundings send light. */
    void (*misses)(wave *w, const trace_block *block, const path_block *path, uint32_t missed);
    /* The rays that leave a block of vertices, once AOVs have all of it: the next block takes its place,
     * which is still in the cache. NULL: all blocks stay. */
    void (*leave)(wave *w, vertex_block *v);
    /* Whether the ray in this slot left the camera and has since only passed surfaces by their opacity. Used
     * if the plan is `covered`. */
    bool (*unscattered)(const wave *w, uint32_t slot);
} wave_stages;

struct wave {
    integration run; /* first: the integrator's interface points to it */
    const wave_stages *stages;
    path_queue now, next;
    shadow_queue shadows;
    vertex_block *vertices;               /* with stages->leave only the latest block */
    surface_gather *gather;               /* hits on their way to the next block of vertices */
    uint32_t partial[WAVE_SQUARES];       /* blocks of rays of which some met something */
    size_t vertex_count, vertex_capacity; /* in points */
    scatter_block *refracted;             /* of each block of vertices; NULL when nothing refracts */
    size_t refracted_capacity;            /* in blocks */
    shader (*made)[LANES]; /* by block of vertices, where materials vary over surfaces; else NULL */
    float *times;          /* by slot, of the shutter; NULL: nothing moves */
    shade_camera *cameras; /* for motion vectors; NULL: nobody asks for them, or nothing moves */
    float *lost[3];        /* by slot, what was left out; NULL: nothing may be */
    uint32_t bounces;      /* the classic integrator's: of the rays of `now` */
};

bool wave_create(const render_plan *plan, const atomic_bool *stop, const wave_stages *stages, wave *out);
void wave_destroy(wave *w);

/* Room for n more rays or points; false and run.out_of_memory when there is none. */
bool wave_reserve_paths(wave *w, path_queue *queue, size_t count);
/* Room for n rays in all; the queue's contents are lost. */
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

/* No light in any sample, and no rays counted. */
void wave_begin_samples(wave *w);
/* Fills `now` with the camera's rays of a batch. */
bool wave_camera_rays(wave *w, const wave_region *region, const wave_batch *batch);
/* The time of a sample, in [0, 1) of the shutter, and the camera as it is then. */
float wave_time_of(const render_plan *plan, sample_key key);
void wave_camera_when(const render_plan *plan, float time, shade_camera *out);
/* Closest hits of the rays [begin, end) of `now`; begin is a multiple of 16. False: stopped. */
bool wave_trace(wave *w, size_t begin, size_t end, trace_coherence coherence);
/* Brings hits of one geometry together. Only where each sample has one ray, so that its sums do not depend on
 * their order. False: out of memory. */
bool wave_sort_hits(wave *w);
/* Vertices of all hits of `now`; the integrator's stages see them and the misses. first: of the camera's
 * rays.
 */
bool wave_surfaces(wave *w, bool first);
/* An empty queue of shadow rays, with room for one from each of so many vertices. */
bool wave_begin_shadows(wave *w, size_t vertices);
/* Shadow rays from a block of vertices to a light that gives them `gain`. `light` is its index, where points
 * are lifted off their facets. Each block of vertices must come after those before it. */
void wave_push_shadows(wave *w, size_t block, uint32_t light, const light_block *to,
                       const shadow_depths *depths, lanes3 gain, bool first);
/* Casts them, and adds the gains of those that see their light. False: stopped. */
bool wave_cast_shadows(wave *w, trace_coherence coherence);
/* Looks again at the shadow rays that met something and began above a facet: the facet itself may see the
 * light. See wave_lifted.c. */
void wave_look_from_facets(wave *w, trace_coherence coherence);

/* ---- layers: parts of the light that AOVs ask for ---- */

/* Light that was scattered so often. */
static inline light_kind light_kind_of(uint32_t scattered) {
    return scattered > 1 ? LIGHT_INDIRECT : scattered ? LIGHT_DIRECT : LIGHT_EMISSION;
}
/* Only where there are layers: adds to them what samples.radiance gets, in the same order. direction: towards
 * the light, which matters for light from outside alone. */
void wave_add_layers(wave *w, uint32_t slot, light_tag tag, vec3_f32 direction, const float rgb[3]);
/* The light group of lane i of the gathered hits; 0 where nobody asks for groups. */
uint8_t wave_hit_group(const wave *w, unsigned i);
/* Only where mattes are asked for: what the sample shows is lane i of the gathered hits; or nothing. */
void wave_keep_mattes(wave *w, uint32_t slot, unsigned i);
void wave_lose_mattes(wave *w, uint32_t slot);
/* Only where first hits are kept: lane i of a block's gathered hits gives the sample's normal and albedo, the
 * second times `tint`. */
void wave_keep_features(wave *w, const vertex_block *v, unsigned i, const float tint[3]);

/* ---- motion vectors ---- */

/* Prepares them where they are asked for and something moves; false: no memory. */
bool wave_create_vectors(wave *w);
/* Only then: those of lane i of a block's gathered hits, and of what is infinitely far. */
void wave_keep_vectors(wave *w, unsigned i, uint32_t slot);
void wave_keep_far_vectors(wave *w, vec3_f32 direction, uint32_t slot);

/* Shadow rays that are walked; see wave_walk.c. Before they are cast: keeps their lengths. False: no memory.
 */
bool wave_note_ends(wave *w);
/* Afterwards: takes those to walk, which from then on count as blocked, into `now`. */
void wave_take_shadows(wave *w);
/* Adds the gains of those that reach their light. False: stopped. */
bool wave_walk_shadows(wave *w);
/* The material that lane i of the gathered hits met. */
fathom_id wave_hit_material(const wave *w, unsigned i);
/* And the object. */
fathom_id wave_hit_object(const wave *w, unsigned i);

/* Rays of `now` by square, where they are counted. */
void wave_count_rays(const wave *w);

#endif
