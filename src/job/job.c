#include "job/job_inner.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/pool.h"
#include "base/threads.h"
#include "job/preview.h"
#include "material/textured.h"

#include <stdlib.h>

void job_count_rays(job *j, const integration *work, const ray_counts *before) {
    const uint64_t rays = ray_counts_total(&work->rays) - ray_counts_total(before);
    atomic_fetch_add_explicit(&j->rays_done, rays, memory_order_relaxed);
}

void job_stop(job *j, const integration *work) {
    if (work->out_of_memory) atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
}

void job_deliver(job *j, worker *self, const unit_result *result) {
    for (unsigned i = 0; i < j->sink_count; ++i) j->sinks[i].take(j->sinks[i].user, result);
    self->samples += unit_samples(result);
    self->error = fmax(self->error, result->error);
    self->wave_error = fmax(self->wave_error, result->error);
    double most = atomic_load(&j->error_done);
    while (result->error > most && !atomic_compare_exchange_weak(&j->error_done, &most, result->error)) {
    }
    atomic_fetch_add_explicit(&j->pixels_done, unit_pixels(result), memory_order_relaxed);
}

void job_show(const job *j, worker *self, const adaptive_wave *a) {
    const unit_sink film = unit_film_sink(j->film);
    const unit_result now = adaptive_unit(a, j->film, self->view);
    film.take(film.user, &now);
}

/* ---- tiles ---- */

typedef struct tiles {
    job *job;
    render_wave_fn render;
    uint32_t first_x, first_y; /* corner of the grid of tiles, in pixels */
    uint32_t across, down;
} tiles;

static bool hand_over(job *j, const worker *self, wave_result *done, double began, const ray_counts *before) {
    const wave_share *share = j->options->share;
    done->error = self->wave_error;
    done->seconds = clock_thread_seconds() - began;
    done->rays = self->integration->rays;
    ray_counts_add(before, -1, &done->rays);
    done->sums = self->share, done->bytes = self->share_bytes;
    if (share->take(share->user, done)) return true;
    atomic_store(&j->lost, true);
    return false;
}

static bool render_unit(job *j, render_wave_fn render, worker *self, const work_unit *unit) {
    const wave_share *share = j->options->share;
    const wave_region region = wave_grid_region(&j->grid, unit->wave);
    if (!share) return render(j, self, &region, unit->squares);
    wave_result done = {.unit = *unit};
    const double began = clock_thread_seconds();
    const ray_counts before = self->integration->rays;
    const uint64_t samples = self->samples;
    self->wave_error = 0;
    if (!render(j, self, &region, unit->squares)) return false;
    done.samples = self->samples - samples;
    return hand_over(j, self, &done, began, &before);
}

/* The squares of a tile's part of a wave that this process must render and that are not finished. */
static work_unit unit_of(const job *j, const wave_region *region) {
    const wave_share *share = j->options->share;
    const checkpoint *saving = j->options->saving;
    work_unit u = {.wave = wave_grid_at(&j->grid, region->left, region->top)};
    if (!share || share->wants(share->user, u.wave)) u.squares = wave_region_bits(*region);
    if (saving) u.squares &= ~checkpoint_finished(saving, u.wave);
    return u;
}

static void render_tile(const tiles *t, worker *self, size_t tile) {
    const fathom_film *film = t->job->film;
    const uint32_t size = t->job->plan->settings.tile_size;
    const uint32_t left = t->first_x + (uint32_t)(tile % t->across) * size,
                   top = t->first_y + (uint32_t)(tile / t->across) * size;
    const wave_grid waves = wave_grid_of(max_u32(left, film->x), max_u32(top, film->y),
                                         min_u32(left + size, film->x + film->width),
                                         min_u32(top + size, film->y + film->height));
    for (uint32_t i = 0; i < waves.count; ++i) {
        const wave_region region = wave_grid_region(&waves, i);
        const work_unit unit = unit_of(t->job, &region);
        if (!unit.squares || render_unit(t->job, t->render, self, &unit)) continue;
        job_stop(t->job, self->integration);
        return;
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

static void run_handed_out(void *user, size_t begin, size_t end, unsigned index) {
    const tiles *t = user;
    const wave_share *share = t->job->options->share;
    unsigned state = trace_thread_begin();
    work_unit unit;
    (void)begin, (void)end;
    for (worker *self;
         (self = job_worker(t->job, index)) && share->next(share->user, &t->job->stop, &unit);) {
        if (!render_unit(t->job, t->render, self, &unit)) job_stop(t->job, self->integration);
    }
    trace_thread_end(state);
}

void job_run_tiles(job *j, render_wave_fn render) {
    const fathom_film *film = j->film;
    if (j->options->share && j->options->share->next) {
        tiles handed_out = {.job = j, .render = render};
        loop_workers(j->threads, j->threads, 1, run_handed_out, &handed_out);
        return;
    }
    const uint32_t size = j->plan->settings.tile_size;
    tiles t = {
        .job = j, .render = render, .first_x = film->x / size * size, .first_y = film->y / size * size};
    t.across = (film->x + film->width - t.first_x + size - 1) / size;
    t.down = (film->y + film->height - t.first_y + size - 1) / size;
    loop_workers(j->threads, (size_t)t.across * t.down, 1, run_tiles, &t);
}

/* ---- workers ---- */

worker *job_worker(job *j, unsigned index) {
    worker *self = &j->workers[index];
    if (atomic_load(&j->stop)) return NULL;
    if (self->integration) return self;
    self->integration = j->plan->integrator->create(j->plan, &j->stop);
    if (self->integration && j->schedule->prepare(j, self)) return self;
    atomic_store(&j->failed, true);
    atomic_store(&j->stop, true);
    return NULL;
}

static void collect(job *j) {
    job_result *to = &j->result;
    if (j->options->share) {
        const wave_result *others = &j->options->share->others;
        to->samples += others->samples;
        to->error = fmax(to->error, others->error);
        ray_counts_add(&others->rays, 1, &to->rays);
    }
    for (unsigned i = 0; i < j->threads; ++i) {
        worker *self = &j->workers[i];
        to->samples += self->samples;
        to->error = fmax(to->error, self->error);
        if (self->integration) ray_counts_add(&self->integration->rays, 1, &to->rays);
        j->plan->integrator->destroy(self->integration);
        if (self->adaptive) adaptive_destroy(self->adaptive);
        if (self->sums) pixel_sums_destroy(self->sums);
        free(self->adaptive);
        adaptive_view_destroy(self->view);
        free(self->sums);
        free(self->nodes);
        free(self->share);
    }
}

/* The reference samples pixels of the whole image alone. */
static void show_preview(job *j) {
    if (j->schedule == &schedule_to_time || j->plan->settings.spp == 1 || j->options->share) return;
    if (j->plan->reference) return;
    preview_run(j->plan, j->threads, &j->stop, j->options->saving, j->film);
}

static void run(void *user) {
    job *j = user;
    show_preview(j);
    j->workers = calloc(j->threads, sizeof *j->workers);
    if (j->workers) {
        j->schedule->run(j);
        collect(j);
    } else {
        atomic_store(&j->failed, true);
    }
    free(j->workers);
}

static double fraction_done(const job *j, double now) {
    double deadline = atomic_load(&j->deadline);
    if (deadline > 0) return fmin(fmax((now - j->began) / (deadline - j->began), 0), 1);
    const wave_share *share = j->options->share;
    const double pixels = share ? (double)share->pixels : (double)j->film->width * (double)j->film->height;
    const uint64_t done = atomic_load(&j->pixels_done) + (share ? atomic_load(&share->others_pixels) : 0);
    return pixels > 0 ? (double)done / pixels : 1;
}

/* If a file has changed, everything finished more than a second ago used its old contents. Images are decoded
 * once a ray needs them. */
static void watch_files(job *j) {
    const fathom_scene *scene = j->plan->scene;
    if (j->files == FATHOM_OK) j->files = scene_watch_files(scene, &j->next_look);
    if (j->files == FATHOM_OK) j->files = texturing_check(j->plan->texturing, scene->context);
    if (j->files != FATHOM_OK) atomic_store(&j->stop, true);
}

/* A complete render is no longer stopped, watched or saved. */
static void report(void *user) {
    job *j = user;
    double seconds = clock_seconds();
    fathom_progress now = {.phase = FATHOM_PHASE_RENDER,
                           .fraction = fraction_done(j, seconds),
                           .rays = j->rays_before + atomic_load(&j->rays_done),
                           .seconds = seconds - j->began,
                           .error = atomic_load(&j->error_done)};
    bool complete = j->deadline > 0 ? atomic_load(&j->complete) : now.fraction >= 1;
    const job_options *o = j->options;
    if (!complete && !j->interrupted) watch_files(j);
    if (o->share && o->share->tick) o->share->tick(o->share->user);
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
    if (atomic_load(&j->lost)) return FATHOM_OUT_OF_RESOURCES;
    if (j->interrupted) return fail(context, FATHOM_INTERRUPTED, "stopped; what was finished is kept");
    if (!(j->sampled < 1)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, "max time",
                      "too short: it ended when %.0f %% of the image had its first sample; give more "
                      "time, or render a smaller image",
                      floor(100 * j->sampled));
}

/* Starts from the counts of earlier calls; their finished pixels are already in the film. */
static void continue_before(job *j) {
    checkpoint_past before = {.seconds = 0};
    if (j->options->share) before = j->options->share->before;
    if (j->options->saving) before = checkpoint_before(j->options->saving);
    j->began -= before.seconds;
    j->rays_before = before.rays;
    atomic_store(&j->pixels_done, before.pixels);
    j->result.samples = before.samples;
    j->result.error = before.error;
    atomic_store(&j->error_done, before.error);
}

fathom_status job_run(fathom_context *context, const render_plan *plan, const job_options *options,
                      fathom_film *film, job_result *out) {
    job j = {.plan = plan,
             .film = film,
             .threads = fathom_context_threads(context),
             .options = options,
             .began = clock_seconds(),
             .grid = film_waves(film),
             .sampled = 1};
    j.deadline = plan->settings.max_time > 0 ? j.options->deadline : 0;
    j.schedule = j.deadline > 0                    ? &schedule_to_time
                 : plan->settings.target_error > 0 ? &schedule_to_error
                                                   : &schedule_even;
    fathom_status status = check_memory(context, &j);
    if (status != FATHOM_OK) return status;
    if (!j.options->share || !j.options->share->sums) j.sinks[j.sink_count++] = unit_film_sink(film);
    if (j.options->saving) j.sinks[j.sink_count++] = checkpoint_sink(j.options->saving);
    continue_before(&j);
    job_watch(run, report, &j);
    if (j.options->saving) {
        checkpoint_end(j.options->saving, j.interrupted && j.files == FATHOM_OK,
                       fraction_done(&j, clock_seconds()), atomic_load(&j.rays_done));
    }
    j.result.finished = j.interrupted ? fraction_done(&j, clock_seconds()) : 1;
    *out = j.result;
    return job_status(context, &j);
}

void job_watch(void (*work)(void *user), void (*tick)(void *user), void *user) {
    pool_task task = {.run = work, .user = user};
    if (pool_run(&task)) {
        while (!pool_wait(&task, 0.1)) tick(user);
    } else {
        work(user);
    }
    tick(user);
}
