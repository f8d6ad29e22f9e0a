/* The map of caustics: which scenes get one, and its photons. */
#include "integrate/caustics/caustics.h"

#include "base/threads.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>

/* Photons for each sample of the image: bench/path_tracing.md. A render to an error is planned as one with
 * more samples than usual, because more samples do not lower the map's error; a render to a time may be
 * short. */
#define PHOTONS_PER_SAMPLE (1 / 16.0)
#define SPP_TO_ERROR 128u
#define SPP_TO_TIME 8u
/* The first photons, a quarter as many, but no fewer and no more than this, tell how many each caster
 * deserves. */
#define LEAST_PILOTS (1u << 10)
#define MOST_PILOTS (1u << 14)
/* Each caster keeps this part of an even share. */
#define EVEN 0.1
#define BATCH WAVE_SLOTS
#define ROUND 256u /* batches whose light is kept until it is added */
/* Photons use other random numbers than the image. */
#define OTHER_SEED 0xca5c0u

/* All threads. */
typedef struct photon_run {
    render_plan plan;
    plan_watch *watch;
    caustics *of;
    photon_wave **waves;
    unsigned threads;
    caustic_splats *found;     /* by batch of a round */
    uint32_t group, done, end; /* photons */
    atomic_bool fails;
} photon_run;

/* ---- which scenes ---- */

/* Connections know cameras in air and near the scene. */
static bool is_eligible(const render_plan *plan) {
    return plan->settings.photons && plan->max_depth > 1 && !emitters_none(plan->emitters) && !plan->far &&
           !plan->eye_volumes.count && !plan->volumes_differ;
}

/* ---- photons ---- */

static void run_batches(void *user, size_t begin, size_t end, unsigned worker) {
    photon_run *run = user;
    photon_wave **w = &run->waves[worker];
    const unsigned state = trace_thread_begin();
    if (!*w) *w = photon_wave_create(&run->plan, run->of, &run->watch->stop);
    for (size_t b = begin; *w && b < end && !atomic_load(&run->fails); ++b) {
        const uint32_t first = run->done + (uint32_t)b * BATCH;
        run->found[b].count = 0;
        if (!photon_wave_run(*w, run->group, first, min_u32(run->end - first, BATCH), &run->found[b]) &&
            !atomic_load(&run->watch->stop))
            atomic_store(&run->fails, true);
    }
    if (!*w) atomic_store(&run->fails, true);
    trace_thread_end(state);
}

/* Not of the first photons, whose group is beyond those of the map. */
static void tell_progress(const photon_run *run) {
    const uint32_t groups = run->of->groups;
    const double part = run->done / (double)run->end;
    if (run->group < groups) atomic_store(&run->watch->photons, (run->group + part) / groups);
}

/* Runs the photons [0, count) of a group; add() gets their light in the order of photons. False: out of
 * memory, or stopped. */
static bool run_photons(photon_run *run, uint32_t group, uint32_t count,
                        void (*add)(photon_run *run, const caustic_splat *splat)) {
    run->group = group, run->end = count;
    for (run->done = 0; run->done < count;) {
        const uint32_t left = count - run->done, batches = min_u32((left + BATCH - 1) / BATCH, ROUND);
        loop_workers(run->threads, batches, 1, run_batches, run);
        if (atomic_load(&run->fails) || atomic_load(&run->watch->stop)) return false;
        for (uint32_t b = 0; b < batches; ++b)
            for (size_t k = 0; k < run->found[b].count; ++k) add(run, &run->found[b].items[k]);
        run->done += min_u32(left, batches * BATCH);
        tell_progress(run);
    }
    return true;
}

/* ---- how many each caster gets ---- */

static void add_to_caster(photon_run *run, const caustic_splat *s) {
    run->of->casters[s->caster].light += (double)s->rgb[0] + (double)s->rgb[1] + (double)s->rgb[2];
}

/* Returns false if photons bring no light. */
static bool share_photons(caustics *c) {
    double light = 0;
    for (uint32_t k = 0; k < c->count; ++k) light += c->casters[k].light;
    for (uint32_t k = 0; k < c->count && light > 0; ++k)
        c->casters[k].chance = EVEN / c->count + (1 - EVEN) * c->casters[k].light / light;
    return light > 0;
}

/* ---- the map ---- */

static float *cell_of(const caustics *c, uint32_t group, uint32_t layer, size_t pixel) {
    return &c->map[3 * (((size_t)group * c->layers + layer) * c->width * c->height + pixel)];
}

static void add_to_cell(const photon_run *run, uint32_t layer, const caustic_splat *s, const float share[3]) {
    float *cell = cell_of(run->of, run->group, layer, s->pixel);
    for (int c = 0; c < 3; ++c) cell[c] += (float)((double)(s->rgb[c] * share[c]) / run->end);
}

static void add_to_map(photon_run *run, const caustic_splat *s) {
    static const float all[3] = {1, 1, 1};
    float shares[LIGHT_GROUP_OUTSIDE][3];
    add_to_cell(run, 0, s, all);
    if (run->of->layers == 1) return;
    if (s->group != LIGHT_GROUP_OUTSIDE) {
        add_to_cell(run, 1 + s->group, s, all);
        return;
    }
    emitters_outside_shares(run->plan.emitters, s->direction, shares);
    for (uint32_t g = 1; g < run->of->layers; ++g) add_to_cell(run, g, s, shares[g - 1]);
}

/* The first photons serve the whole image, so that a crop changes no pixel. */
static void set_whole(const render_plan *plan, caustics *c) {
    c->x0 = c->y0 = 0, c->width = plan->settings.width, c->height = plan->settings.height;
}

/* Adaptive renders and the AOV of errors need groups. The map keeps whole waves of a crop. */
static void set_extent(const fathom_settings *s, film_parts parts, caustics *c) {
    const bool cropped = s->crop[2] > 0;
    const uint32_t x1 = cropped ? s->crop[2] : s->width, y1 = cropped ? s->crop[3] : s->height;
    c->x0 = s->crop[0] / WAVE_SIDE * WAVE_SIDE, c->y0 = s->crop[1] / WAVE_SIDE * WAVE_SIDE;
    c->width = min_u32((x1 + WAVE_SIDE - 1) / WAVE_SIDE * WAVE_SIDE, s->width) - c->x0;
    c->height = min_u32((y1 + WAVE_SIDE - 1) / WAVE_SIDE * WAVE_SIDE, s->height) - c->y0;
    c->groups = s->target_error > 0 || s->max_time > 0 || s->aovs & FATHOM_AOV_ERROR ? SAMPLE_GROUPS : 1;
    c->layers = 1;
    if (parts.groups >= 0) c->layers += parts.layers - (uint8_t)parts.groups;
}

static size_t map_bytes(const caustics *c) {
    return (size_t)c->groups * c->layers * c->width * c->height * 3 * sizeof *c->map;
}

static double photons_wanted(const fathom_settings *s) {
    const uint32_t most = s->max_time > 0 ? SPP_TO_TIME : s->target_error > 0 ? SPP_TO_ERROR : s->spp;
    return fmin(PHOTONS_PER_SAMPLE * s->width * s->height * min_u32(s->spp, most), 0x1p31);
}

static bool fill_map(photon_run *run) {
    caustics *c = run->of;
    const double each = fmax(floor(photons_wanted(&run->plan.settings) / c->groups), 1);
    c->photons = each * c->groups / plan_expected_spp(&run->plan.settings);
    for (uint32_t g = 0; g < c->groups; ++g)
        if (!run_photons(run, g, (uint32_t)each, add_to_map)) return false;
    return true;
}

/* ---- all ---- */

static render_plan plan_for(const render_plan *plan) {
    render_plan out = plan_before(plan, OTHER_SEED);
    out.background = out.one_sided = false;
    out.to_camera = plan->one_sided;
    return out;
}

static bool start_run(photon_run *run, fathom_context *context, const render_plan *plan, plan_watch *watch,
                      caustics *c) {
    *run = (photon_run){
        .plan = plan_for(plan), .watch = watch, .of = c, .threads = fathom_context_threads(context)};
    run->waves = calloc(run->threads, sizeof *run->waves);
    run->found = calloc(ROUND, sizeof *run->found);
    return run->waves && run->found;
}

static void end_run(photon_run *run) {
    for (unsigned t = 0; run->waves && t < run->threads; ++t) photon_wave_destroy(run->waves[t]);
    for (uint32_t b = 0; run->found && b < ROUND; ++b) array_free(&run->found[b]);
    free(run->waves);
    free(run->found);
}

/* False: out of memory, or stopped. *lit: the map holds light. */
static bool make_map(photon_run *run, const render_plan *plan, bool *lit) {
    caustics *c = run->of;
    for (uint32_t k = 0; k < c->count; ++k) c->casters[k].chance = 1.0 / c->count;
    c->photons = 1;
    set_whole(plan, c);
    const double pilots = fmin(fmax(photons_wanted(&run->plan.settings) / 4, LEAST_PILOTS), MOST_PILOTS);
    if (!run_photons(run, SAMPLE_GROUPS, (uint32_t)pilots, add_to_caster)) return false;
    *lit = share_photons(c);
    if (!*lit) return true;
    set_extent(&plan->settings, plan->parts, c);
    c->map = calloc(1, map_bytes(c));
    return c->map && fill_map(run);
}

fathom_status caustics_create(fathom_context *context, const render_plan *plan, plan_watch *watch,
                              caustics **out) {
    photon_run run;
    bool lit = false;
    *out = NULL;
    if (!is_eligible(plan)) return FATHOM_OK;
    caustics *c = calloc(1, sizeof *c);
    if (!c) return fail_memory(context, sizeof *c);
    bool fine = caustic_casters_find(plan, c);
    c->images = emitters_any_skies(plan->emitters);
    if (c->count)
        fine = (start_run(&run, context, plan, watch, c) && make_map(&run, plan, &lit)) ||
               atomic_load(&watch->stop);
    if (c->count) end_run(&run);
    if (fine && lit)
        *out = c;
    else
        caustics_destroy(c);
    return fine ? FATHOM_OK : fail_memory(context, (size_t)ROUND * BATCH * sizeof(caustic_splat));
}

size_t caustics_bytes(const caustics *c) { return c ? map_bytes(c) : 0; }

size_t caustics_bytes_expected(const fathom_scene *scene, const fathom_settings *settings) {
    caustics c = {.map = NULL};
    if (settings->integrator != FATHOM_INTEGRATOR_PATH || !settings->photons) return 0;
    if (!caustic_smooth_materials(scene)) return 0;
    set_extent(settings, film_parts_of(settings, &scene->light_groups), &c);
    return map_bytes(&c);
}

void caustics_destroy(caustics *c) {
    if (!c) return;
    free(c->ends);
    free(c->map);
    free(c);
}

static void add_sample(const caustics *c, wave *w, uint32_t slot, uint32_t group, size_t pixel) {
    const vec3_f32 nowhere = {0, 0, 0};
    const float *rgb = cell_of(c, group, 0, pixel);
    for (int k = 0; k < 3; ++k) w->run.samples.radiance[k][slot] += rgb[k];
    if (!w->run.samples.layers) return;
    if (c->layers == 1) wave_add_layers(w, slot, (light_tag){LIGHT_INDIRECT, 0}, nowhere, rgb);
    for (uint32_t g = 1; g < c->layers; ++g)
        wave_add_layers(w, slot, (light_tag){LIGHT_INDIRECT, (uint8_t)(g - 1)}, nowhere,
                        cell_of(c, group, g, pixel));
}

void caustics_add(const caustics *c, wave *w, const wave_batch *batch) {
    for (uint32_t s = 0; s < batch->count; ++s) {
        const wave_square *square = &batch->squares[s];
        for (uint32_t k = 0; k < LANES; ++k) {
            const uint32_t x = square->left + k % 4 - c->x0, y = square->top + k / 4 - c->y0;
            if (x < c->width && y < c->height)
                add_sample(c, w, s * LANES + k, square->group, (size_t)y * c->width + x);
        }
    }
}
