#include "job/render.h"

#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/opened.h"
#include "integrate/caustics/caustics.h"
#include "integrate/reference/reference.h"
#include "job/checkpoint/checkpoint.h"
#include "job/job.h"
#include "job/lacks.h"
#include "job/part/part.h"
#include "job/ranks/ranks.h"
#include "light/environment.h"
#include "math/rgb.h"
#include "scene/scene.h"

#include <string.h>

typedef struct build {
    fathom_context *context;
    const world *world;
    trace_options options;
    trace_tracer *tracer;
    texture_cache *textures; /* NULL: no material has any, or the plan owns them */
    uint64_t sky_bytes;
    fathom_status status;
    const fathom_settings *settings;
    fathom_film *film;
    render_plan *plan;
    fathom_progress_fn progress; /* on the calling thread alone */
    void *progress_user;
    double began;
    _Atomic double fraction; /* as last reported by Embree's building threads */
    plan_watch watch;
    double photons_began; /* 0: not yet */
} build;

static bool on_build(void *user, double fraction) {
    build *b = user;
    atomic_store(&b->fraction, fraction);
    return !atomic_load(&b->watch.stop);
}

static void build_plan(void *user) {
    build *b = user;
    trace_passing passing;
    b->status = plan_create(b->context, b->world, b->tracer, b->settings, b->textures, &b->watch, &b->plan);
    if (b->status != FATHOM_OK || !trace_tells_opaque(b->tracer) || !b->plan->texturing) return;
    b->status = texturing_find_passing(b->plan->texturing, b->context, &passing);
    if (b->status == FATHOM_OK) trace_know_passing(b->tracer, &passing);
}

static void report_build(void *user) {
    build *b = user;
    fathom_progress now = {.phase = FATHOM_PHASE_BUILD,
                           .fraction = fmin(fmax(atomic_load(&b->fraction), 0), 1),
                           .seconds = clock_seconds() - b->began};
    const double photons = atomic_load(&b->watch.photons);
    if (photons > 0) {
        if (!(b->photons_began > 0)) b->photons_began = clock_seconds();
        now = (fathom_progress){.phase = FATHOM_PHASE_PHOTONS,
                                .fraction = photons,
                                .seconds = clock_seconds() - b->photons_began};
    }
    if (b->progress && !atomic_load(&b->watch.stop) && !b->progress(b->progress_user, &now))
        atomic_store(&b->watch.stop, true);
}

static fathom_status end_build(build *b) {
    if (b->status != FATHOM_OK || !atomic_load(&b->watch.stop)) return b->status;
    return fail(b->context, FATHOM_INTERRUPTED, "stopped while building; there is no image yet");
}

static uint64_t program_bytes(const fathom_context *context) {
    return MEMORY_PROGRAM + (uint64_t)fathom_context_threads(context) * MEMORY_THREAD;
}

/* The memory that the process will use in addition to the tracer's structures. A large film takes no memory
 * yet, unless a checkpoint has filled it. A mapped mesh takes the memory of the parts that were read. */
static fathom_status memory_besides(build *b, uint64_t *out) {
    const world *w = b->world;
    uint64_t meshes;
    fathom_status status = scene_buffer_bytes(w->scene, SCENE_TRACED | SCENE_SHADED, &meshes);
    if (status == FATHOM_OK && b->settings->integrator != FATHOM_INTEGRATOR_CLASSIC)
        status = environment_measure(b->context, w->scene, &b->sky_bytes);
    if (status != FATHOM_OK) return status;
    uint64_t bytes = b->film->bytes, expected = program_bytes(b->context) + meshes + w->carried_bytes,
             film_now = b->film->stats.resumed_samples ? bytes : memory_taken(bytes);
    uint64_t resident = memory_resident();
    resident = resident > film_now ? resident - film_now : 0;
    b->film->stats.image_bytes = b->sky_bytes + texture_cache_bytes(b->textures);
    *out = (resident > expected ? resident : expected) + bytes + b->film->stats.image_bytes +
           caustics_bytes_expected(w->scene, b->settings);
    return FATHOM_OK;
}

/* The memory left for building; 0: no limit is known. With a limit, at least one byte. */
static uint64_t building_memory(uint64_t other, uint64_t limit) {
    uint64_t free_now = memory_free(), room = free_now > INT64_MAX ? 0 : free_now + memory_private();
    if (limit && (!room || limit < room)) room = limit;
    return !room ? 0 : (room > other + 1 ? room - other : 1);
}

/* Textures first, because they take memory from the tracer. */
static void build_tracer(void *user) {
    build *b = user;
    uint64_t other;
    if (b->world->scene->has_maps)
        b->status =
            texture_cache_open(b->context, b->world->scene, b->settings->texture_memory, &b->textures);
    if (b->status == FATHOM_OK) b->status = memory_besides(b, &other);
    if (b->status != FATHOM_OK) return;
    b->options.memory = building_memory(other, b->settings->memory_limit), b->options.besides = other;
    b->status = trace_create(b->context, b->world, &b->options, &b->tracer);
    if (b->tracer && trace_foreseen_bytes(b->tracer))
        b->film->stats.foreseen_bytes = other + trace_foreseen_bytes(b->tracer);
}

static fathom_status run_build(build *b) {
    const world *w = b->world;
    const fathom_settings *settings = b->settings;
    fathom_status status = scene_rest_files(w->scene, w->meshes.items, w->meshes.count);
    if (status != FATHOM_OK) return status;
    b->options = (trace_options){.words = settings->tracer,
                                 .timed = settings->integrator != FATHOM_INTEGRATOR_CLASSIC,
                                 .width = settings->block_width,
                                 .tell_opaque = settings->integrator == FATHOM_INTEGRATOR_PATH,
                                 .threads = fathom_context_threads(b->context),
                                 .expected_rays = plan_expected_rays(w->scene, settings),
                                 .progress = b->progress ? on_build : NULL,
                                 .user = b};
    job_watch(build_tracer, report_build, b);
    return end_build(b);
}

static uint64_t placed_triangles(const world *w, uint32_t group) {
    uint64_t count = 0;
    for (uint32_t i = 0; i < w->groups.items[group].count; ++i) {
        const world_geometry *geometry = &w->geometries.items[w->groups.items[group].first + i];
        if (geometry->kind == WORLD_MESH) count += geometry->count;
    }
    return count;
}

static fathom_status count_scene(const world *w, const trace_tracer *tracer, const fathom_film *film,
                                 fathom_stats *stats) {
    const fathom_scene *scene = w->scene;
    stats->triangles = scene_triangles(scene);
    stats->primitives = scene_primitives(scene);
    stats->instances = w->instances.count;
    stats->placed_triangles = placed_triangles(w, 0);
    for (size_t k = 0; k < w->instances.count; ++k)
        stats->placed_triangles += placed_triangles(w, w->instances.items[k].group);
    stats->degenerate_triangles = w->degenerate_triangles;
    stats->bvh_bytes = trace_bvh_bytes(tracer);
    stats->bvh_peak_bytes = trace_peak_bytes(tracer);
    stats->film_bytes = film->bytes;
    stats->threads = fathom_context_threads(scene->context);
    const char *name = trace_name(tracer);
    for (size_t i = 0; name[i] && i + 1 < sizeof stats->tracer; ++i) stats->tracer[i] = name[i];
    const fathom_status status = scene_buffer_bytes(scene, SCENE_BUFFERS, &stats->mesh_bytes);
    stats->mesh_bytes += w->carried_bytes;
    return status;
}

/* Where finished work is stored in addition to the film; each may be NULL. */
typedef struct keeping {
    checkpoint *saving;
    part *part;
    ranks *ranks;
} keeping;

static void keep_brightest(fathom_film *film, const float rgb[3]) {
    for (int c = 0; c < 3; ++c) film->brightest[c] = fmaxf(film->brightest[c], rgb[c]);
}

/* Only the stated errors need it; it may read whole images. */
static fathom_status find_brightest(fathom_context *context, const render_plan *plan, fathom_film *film) {
    const fathom_scene *scene = plan->scene;
    fathom_status status = FATHOM_OK;
    float rgb[3];
    if (!film->doubt) return status;
    if (plan->emitters) {
        emitters_brightest_outside(plan->emitters, rgb);
        keep_brightest(film, rgb);
    }
    for (size_t i = 0; i < scene->materials.count && status == FATHOM_OK; ++i) {
        const fathom_material *m = &scene->materials.items[i].value;
        for (int c = 0; c < 3; ++c) rgb[c] = fmaxf(m->k_e[c], m->emissive[c] * m->emissive_strength);
        if (!rgb_any(rgb)) continue;
        if (plan->texturing) status = texturing_brighten(plan->texturing, context, (fathom_id)i, rgb);
        keep_brightest(film, rgb);
    }
    return status;
}

static fathom_status make_plan(build *b) {
    atomic_store(&b->fraction, 1);
    job_watch(build_plan, report_build, b);
    b->film->stats.photon_seconds = b->plan ? b->plan->photon_seconds : 0;
    b->film->stats.build_seconds = clock_seconds() - b->began - b->film->stats.photon_seconds;
    fathom_status status = end_build(b);
    if (status == FATHOM_OK) status = find_brightest(b->context, b->plan, b->film);
    if (status != FATHOM_OK) return status;
    b->film->stats.film_bytes += caustics_bytes(b->plan->caustics);
    return left_out_find(b->world, b->settings, b->plan->watertight, &b->film->left_out)
               ? FATHOM_OK
               : fail_memory(b->context, sizeof(fathom_left_out));
}

static fathom_status run_plan(fathom_context *context, const render_plan *plan, const job_options *options,
                              fathom_film *film) {
    job_result result = {.samples = 0};
    const double began = clock_seconds();
    fathom_status status = job_run(context, plan, options, film, &result);
    fathom_status found = reference_check(plan->reference);
    if (found == FATHOM_OK && (status == FATHOM_OK || status == FATHOM_INTERRUPTED))
        found = texturing_check(plan->texturing, context);
    if (found != FATHOM_OK) status = found;
    film->stats.render_seconds = clock_seconds() - began;
    memcpy(&film->stats.camera_rays, &result.rays, sizeof result.rays);
    film->stats.samples = result.samples;
    film->stats.finished = result.finished;
    film->stats.error_estimate = result.error;
    return status;
}

/* Subtracts the seconds that earlier calls spent from the time. */
static fathom_status begin_keeping(const trace_tracer *tracer, keeping *keep, job_options *options) {
    char name[128];
    fathom_status status = FATHOM_OK;
    trace_identity(tracer, name);
    if (keep->part) status = part_begin(keep->part, name, &options->share);
    if (keep->saving) {
        status = checkpoint_begin(keep->saving, name);
        options->deadline -= checkpoint_before(keep->saving).seconds;
        options->saving = keep->saving;
    }
    if (status == FATHOM_OK && keep->ranks)
        status = ranks_begin(keep->ranks, name, keep->saving, &options->share);
    return status;
}

/* Keeping begins after the plan, because a part's head holds results of the plan. */
static fathom_status render_traced(build *b, keeping *keep, job_options *options) {
    fathom_status status = make_plan(b);
    if (status == FATHOM_OK) status = begin_keeping(b->tracer, keep, options);
    if (status == FATHOM_OK) status = run_plan(b->context, b->plan, options, b->film);
    if (b->plan) b->film->stats.image_bytes = b->sky_bytes + texturing_peak(b->plan->texturing);
    plan_destroy(b->plan);
    return status;
}

static void warn_of(void *user, const char *text) { warn(user, "%s", text); }

static fathom_status render_scene(fathom_context *context, const fathom_scene *scene,
                                  const fathom_settings *settings, keeping *keep, job_options *options,
                                  fathom_film *film) {
    double began = clock_seconds();
    world *w;
    fathom_status status = world_create(scene, &w);
    if (status != FATHOM_OK) return status;
    status = world_check(w);
    if (status == FATHOM_OK) lacks_find(w, settings->integrator, warn_of, context);
    build b = {.context = context,
               .world = w,
               .settings = settings,
               .film = film,
               .progress = options->progress,
               .progress_user = options->user,
               .began = began};
    if (status == FATHOM_OK) status = run_build(&b);
    film->stats.build_seconds = clock_seconds() - began;
    if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    if (status == FATHOM_OK) status = count_scene(w, b.tracer, film, &film->stats);
    options->deadline = began + settings->max_time;
    if (status == FATHOM_OK)
        status = render_traced(&b, keep, options);
    else
        texture_cache_close(b.textures);
    trace_destroy(b.tracer);
    world_destroy(w);
    return status;
}

/* Reports errors before the world is built, which can take long. */
static fathom_status check(fathom_context *context, const fathom_scene *scene,
                           const fathom_settings *settings) {
    trace_spec spec;
    fathom_status status = scene_check_settings(context, settings);
    if (status == FATHOM_OK) status = trace_spec_parse(context, settings->tracer, &spec);
    if (status == FATHOM_OK && settings->memory_limit && spec.kind != TRACE_EMBREE)
        warn(context, "the memory limit has no effect: only the tracer embree has one");
    return status == FATHOM_OK ? fathom_scene_check(scene) : status;
}

fathom_status render_fingerprint(const fathom_scene *scene, uint64_t *out) {
    const fathom_status status = scene_fingerprint(scene, out);
    const uint64_t files = status == FATHOM_OK ? texture_color_files(scene) : 0;
    if (files) *out = hash_of((uint64_t[]){*out, files}, 2 * sizeof files);
    return status;
}

/* Renders into an existing film. */
static fathom_status fill(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          const render_request *request, fathom_film *film) {
    job_options options = {.reserve = request->reserve,
                           .live = request->on_film,
                           .progress = request->progress,
                           .user = request->user};
    keeping keep = {.saving = NULL};
    fathom_status status = render_fingerprint(scene, &film->stats.scene_fingerprint);
    context_note_opened(context, false);
    if (status == FATHOM_OK && request->saving)
        status = checkpoint_open(context, request->saving, scene, settings, film, &keep.saving);
    if (status == FATHOM_OK && request->part)
        status = part_open(context, request->part, settings, film, &keep.part);
    if (status == FATHOM_OK && request->ranks)
        status = ranks_open(context, request->ranks, settings, film, &keep.ranks);
    if (status == FATHOM_OK && request->on_film) request->on_film(request->user, film);
    if (status == FATHOM_OK) status = render_scene(context, scene, settings, &keep, &options, film);
    if (request->on_film) request->on_film(request->user, NULL);
    status = ranks_close(keep.ranks, status);
    checkpoint_close(keep.saving);
    return part_close(keep.part, status);
}

fathom_status render_film(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          const render_request *request, fathom_stats *stats, fathom_film **out) {
    const fathom_scene view = scene_through(scene, context);
    fathom_film *film;
    *out = NULL;
    fathom_status status = check(context, &view, settings);
    if (status == FATHOM_OK) status = film_create(context, &view, settings, &film);
    if (status != FATHOM_OK) return status;
    status = fill(context, &view, settings, request, film);
    fathom_status changed = FATHOM_OK;
    if (status != FATHOM_OUT_OF_RESOURCES) {
        /* If the scene's files changed during the render, the image is invalid and may be the cause of any
         * failure. */
        changed = fathom_scene_check_files(&view);
        if (changed != FATHOM_OK) status = changed;
    }
    if (stats) *stats = film->stats;
    film->interrupted = status == FATHOM_INTERRUPTED;
    film_settle_errors(film);
    const bool doubtful = changed != FATHOM_OK && request->keep_changed && film->stats.samples;
    if (status == FATHOM_OK || status == FATHOM_INTERRUPTED || doubtful)
        *out = film;
    else
        fathom_film_destroy(film);
    return status;
}
