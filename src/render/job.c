#include "render/job_inner.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/threads.h"
#include "render/watch.h"

#include <stdlib.h>

typedef struct tiles {
    job *job;
    uint32_t first_x, first_y; /* of the grid of tiles, in pixels */
    uint32_t across, down;
} tiles;

static uint32_t minimum(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t maximum(uint32_t a, uint32_t b) { return a > b ? a : b; }

static uint64_t total(const ray_counts *rays) {
    return rays->camera + rays->shadow + rays->reflection + rays->refraction;
}

void job_count_rays(job *j, const wave *w, const ray_counts *before) {
    atomic_fetch_add_explicit(&j->rays_done, total(&w->rays) - total(before), memory_order_relaxed);
}

void job_stop(job *j, const wave *w) {
    if (w->out_of_memory) atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
}

/* ---- the same samples for every pixel ---- */

typedef struct even {
    job *job;
    worker *self;
    const wave_region *region;
    wave_batch batch;
} even;

static bool is_inside(const wave_region *r, uint32_t x, uint32_t y) {
    return x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1;
}

/* Slots outside the region hold no radiance. */
static void add_square(const even *e, uint32_t place) {
    const wave *w = &e->self->wave;
    const wave_square *from = &e->batch.squares[place];
    pixel_sums *sums = e->self->sums;
    uint32_t to = wave_slot(from->left - e->region->left, from->top - e->region->top);
    for (int c = 0; c < 3; ++c)
        w->plan->blocks->add_samples(w->radiance[c] + place * LANES, LANES, sums->rgb[c] + to);
    for (uint32_t k = 0; sums->hits && k < LANES; ++k) {
        uint32_t x = from->left + k % 4, y = from->top + k / 4;
        if (is_inside(e->region, x, y))
            pixel_sums_add_hit(sums, w, place * LANES + k, x, y, to + k, from->index);
    }
}

static bool run_batch(even *e) {
    wave *w = &e->self->wave;
    const ray_counts before = w->rays;
    if (!wave_run_batch(w, e->region, &e->batch)) return false;
    for (uint32_t place = 0; place < e->batch.count; ++place) add_square(e, place);
    job_count_rays(e->job, w, &before);
    e->batch.count = 0;
    return true;
}

/* All samples of as many squares as a batch holds follow each other: in heavy meshes they meet the same boxes
 * and triangles, while the processor's caches hold those. */
static bool take_samples(even *e, const wave_square *squares, uint32_t count) {
    uint32_t spp = e->job->plan->settings.spp, together = spp < WAVE_SQUARES ? WAVE_SQUARES / spp : 1;
    for (uint32_t first = 0; first < count; first += together) {
        uint32_t end = minimum(first + together, count);
        for (uint32_t index = 0; index < spp; ++index) {
            for (uint32_t i = first; i < end; ++i) {
                e->batch.squares[e->batch.count++] = (wave_square){squares[i].left, squares[i].top, index};
                if (e->batch.count == WAVE_SQUARES && !run_batch(e)) return false;
            }
        }
    }
    return !e->batch.count || run_batch(e);
}

static uint64_t region_pixels(const wave_region *r) { return (uint64_t)(r->x1 - r->x0) * (r->y1 - r->y0); }

static bool render_evenly(job *j, worker *self, const wave_region *r) {
    even e = {.job = j, .self = self, .region = r};
    wave_square squares[WAVE_SQUARES];
    uint32_t count = 0;
    for (uint32_t y = r->top; y < r->y1; y += 4) {
        for (uint32_t x = r->left; x < r->x1; x += 4) {
            if (x + 4 > r->x0 && y + 4 > r->y0) squares[count++] = (wave_square){x, y, 0};
        }
    }
    pixel_sums_clear(self->sums);
    if (!take_samples(&e, squares, count)) return false;
    uint32_t spp = j->plan->settings.spp;
    pixel_sums_store_all(j->plan, self->sums, r, spp, j->film);
    self->samples += region_pixels(r) * spp;
    return true;
}

/* ---- to an error ---- */

static bool render_to_error(job *j, worker *self, const wave_region *region) {
    const adaptive_goal goal = adaptive_goal_of(j->plan->settings.target_error);
    adaptive_result result;
    adaptive_begin(j->plan, region->left, region->top, self->adaptive);
    do {
        const ray_counts before = self->wave.rays;
        result = adaptive_pass(&self->wave, &goal, NULL, self->adaptive);
        job_count_rays(j, &self->wave, &before);
    } while (result == ADAPTIVE_PASSED);
    if (result != ADAPTIVE_FINISHED) return false;
    self->samples += adaptive_store(self->adaptive, j->film);
    self->error = fmax(self->error, self->adaptive->error);
    return true;
}

/* ---- waves and tiles ---- */

/* All samples of one wave's pixels. They reach the film together or not at all. */
static bool render_wave(job *j, worker *self, const wave_region *region) {
    bool done = self->adaptive ? render_to_error(j, self, region) : render_evenly(j, self, region);
    if (!done) return false;
    atomic_fetch_add_explicit(&j->pixels_done, region_pixels(region), memory_order_relaxed);
    return true;
}

static void render_tile(const tiles *t, worker *self, size_t tile) {
    job *j = t->job;
    const fathom_film *film = j->film;
    uint32_t size = j->plan->settings.tile_size;
    uint32_t left = t->first_x + (uint32_t)(tile % t->across) * size;
    uint32_t top = t->first_y + (uint32_t)(tile / t->across) * size;
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
            if (!render_wave(j, self, &region)) {
                job_stop(j, &self->wave);
                return;
            }
        }
    }
}

static void run_tiles(void *user, size_t begin, size_t end, unsigned index) {
    const tiles *t = user;
    unsigned state = trace_thread_begin();
    for (size_t tile = begin; tile < end; ++tile) {
        worker *self = job_worker(t->job, index);
        if (!self) break;
        render_tile(t, self, tile);
    }
    trace_thread_end(state);
}

static void render_tiles(job *j) {
    const fathom_film *film = j->film;
    uint32_t size = j->plan->settings.tile_size;
    tiles t = {.job = j, .first_x = film->x / size * size, .first_y = film->y / size * size};
    t.across = (film->x + film->width - t.first_x + size - 1) / size;
    t.down = (film->y + film->height - t.first_y + size - 1) / size;
    loop_parallel(j->threads, (size_t)t.across * t.down, 1, run_tiles, &t);
}

/* ---- workers ---- */

static bool make_sums(const job *j, worker *self) {
    if (j->deadline > 0) return true;
    if (j->plan->settings.target_error > 0) {
        self->adaptive = malloc(sizeof *self->adaptive);
        return self->adaptive && adaptive_create(j->plan, self->adaptive);
    }
    self->sums = malloc(sizeof *self->sums);
    return self->sums && pixel_sums_create(j->plan, self->sums);
}

worker *job_worker(job *j, unsigned index) {
    worker *self = &j->workers[index];
    if (atomic_load(&j->stop)) return NULL;
    if (self->ready) return self;
    self->ready = wave_create(j->plan, &j->stop, &self->wave);
    if (self->ready && make_sums(j, self)) return self;
    atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
    return NULL;
}

static void collect(job *j) {
    job_result *to = &j->result;
    for (unsigned i = 0; i < j->threads; ++i) {
        worker *self = &j->workers[i];
        to->rays.camera += self->wave.rays.camera;
        to->rays.shadow += self->wave.rays.shadow;
        to->rays.reflection += self->wave.rays.reflection;
        to->rays.refraction += self->wave.rays.refraction;
        to->rays.repaired += self->wave.rays.repaired;
        to->rays.unlit += self->wave.rays.unlit;
        to->rays.faint += self->wave.rays.faint;
        to->samples += self->samples;
        to->error = fmax(to->error, self->error);
        if (self->ready) wave_destroy(&self->wave);
        if (self->adaptive) adaptive_destroy(self->adaptive);
        if (self->sums) pixel_sums_destroy(self->sums);
        free(self->adaptive);
        free(self->sums);
    }
}

static void run(void *user) {
    job *j = user;
    j->workers = calloc(j->threads, sizeof *j->workers);
    if (j->workers) {
        if (j->deadline > 0)
            timed_run(j);
        else
            render_tiles(j);
        collect(j);
    } else {
        atomic_store(&j->failed, true);
    }
    free(j->workers);
}

/* ---- the whole ---- */

static double fraction_done(const job *j, double now) {
    double deadline = atomic_load(&j->deadline);
    if (deadline > 0) return fmin(fmax((now - j->began) / (deadline - j->began), 0), 1);
    return (double)atomic_load(&j->pixels_done) / ((double)j->film->width * (double)j->film->height);
}

/* Once all is rendered there is nothing left to stop. */
static void report(void *user) {
    job *j = user;
    double seconds = clock_seconds();
    fathom_progress now = {.phase = FATHOM_PHASE_RENDER,
                           .fraction = fraction_done(j, seconds),
                           .rays = atomic_load(&j->rays_done),
                           .seconds = seconds - j->began};
    bool complete = j->deadline > 0 ? atomic_load(&j->complete) : now.fraction >= 1;
    if (!j->progress || j->interrupted || j->progress(j->progress_user, &now) || complete) return;
    j->interrupted = true;
    atomic_store(&j->stop, true);
}

static fathom_status check_memory(fathom_context *context, const job *j) {
    if (!(j->deadline > 0)) return FATHOM_OK;
    size_t bytes = timed_bytes(j->film, j->plan->parts & FATHOM_PART_HITS), room = memory_free();
    if (bytes <= room) return FATHOM_OK;
    return fail(context, FATHOM_OUT_OF_RESOURCES,
                "out of memory: rendering %u x %u pixels to a time takes %.1f GiB, and %.1f GiB are free; "
                "render a smaller image or a crop, or to a target error instead",
                j->film->width, j->film->height, (double)bytes * 0x1p-30, (double)room * 0x1p-30);
}

static fathom_status job_status(fathom_context *context, const job *j) {
    if (atomic_load(&j->failed)) {
        return fail(context, FATHOM_OUT_OF_RESOURCES,
                    "out of memory while rendering; lower the depth limit or the threads");
    }
    if (j->interrupted) return fail(context, FATHOM_INTERRUPTED, "stopped; what was finished is kept");
    if (!(j->sampled < 1)) return FATHOM_OK;
    return fail(context, FATHOM_BAD_USAGE,
                "max time: too short: it ended when %.0f %% of the image had its first sample; give more "
                "time, or render a smaller image",
                floor(100 * j->sampled));
}

fathom_status job_run(fathom_context *context, const render_plan *plan, double deadline,
                      const job_reserve *reserve, fathom_film *film, fathom_progress_fn progress, void *user,
                      job_result *out) {
    job j = {.plan = plan,
             .film = film,
             .threads = fathom_context_threads(context),
             .progress = progress,
             .progress_user = user,
             .began = clock_seconds(),
             .reserve = reserve,
             .sampled = 1,
             .deadline = plan->settings.max_time > 0 ? deadline : 0};
    fathom_status status = check_memory(context, &j);
    if (status != FATHOM_OK) return status;
    static const watch_calls calls = {run, report};
    watch_run(&calls, &j);
    *out = j.result;
    return job_status(context, &j);
}
