#include "render/job.h"

#include "base/clock.h"
#include "base/threads.h"
#include "render/watch.h"

#include <stdlib.h>
#include <string.h>

typedef struct job {
    const render_plan *plan;
    fathom_film *film;
    uint32_t first_x, first_y; /* of the grid of tiles, in pixels */
    uint32_t tiles_x, tiles_y;
    atomic_bool stop, failed;
    _Atomic uint64_t pixels_done, rays_done;
    ray_counts rays;
    fathom_progress_fn progress; /* these, on the calling thread alone */
    void *progress_user;
    double began;
    bool interrupted;
    unsigned threads;
} job;

/* Sums over the samples of a wave's pixels, in double and in the order of the samples. */
typedef struct pixel_sums {
    double rgb[3][WAVE_SLOTS], n[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    double nearest[WAVE_SLOTS]; /* squared distance to the pixel's centre of the sample kept in `centre` */
    first_hits centre;
} pixel_sums;

static uint32_t minimum(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t maximum(uint32_t a, uint32_t b) { return a > b ? a : b; }

static double distance_to_centre(const render_plan *plan, uint32_t x, uint32_t y, uint32_t index) {
    double dx, dy;
    wave_sample_position(plan, x, y, index, &dx, &dy);
    return (dx - 0.5) * (dx - 0.5) + (dy - 0.5) * (dy - 0.5);
}

static void keep_centre(pixel_sums *sums, const first_hits *f, uint32_t slot) {
    sums->centre.z[slot] = f->z[slot];
    for (int c = 0; c < 3; ++c) sums->centre.p[c][slot] = f->p[c][slot];
    sums->centre.object[slot] = f->object[slot];
    sums->centre.primitive[slot] = f->primitive[slot];
    sums->centre.instance[slot] = f->instance[slot];
}

static void add_first_hit(const render_plan *plan, pixel_sums *sums, const first_hits *f, uint32_t x,
                          uint32_t y, uint32_t slot, uint32_t index) {
    sums->alpha[slot] += (double)f->alpha[slot];
    for (int c = 0; c < 3; ++c) {
        sums->n[c][slot] += (double)f->n[c][slot];
        sums->albedo[c][slot] += (double)f->albedo[c][slot];
    }
    double distance = distance_to_centre(plan, x, y, index);
    if (index && distance >= sums->nearest[slot]) return;
    sums->nearest[slot] = distance;
    keep_centre(sums, f, slot);
}

/* What only AOVs need is not touched without them. */
static void clear_sums(const wave *w, pixel_sums *sums) {
    memset(sums, 0, w->first ? sizeof *sums : sizeof sums->rgb);
}

/* Slots outside the region hold no radiance. */
static void add_sample(const wave *w, const wave_region *r, pixel_sums *sums, uint32_t index) {
    for (int c = 0; c < 3; ++c) {
        const float *restrict from = w->radiance[c];
        double *restrict to = sums->rgb[c];
        for (uint32_t slot = 0; slot < WAVE_SLOTS; ++slot) to[slot] += (double)from[slot];
    }
    for (uint32_t y = r->y0; w->first && y < r->y1; ++y) {
        for (uint32_t x = r->x0; x < r->x1; ++x) {
            uint32_t slot = (y - r->top) * WAVE_SIDE + x - r->left;
            add_first_hit(w->plan, sums, w->first, x, y, slot, index);
        }
    }
}

static void store_pixel(fathom_film *film, const pixel_sums *sums, uint32_t slot, size_t pixel,
                        double scale) {
    for (int c = 0; c < 3; ++c) {
        film->rgb[c][pixel] = (float)(sums->rgb[c][slot] * scale);
        if (film->n[c]) film->n[c][pixel] = (float)(sums->n[c][slot] * scale);
        if (film->albedo[c]) film->albedo[c][pixel] = (float)(sums->albedo[c][slot] * scale);
        if (film->p[c]) film->p[c][pixel] = sums->centre.p[c][slot];
    }
    if (film->alpha) film->alpha[pixel] = (float)(sums->alpha[slot] * scale);
    if (film->z) film->z[pixel] = sums->centre.z[slot];
    if (film->object) {
        film->object[pixel] = sums->centre.object[slot];
        film->primitive[pixel] = sums->centre.primitive[slot];
        film->instance[pixel] = sums->centre.instance[slot];
    }
}

static void store(fathom_film *film, const wave_region *r, const pixel_sums *sums, uint32_t spp) {
    for (uint32_t y = r->y0; y < r->y1; ++y) {
        for (uint32_t x = r->x0; x < r->x1; ++x) {
            uint32_t slot = (y - r->top) * WAVE_SIDE + x - r->left;
            store_pixel(film, sums, slot, (size_t)(y - film->y) * film->width + (x - film->x), 1.0 / spp);
        }
    }
}

/* All samples of one wave's pixels. They reach the film together or not at all. */
static bool render_wave(job *j, wave *w, pixel_sums *sums, const wave_region *region) {
    uint32_t spp = j->plan->settings.spp;
    uint64_t pixels = (uint64_t)(region->x1 - region->x0) * (region->y1 - region->y0);
    clear_sums(w, sums);
    for (uint32_t index = 0; index < spp; ++index) {
        const ray_counts before = w->rays;
        if (!wave_run(w, region, index)) return false;
        add_sample(w, region, sums, index);
        atomic_fetch_add_explicit(&j->rays_done,
                                  w->rays.camera + w->rays.shadow + w->rays.reflection + w->rays.refraction -
                                      before.camera - before.shadow - before.reflection - before.refraction,
                                  memory_order_relaxed);
    }
    store(j->film, region, sums, spp);
    atomic_fetch_add_explicit(&j->pixels_done, pixels, memory_order_relaxed);
    return true;
}

static void render_tile(job *j, wave *w, pixel_sums *sums, size_t tile) {
    const fathom_film *film = j->film;
    uint32_t size = j->plan->settings.tile_size;
    uint32_t left = j->first_x + (uint32_t)(tile % j->tiles_x) * size;
    uint32_t top = j->first_y + (uint32_t)(tile / j->tiles_x) * size;
    uint32_t right = film->x + film->width, bottom = film->y + film->height;
    for (uint32_t y = top; y < minimum(top + size, bottom); y += WAVE_SIDE) {
        for (uint32_t x = left; x < minimum(left + size, right); x += WAVE_SIDE) {
            wave_region region = {maximum(x, film->x),
                                  maximum(y, film->y),
                                  minimum(x + WAVE_SIDE, right),
                                  minimum(y + WAVE_SIDE, bottom),
                                  x,
                                  y};
            if (region.x0 >= region.x1 || region.y0 >= region.y1) continue;
            if (!render_wave(j, w, sums, &region)) {
                if (w->out_of_memory) atomic_store(&j->failed, true);
                atomic_store(&j->stop, true);
                return;
            }
        }
    }
}

typedef struct worker {
    wave wave;
    pixel_sums *sums;
    bool ready;
} worker;

typedef struct worker_pool {
    job *job;
    worker *workers;
} worker_pool;

/* A worker's wave is made by the thread that uses it, on its first tile. */
static bool make_ready(job *j, worker *self) {
    if (self->ready) return true;
    self->sums = malloc(sizeof *self->sums);
    self->ready = self->sums && wave_create(j->plan, &j->stop, &self->wave);
    if (!self->ready) {
        atomic_store(&j->failed, true);
        atomic_store(&j->stop, true);
    }
    return self->ready;
}

static void run_tiles(void *user, size_t begin, size_t end, unsigned index) {
    worker_pool *pool = user;
    unsigned state = trace_thread_begin();
    for (size_t tile = begin; tile < end; ++tile) {
        if (atomic_load(&pool->job->stop) || !make_ready(pool->job, &pool->workers[index])) break;
        render_tile(pool->job, &pool->workers[index].wave, pool->workers[index].sums, tile);
    }
    trace_thread_end(state);
}

static void collect(job *j, worker_pool *pool) {
    for (unsigned i = 0; i < j->threads; ++i) {
        worker *self = &pool->workers[i];
        if (self->ready) {
            j->rays.camera += self->wave.rays.camera;
            j->rays.shadow += self->wave.rays.shadow;
            j->rays.reflection += self->wave.rays.reflection;
            j->rays.refraction += self->wave.rays.refraction;
            j->rays.repaired += self->wave.rays.repaired;
            wave_destroy(&self->wave);
        }
        free(self->sums);
    }
}

static void run(void *user) {
    job *j = user;
    worker_pool pool = {j, calloc(j->threads, sizeof *pool.workers)};
    if (pool.workers) {
        loop_parallel(j->threads, (size_t)j->tiles_x * j->tiles_y, 1, run_tiles, &pool);
        collect(j, &pool);
    } else {
        atomic_store(&j->failed, true);
    }
    free(pool.workers);
}

/* Once all is rendered there is nothing left to stop. */
static void report(void *user) {
    job *j = user;
    uint64_t pixels = (uint64_t)j->film->width * j->film->height, done = atomic_load(&j->pixels_done);
    fathom_progress now = {.phase = FATHOM_PHASE_RENDER,
                           .fraction = (double)done / (double)pixels,
                           .rays = atomic_load(&j->rays_done),
                           .seconds = clock_seconds() - j->began};
    if (!j->progress || j->interrupted || j->progress(j->progress_user, &now) || done == pixels) return;
    j->interrupted = true;
    atomic_store(&j->stop, true);
}

fathom_status job_run(fathom_context *context, const render_plan *plan, fathom_film *film,
                      fathom_progress_fn progress, void *user, ray_counts *rays) {
    uint32_t size = plan->settings.tile_size;
    job j = {.plan = plan,
             .film = film,
             .threads = fathom_context_threads(context),
             .progress = progress,
             .progress_user = user,
             .began = clock_seconds()};
    j.first_x = film->x / size * size;
    j.first_y = film->y / size * size;
    j.tiles_x = (film->x + film->width - j.first_x + size - 1) / size;
    j.tiles_y = (film->y + film->height - j.first_y + size - 1) / size;
    static const watch_calls calls = {run, report};
    watch_run(&calls, &j);
    *rays = j.rays;
    if (atomic_load(&j.failed)) {
        return fail(context, FATHOM_OUT_OF_RESOURCES,
                    "out of memory while rendering; lower the depth limit or the threads");
    }
    return !j.interrupted ? FATHOM_OK
                          : fail(context, FATHOM_INTERRUPTED, "stopped; what was finished is kept");
}
