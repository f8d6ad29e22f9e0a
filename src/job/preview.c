#include "job/preview.h"

#include "base/threads.h"

#include <stdlib.h>

/* Samples of the whole render for each sample of the preview. Distant rays share less of the caches. Even if
 * each took the time of eight other rays, the preview would take 1 % of the time. In meshes of 0.36 and 8
 * million triangles, at 16 samples a pixel, the cost cannot be measured: the medians of 24 and 16 pairs of
 * runs are 0.985 and 1.002. */
#define SAMPLES_FOR_ONE 800u

typedef struct preview_worker {
    integration *integration;
    pixel_sums sums;
    bool ready;
} preview_worker;

typedef struct preview {
    render_plan plan; /* of the coarse image, with one pixel per block */
    uint32_t block;   /* width of a block in pixels, a power of two */
    const atomic_bool *stop;
    const checkpoint *saving;
    fathom_film *coarse, *film;
    preview_worker *workers;
} preview;

/* Mean samples a pixel that a render to an error is expected to take. If it takes only the minimum,
 * ADAPTIVE_MIN_SPP, the preview has one of 256 samples. */
#define USUAL_SPP 16u

static uint32_t expected_spp(const fathom_settings *settings) {
    return settings->target_error > 0 ? min_u32(settings->spp, max_u32(settings->min_spp, USUAL_SPP))
                                      : settings->spp;
}

/* At least 2: otherwise the coarse image would take as much memory as the film. */
static uint32_t block_for(uint32_t spp) {
    uint32_t block = 2;
    while ((uint64_t)block * block * spp < SAMPLES_FOR_ONE) block *= 2;
    return block;
}

static uint32_t blocks(uint32_t pixels, uint32_t block) { return (pixels + block - 1) / block; }

static fathom_settings coarse_settings(const render_plan *plan, const fathom_film *film, uint32_t block) {
    fathom_settings out = plan->settings;
    out.width = blocks(film->full_width, block), out.height = blocks(film->full_height, block);
    out.crop[0] = film->x / block, out.crop[1] = film->y / block;
    out.crop[2] = blocks(film->x + film->width, block), out.crop[3] = blocks(film->y + film->height, block);
    out.spp = 1, out.pattern = FATHOM_PATTERN_GRID;
    out.target_error = 0, out.min_spp = 0;
    return out;
}

static bool make_worker(const preview *p, preview_worker *self) {
    if (self->ready) return true;
    self->integration = p->plan.integrator->create(&p->plan, p->stop);
    self->ready = self->integration && pixel_sums_create(&p->plan.sampler, 1, p->plan.parts, &self->sums);
    return self->ready;
}

static void render_region(const preview *p, preview_worker *self, const wave_region *r) {
    wave_batch batch;
    batch.count = wave_list_squares(r, wave_region_bits(*r), batch.squares);
    if (!make_worker(p, self) || !p->plan.integrator->run(self->integration, r, &batch)) return;
    pixel_sums_clear(&self->sums);
    for (uint32_t place = 0; place < batch.count; ++place) {
        pixel_sums_add(&self->sums, &self->integration->samples, r, &batch, place);
        pixel_sums_store_square(&self->sums, r, &batch.squares[place], (sums_count){1, 1}, p->coarse);
    }
}

static void render_regions(void *user, size_t begin, size_t end, unsigned index) {
    preview *p = user;
    unsigned state = trace_thread_begin();
    const wave_grid grid = film_waves(p->coarse);
    for (size_t i = begin; i < end && !atomic_load(p->stop); ++i) {
        const wave_region r = wave_grid_region(&grid, (uint32_t)i);
        render_region(p, &p->workers[index], &r);
    }
    trace_thread_end(state);
}

static size_t coarse_pixel(const preview *p, uint32_t x, uint32_t y) {
    return (size_t)(y / p->block - p->coarse->y) * p->coarse->width + (x / p->block - p->coarse->x);
}

/* Copies all channels except the sample count: the samples are not the pixel's own. */
static void show_pixel(const preview *p, uint32_t x, uint32_t y) {
    const size_t to = (size_t)(y - p->film->y) * p->film->width + (x - p->film->x);
    const size_t from = coarse_pixel(p, x, y);
    for (uint32_t c = 0; c < p->film->channel_count; ++c) {
        if (p->film->channels[c].data == p->film->samples) continue;
        ((uint32_t *)p->film->channels[c].data)[to] = ((const uint32_t *)p->coarse->channels[c].data)[from];
    }
}

static void show_region(const preview *p, const wave_region *r) {
    const checkpoint *c = p->saving;
    const uint64_t finished = c ? checkpoint_finished(c, checkpoint_wave(c, r->left, r->top)) : 0;
    for (uint32_t y = r->y0; y < r->y1; ++y) {
        for (uint32_t x = r->x0; x < r->x1; ++x) {
            if (!(finished >> wave_slot(x - r->left, y - r->top) / LANES & 1)) show_pixel(p, x, y);
        }
    }
}

static void show_regions(void *user, size_t begin, size_t end) {
    const preview *p = user;
    const wave_grid grid = film_waves(p->film);
    for (size_t i = begin; i < end; ++i) {
        const wave_region r = wave_grid_region(&grid, (uint32_t)i);
        pthread_mutex_lock(&p->film->lock);
        show_region(p, &r);
        pthread_mutex_unlock(&p->film->lock);
    }
}

static void destroy_workers(preview *p, unsigned threads) {
    for (unsigned i = 0; i < threads; ++i) {
        p->plan.integrator->destroy(p->workers[i].integration);
        if (p->workers[i].ready) pixel_sums_destroy(&p->workers[i].sums);
    }
    free(p->workers);
}

void preview_run(const render_plan *plan, unsigned threads, const atomic_bool *stop, const checkpoint *saving,
                 fathom_film *film) {
    preview p = {.plan = *plan, .stop = stop, .saving = saving, .film = film};
    p.block = block_for(expected_spp(&plan->settings));
    p.plan.settings = coarse_settings(plan, film, p.block);
    p.plan.sampler = (sampler){FATHOM_PATTERN_GRID, 1, 0};
    p.plan.camera.across = scale_f64(p.block, plan->camera.across);
    p.plan.camera.down = scale_f64(p.block, plan->camera.down);
    if (film_create(NULL, plan->scene, &p.plan.settings, &p.coarse) != FATHOM_OK) return;
    p.workers = calloc(threads, sizeof *p.workers);
    if (p.workers) {
        loop_workers(threads, film_waves(p.coarse).count, 1, render_regions, &p);
        if (!atomic_load(stop)) loop_parallel(threads, film_waves(film).count, 16, show_regions, &p);
        destroy_workers(&p, threads);
    }
    fathom_film_destroy(p.coarse);
}
