/* A wave: up to 1024 paths, a sample each, going through the stages together in blocks of 16.
 *
 * The grid of waves is fixed to the image, not to tiles, crops or threads, and every queue keeps the order of
 * its parents: what is added to a pixel, and in which order, depends on nothing else. */
#ifndef RENDER_WAVE_H
#define RENDER_WAVE_H

#include "render/plan.h"
#include "render/surface_point.h"

#include <stdatomic.h>

#define WAVE_SIDE 32
#define WAVE_SLOTS (WAVE_SIDE * WAVE_SIDE)
#define WAVE_SQUARES (WAVE_SLOTS / LANES) /* of 4 × 4 pixels */

/* Rays waiting for their closest hit. */
typedef struct path_queue {
    trace_block *rays;
    path_block *paths;
    size_t count, capacity; /* in rays; capacity is a multiple of 16 */
    size_t mirrored;        /* after the first wave: the first so many, and all others refracted */
} path_queue;

/* Shadow rays, with what their sample gains when nothing is in the way. While it is filled, whole blocks and
 * single rays come in turns: one block is open, wherever it lies. */
typedef struct shadow_queue {
    trace_rays *rays;
    path_block *paths;   /* weight: the gain */
    size_t blocks, open; /* the open one is among them */
    unsigned filled;     /* lanes of the open block; 0: none is open */
    size_t count;        /* of rays, once it is closed: all blocks but the last are full */
    size_t capacity;     /* in rays, a multiple of 16 */
    uint32_t *points;    /* by ray: its place among the surfaces; NULL: no point is lifted off its facet */
} shadow_queue;

/* What the first hit of each slot's sample leaves for the AOVs. */
typedef struct first_hits {
    float z[WAVE_SLOTS], n[3][WAVE_SLOTS], p[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    uint32_t object[WAVE_SLOTS], primitive[WAVE_SLOTS], instance[WAVE_SLOTS];
} first_hits;

typedef struct ray_counts {
    uint64_t camera, shadow, reflection, refraction;
    uint64_t repaired; /* of these: answers put right by trace/watertight/watertight.h */
    uint64_t unlit;    /* shadow rays that nothing was to be gained from */
    uint64_t faint;    /* and too little */
} ray_counts;

typedef struct wave {
    const render_plan *plan;
    const atomic_bool *stop;
    path_queue now, next;
    shadow_queue shadows;
    surface_block *surfaces;
    surface_gather *gather;                 /* hits on their way to the next block of surfaces */
    uint32_t partial[WAVE_SQUARES];         /* blocks of rays of which some met something */
    size_t surface_count, surface_capacity; /* in points */
    bend_block *refracted;                  /* of each block of surfaces; NULL when nothing refracts */
    size_t refracted_capacity;              /* in blocks */
    float *radiance[3];                     /* by slot */
    float *lost[3];                         /* by slot, what was left out; NULL: nothing may be */
    first_hits *first;                      /* NULL when no AOV wants it */
    uint32_t *square_rays; /* [WAVE_SQUARES], of the last batch by place: the camera's, mirrored
                              and refracted; NULL: not counted */
    ray_counts rays;
    bool out_of_memory;
} wave;

/* Room for n more rays or points; false and wave->out_of_memory when there is none. */
bool wave_reserve_paths(wave *w, path_queue *queue, size_t count);
/* In all; what was in the queue is gone. */
bool wave_reserve_shadows(wave *w, size_t count);
bool wave_reserve_surfaces(wave *w, size_t count);
bool wave_reserve_refracted(wave *w, size_t blocks);

/* Rays between two looks at the stop flag, a multiple of 16. Linear search may take milliseconds for each
 * ray. */
static inline size_t wave_trace_piece(const wave *w) {
    return w->plan->settings.tracer == FATHOM_TRACER_EMBREE ? 4096 : LANES;
}

bool wave_create(const render_plan *plan, const atomic_bool *stop, wave *out);
void wave_destroy(wave *w);

/* The pixels of a wave: the part of its 32 × 32 square that is rendered, in image coordinates, half open. */
typedef struct wave_region {
    uint32_t x0, y0, x1, y1;
    uint32_t left, top; /* the square's corner */
} wave_region;

/* The slot of a pixel at (x, y) from the square's corner: by squares of 4 × 4, then by rows. */
static inline uint32_t wave_slot(uint32_t x, uint32_t y) {
    return (y / 4 * (WAVE_SIDE / 4) + x / 4) * LANES + y % 4 * 4 + x % 4;
}

/* One sample of each pixel of a 4 × 4 square, whose corner is a multiple of 4. */
typedef struct wave_square {
    uint32_t left, top, index;
} wave_square;

/* Square s of a region's wave, the squares taken row by row: its pixels have the slots from s * 16 on. */
static inline wave_square wave_square_at(const wave_region *r, uint32_t s, uint32_t index) {
    const uint32_t across = WAVE_SIDE / 4;
    return (wave_square){r->left + s % across * 4, r->top + s / across * 4, index};
}

static inline bool wave_square_is_whole(const wave_region *r, const wave_square *s) {
    return s->left >= r->x0 && s->left + 4 <= r->x1 && s->top >= r->y0 && s->top + 4 <= r->y1;
}

/* The pixels of the square that lie in the region, as bits: pixel (left + k % 4, top + k / 4) is bit k. */
static inline uint32_t wave_square_pixels(const wave_region *r, const wave_square *s) {
    uint32_t bits = 0;
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = s->left + k % 4, y = s->top + k / 4;
        bits |= x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1 ? 1u << k : 0;
    }
    return bits;
}

/* Those squares that hold pixels of the region, row by row, for their first samples; returns how many. */
static inline uint32_t wave_region_squares(const wave_region *r, wave_square out[WAVE_SQUARES]) {
    uint32_t count = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        const wave_square q = wave_square_at(r, s, 0);
        if (q.left < r->x1 && q.left + 4 > r->x0 && q.top < r->y1 && q.top + 4 > r->y0) out[count++] = q;
    }
    return count;
}

/* Squares in any order, also several samples of one: pixel (x, y) of the one at `place` has the slot
 * place * 16 + (y - top) * 4 + x - left. */
typedef struct wave_batch {
    wave_square squares[WAVE_SQUARES];
    uint32_t count;
} wave_batch;

/* Traces the samples of those pixels of the squares that lie in the region, and leaves their radiance, and
 * first hits, by slot. False when it was stopped or ran out of memory: then nothing of it may be used. */
bool wave_run_batch(wave *w, const wave_region *region, const wave_batch *batch);

/* Where in the pixel its sample `index` lies, in [0,1) from the top left. */
void wave_sample_position(const render_plan *plan, uint32_t x, uint32_t y, uint32_t index, double *dx,
                          double *dy);

/* The stages after the camera's: the hits of the rays that wait, their light, and the rays that leave them,
 * which wait next. Until none do; depth counts up from 0. */
bool wave_step(wave *w, uint32_t depth);
/* What is known of the mirrored and of the other rays that wait then. */
trace_coherence wave_coherence(uint32_t depth, bool mirrored);

/* ---- the stages, in order ---- */
bool wave_camera_rays(wave *w, const wave_region *region, const wave_batch *batch);
/* Points of all hits; misses add the background. */
bool wave_surfaces(wave *w, bool first);
/* Ambient and emitted radiance, then each light in turn. */
bool wave_light(wave *w, bool first);
/* Takes from `arriving` what may be lost: light that adds less than the settings allow. Needs w->lost. */
void wave_spare_faint(wave *w, const surface_block *s, light_block *arriving);
/* Looks again at the shadow rays that met something and began above a facet: the facet itself may see the
 * light. See wave_lifted.c. */
void wave_look_from_facets(wave *w, uint32_t light, trace_coherence coherence);
/* Fills wave->next: mirrored rays, then refracted ones. Each kind runs alike by itself, and packets of both
 * would not. */
bool wave_bend(wave *w);

#endif
