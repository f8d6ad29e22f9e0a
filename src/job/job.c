#include "job/job_inner.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/threads.h"
#include "job/preview.h"
#include "job/watch.h"

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

void job_count_rays(job *j, const integration *work, const ray_counts *before) {
    atomic_fetch_add_explicit(&j->rays_done, total(&work->rays) - total(before), memory_order_relaxed);
}

void job_stop(job *j, const integration *work) {
    if (work->out_of_memory) atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
}

/* ---- the same samples for every pixel ---- */

typedef struct even {
    job *job;
    worker *self;
    const wave_region *region;
    uint32_t place; /* for the checkpoint */
    wave_batch batch;
} even;

/* Returns the samples that its pixels are the means of. */
static uint64_t store_square(const even *e, const wave_square *s) {
    const uint32_t spp = e->job->plan->settings.spp;
    pixel_sums_store_square(e->self->sums, e->region, s, spp, e->job->film);
    return (uint64_t)__builtin_popcount(wave_square_pixels(e->region, s)) * spp;
}

/* Squares whose last sample was in the batch are done. */
static void store_finished(const even *e) {
    uint64_t squares = 0, samples = 0;
    for (uint32_t place = 0; place < e->batch.count; ++place) {
        const wave_square *s = &e->batch.squares[place];
        if (s->index + 1 < e->job->plan->settings.spp) continue;
        samples += store_square(e, s);
        squares |= 1ull << wave_slot(s->left - e->region->left, s->top - e->region->top) / LANES;
    }
    e->self->samples += samples;
    checkpoint *saving = e->job->options->saving;
    if (saving && squares) checkpoint_finish(saving, e->place, squares, samples, 0);
}

static bool run_batch(even *e) {
    integration *work = e->self->integration;
    const ray_counts before = work->rays;
    if (!e->job->plan->integrator->run(work, e->region, &e->batch)) return false;
    for (uint32_t place = 0; place < e->batch.count; ++place)
        pixel_sums_add(e->self->sums, &work->samples, e->region, &e->batch, place);
    store_finished(e);
    job_count_rays(e->job, work, &before);
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

static uint32_t leave_out_finished(const wave_region *r, uint64_t finished, wave_square *squares,
                                   uint32_t count) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const wave_square s = squares[i];
        if (!(finished >> wave_slot(s.left - r->left, s.top - r->top) / LANES & 1)) squares[kept++] = s;
    }
    return kept;
}

static bool render_evenly(job *j, worker *self, const wave_region *r, uint32_t place) {
    even e = {.job = j, .self = self, .region = r, .place = place};
    wave_square squares[WAVE_SQUARES];
    uint32_t count = wave_region_squares(r, squares);
    if (j->options->saving)
        count = leave_out_finished(r, checkpoint_finished(j->options->saving, place), squares, count);
    pixel_sums_clear(self->sums);
    return take_samples(&e, squares, count);
}

/* ---- to an error ---- */

/* Between two passes of a wave that takes long: what is lost with it is the pass that is under way. */
static void keep_wave(checkpoint *saving, worker *self, uint32_t place) {
    double now = saving ? clock_seconds() : 0;
    if (!saving || now - self->kept < checkpoint_keep_seconds(saving)) return;
    checkpoint_keep(saving, place, self->adaptive);
    self->kept = now;
}

static void begin_wave(const job *j, worker *self, const wave_region *region, uint32_t place) {
    checkpoint *saving = j->options->saving;
    adaptive_begin(j->plan, region->left, region->top, self->adaptive);
    if (!saving) return;
    checkpoint_resume(saving, place, self->adaptive);
    self->kept = clock_seconds();
}

static bool render_to_error(job *j, worker *self, const wave_region *region, uint32_t place) {
    const adaptive_goal goal = adaptive_goal_of(j->plan->settings.target_error);
    checkpoint *saving = j->options->saving;
    adaptive_result result;
    begin_wave(j, self, region, place);
    do {
        const ray_counts before = self->integration->rays;
        result = adaptive_pass(self->integration, &goal, NULL, self->adaptive);
        job_count_rays(j, self->integration, &before);
        if (result == ADAPTIVE_PASSED) keep_wave(saving, self, place);
    } while (result == ADAPTIVE_PASSED);
    if (result != ADAPTIVE_FINISHED) return false;
    uint64_t samples = adaptive_store(self->adaptive, j->film);
    self->samples += samples;
    self->error = fmax(self->error, self->adaptive->error);
    if (saving) checkpoint_finish_wave(saving, place, samples, self->adaptive->error);
    return true;
}

/* ---- waves and tiles ---- */

static uint64_t region_pixels(const wave_region *r) { return (uint64_t)(r->x1 - r->x0) * (r->y1 - r->y0); }

/* All samples of one wave's pixels. */
static bool render_wave(job *j, worker *self, const wave_region *region) {
    checkpoint *saving = j->options->saving;
    uint32_t place = saving ? checkpoint_wave(saving, region->left, region->top) : 0;
    uint64_t pixels = region_pixels(region), before = saving ? checkpoint_finished_pixels(saving, place) : 0;
    if (before == pixels) return true;
    bool done =
        self->adaptive ? render_to_error(j, self, region, place) : render_evenly(j, self, region, place);
    if (!done) return false;
    atomic_fetch_add_explicit(&j->pixels_done, pixels - before, memory_order_relaxed);
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
                job_stop(j, self->integration);
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
    return self->sums && pixel_sums_create(&j->plan->sampler, j->plan->first_hits, self->sums);
}

worker *job_worker(job *j, unsigned index) {
    worker *self = &j->workers[index];
    if (atomic_load(&j->stop)) return NULL;
    if (self->integration) return self;
    self->integration = j->plan->integrator->create(j->plan, &j->stop);
    if (self->integration && make_sums(j, self)) return self;
    atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
    return NULL;
}

static void add_rays(const ray_counts *from, ray_counts *to) {
    to->camera += from->camera;
    to->shadow += from->shadow;
    to->reflection += from->reflection;
    to->refraction += from->refraction;
    to->repaired += from->repaired;
    to->unlit += from->unlit;
    to->faint += from->faint;
}

static void collect(job *j) {
    job_result *to = &j->result;
    for (unsigned i = 0; i < j->threads; ++i) {
        worker *self = &j->workers[i];
        to->samples += self->samples;
        to->error = fmax(to->error, self->error);
        if (self->integration) add_rays(&self->integration->rays, &to->rays);
        j->plan->integrator->destroy(self->integration);
        if (self->adaptive) adaptive_destroy(self->adaptive);
        if (self->sums) pixel_sums_destroy(self->sums);
        free(self->adaptive);
        free(self->sums);
    }
}

static void show_preview(job *j) {
    const fathom_settings *s = &j->plan->settings;
    if (j->deadline > 0 || s->target_error > 0 || s->spp == 1) return;
    preview_run(j->plan, j->threads, &j->stop, j->options->saving, j->film);
}

static void run(void *user) {
    job *j = user;
    show_preview(j);
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

/* What is finished was, but for the last second, rendered of what the files held before. */
static void watch_files(job *j) {
    if (j->files == FATHOM_OK) j->files = scene_watch_files(j->plan->scene, &j->next_look);
    if (j->files != FATHOM_OK) atomic_store(&j->stop, true);
}

/* Once all is rendered there is nothing left to stop. */
static void report(void *user) {
    job *j = user;
    double seconds = clock_seconds();
    fathom_progress now = {.phase = FATHOM_PHASE_RENDER,
                           .fraction = fraction_done(j, seconds),
                           .rays = j->rays_before + atomic_load(&j->rays_done),
                           .seconds = seconds - j->began};
    bool complete = j->deadline > 0 ? atomic_load(&j->complete) : now.fraction >= 1;
    const job_options *o = j->options;
    if (!complete && !j->interrupted) watch_files(j);
    if (o->saving && j->files == FATHOM_OK && !complete && !j->interrupted)
        checkpoint_tick(o->saving, now.fraction, atomic_load(&j->rays_done));
    if (!o->progress || j->interrupted || o->progress(o->user, &now) || complete) return;
    j->interrupted = true;
    atomic_store(&j->stop, true);
}

static fathom_status check_memory(fathom_context *context, const job *j) {
    if (!(j->deadline > 0)) return FATHOM_OK;
    size_t bytes = timed_bytes(j), room = memory_free();
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
    if (j->files != FATHOM_OK) return j->files;
    if (j->interrupted) return fail(context, FATHOM_INTERRUPTED, "stopped; what was finished is kept");
    if (!(j->sampled < 1)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, "max time",
                      "too short: it ended when %.0f %% of the image had its first sample; give more "
                      "time, or render a smaller image",
                      floor(100 * j->sampled));
}

/* The film holds what is finished already, and its samples are counted with it. */
static void continue_before(job *j) {
    if (!j->options->saving) return;
    const checkpoint_past before = checkpoint_before(j->options->saving);
    j->began -= before.seconds;
    j->rays_before = before.rays;
    atomic_store(&j->pixels_done, before.pixels);
    j->result.samples = before.samples;
    j->result.error = before.error;
}

fathom_status job_run(fathom_context *context, const render_plan *plan, const job_options *options,
                      fathom_film *film, job_result *out) {
    static const job_options none = {.deadline = 0};
    job j = {.plan = plan,
             .film = film,
             .threads = fathom_context_threads(context),
             .options = options ? options : &none,
             .began = clock_seconds(),
             .sampled = 1};
    j.deadline = plan->settings.max_time > 0 ? j.options->deadline : 0;
    fathom_status status = check_memory(context, &j);
    if (status != FATHOM_OK) return status;
    continue_before(&j);
    static const watch_calls calls = {run, report};
    watch_run(&calls, &j);
    if (j.options->saving) {
        checkpoint_end(j.options->saving, j.interrupted && j.files == FATHOM_OK,
                       fraction_done(&j, clock_seconds()), atomic_load(&j.rays_done));
    }
    j.result.finished = j.interrupted ? fraction_done(&j, clock_seconds()) : 1;
    *out = j.result;
    return job_status(context, &j);
}
