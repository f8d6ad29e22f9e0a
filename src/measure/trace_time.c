#include "measure/trace_time.h"

#include "base/clock.h"
#include "base/threads.h"
#include "camera/camera.h"
#include "light/light.h"
#include "verify/search/rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    bare_query query;
    trace_coherence coherence;
} kinds[TRACE_SETS] = {[TRACE_SET_CAMERA] = {"camera", BARE_CLOSEST, TRACE_COHERENT},
                       [TRACE_SET_BOUNCE] = {"bounce", BARE_CLOSEST, TRACE_INCOHERENT},
                       [TRACE_SET_SHADOW] = {"shadow", BARE_ANY, TRACE_COHERENT},
                       [TRACE_SET_BETWEEN] = {"between", BARE_ANY, TRACE_INCOHERENT}};

const char *trace_set_name(trace_set_kind kind) { return kinds[kind].name; }
bare_query trace_set_query(trace_set_kind kind) { return kinds[kind].query; }
trace_coherence trace_set_coherence(trace_set_kind kind) { return kinds[kind].coherence; }

static bool set_create(size_t blocks, trace_set *out) {
    out->blocks = aligned_alloc(64, blocks * sizeof *out->blocks);
    out->count = out->blocks ? blocks : 0;
    if (out->blocks) memset(out->blocks, 0, blocks * sizeof *out->blocks);
    return out->blocks != NULL;
}

static void set_ray(trace_set *set, size_t i, vec3_f32 org, vec3_f32 dir, float t_near, float t_far) {
    trace_rays *r = &set->blocks[i / LANES];
    size_t k = i % LANES;
    r->org_x[k] = org.x, r->org_y[k] = org.y, r->org_z[k] = org.z, r->t_near[k] = t_near;
    r->dir_x[k] = dir.x, r->dir_y[k] = dir.y, r->dir_z[k] = dir.z, r->t_far[k] = t_far;
}

/* ---- from the camera ---- */

static bool make_camera(const world *w, uint64_t rays, trace_set *out) {
    const fathom_settings *s = &w->scene->settings;
    double aspect = (double)s->width / s->height;
    uint32_t across = (uint32_t)fmax(1, round(sqrt((double)rays * aspect) / 4));
    uint32_t down = (uint32_t)fmax(1, round((double)rays / (16.0 * across)));
    shade_camera camera;
    camera_prepare(&w->scene->camera, across * 4, down * 4, w->origin, &camera);
    if (!set_create((size_t)across * down, out)) return false;
    for (size_t b = 0; b < out->count; ++b) {
        for (size_t k = 0; k < LANES; ++k) {
            double x = (double)(b % across * 4 + k % 4), y = (double)(b / across * 4 + k / 4);
            set_ray(out, b * LANES + k, camera.eye, camera_direction(&camera, x + 0.5, y + 0.5), 0, INFINITY);
        }
    }
    return true;
}

/* ---- from what it sees ---- */

/* A point as float has it, and how far from the eye. */
typedef struct seen {
    vec3_f32 point;
    float t;
} seen;

typedef ARRAY(seen) seen_points;

static bool find_seen(const trace_tracer *tracer, const trace_set *camera, seen_points *out) {
    unsigned state = trace_thread_begin();
    bool ok = true;
    for (size_t b = 0; b < camera->count && ok; ++b) {
        trace_block block = {.rays = camera->blocks[b]};
        trace_closest(tracer, &block, LANES, TRACE_COHERENT);
        for (unsigned k = 0; k < LANES && ok; ++k) {
            const trace_rays *r = &block.rays;
            if (block.hits.geometry[k] == FATHOM_NONE) continue;
            vec3_f32 point = madd_f32(trace_org(r, k), r->t_far[k], trace_dir(r, k));
            ok = array_push(out, ((seen){point, r->t_far[k]}));
        }
    }
    trace_thread_end(state);
    return ok;
}

/* Such rays begin where their own surface is behind them, by far more than float rounds: a ten-thousandth of
 * the distance from the eye. */
#define OFF 1e-4f

static void shadow_ray(trace_set *set, size_t i, const seen *from, const shade_light *light) {
    vec3_f32 to = light->to_light;
    float far = INFINITY;
    if (light->type != FATHOM_LIGHT_DIRECTIONAL) {
        to = sub_f32(light->position, from->point);
        far = sqrtf(dot_f32(to, to));
        to = scale_f32(1 / far, to);
    }
    set_ray(set, i, from->point, to, OFF * from->t, far);
}

static void bounce_ray(trace_set *set, size_t i, const seen *from) {
    rays_random random = rays_random_of(1, TRACE_SET_BOUNCE, i);
    vec3_f64 d = rays_direction(&random);
    vec3_f32 dir = {(float)d.x, (float)d.y, (float)d.z};
    set_ray(set, i, from->point, dir, OFF * from->t, INFINITY);
}

static const seen *any_of(const seen_points *points, rays_random *random) {
    return &points->items[(size_t)(rays_unit(random) * (double)points->count)];
}

/* The direction has length 1, so that distances from the eye are in the ray's unit. */
static void between_ray(trace_set *set, size_t i, const seen_points *points) {
    rays_random random = rays_random_of(1, TRACE_SET_BETWEEN, i);
    const seen *from = any_of(points, &random), *to = any_of(points, &random);
    vec3_f32 d = sub_f32(to->point, from->point);
    float length = sqrtf(dot_f32(d, d));
    d = length > 0 ? scale_f32(1 / length, d) : (vec3_f32){0, 1, 0};
    set_ray(set, i, from->point, d, OFF * from->t, fmaxf(length - OFF * to->t, OFF * from->t));
}

/* From above where there is no light. */
static shade_light first_light(const world *w) {
    shade_light light = {.type = FATHOM_LIGHT_DIRECTIONAL, .to_light = {0, 1, 0}};
    if (w->scene->lights.count) light_prepare(&w->scene->lights.items[0], w->origin, &light);
    return light;
}

static bool make_others(const world *w, const seen_points *points, trace_set out[TRACE_SETS]) {
    const shade_light light = first_light(w);
    size_t blocks = points->count / LANES + !(points->count / LANES);
    for (int s = TRACE_SET_CAMERA + 1; s < TRACE_SETS; ++s) {
        if (!set_create(blocks, &out[s])) return false;
    }
    for (size_t i = 0; i < blocks * LANES; ++i) {
        const seen *from = &points->items[i % points->count];
        shadow_ray(&out[TRACE_SET_SHADOW], i, from, &light);
        bounce_ray(&out[TRACE_SET_BOUNCE], i, from);
        between_ray(&out[TRACE_SET_BETWEEN], i, points);
    }
    return true;
}

fathom_status trace_sets_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                                uint64_t rays, trace_set out[TRACE_SETS]) {
    memset(out, 0, TRACE_SETS * sizeof *out);
    seen_points points = {.items = NULL};
    bool ok =
        make_camera(w, rays, &out[TRACE_SET_CAMERA]) && find_seen(tracer, &out[TRACE_SET_CAMERA], &points);
    bool none = ok && points.count == 0;
    if (ok && !none) ok = make_others(w, &points, out);
    array_free(&points);
    if (none)
        return fail(context, FATHOM_BAD_INPUT,
                    "the camera sees nothing; expected hits to send further rays from");
    return ok ? FATHOM_OK : fail_memory(context, (size_t)rays * sizeof(trace_rays) / LANES);
}

void trace_sets_free(trace_set sets[TRACE_SETS]) {
    for (int s = 0; s < TRACE_SETS; ++s) free(sets[s].blocks);
    memset(sets, 0, TRACE_SETS * sizeof *sets);
}

/* ---- rays a second ---- */

/* Blocks that a thread copies, untimed, and then traces: 4096 rays. */
#define PIECE 256

typedef struct piece {
    trace_block closest[PIECE];
    trace_rays any[PIECE];
} piece;

/* One thread's state; no two share a cache line. */
typedef struct worker {
    _Alignas(64) piece *piece;
    double seconds, cpu;
    uint64_t met;
} worker;

/* One tracer over `blocks` of the set's blocks. */
typedef struct turn {
    const trace_tracer *tracer;
    const trace_set *set;
    trace_set_kind kind;
    size_t blocks;
    worker *workers;
} turn;

static void load(const turn *t, size_t begin, size_t end, piece *p) {
    for (size_t b = begin; b < end; ++b) {
        const trace_rays *rays = &t->set->blocks[b * t->set->count / t->blocks];
        if (trace_set_query(t->kind) == BARE_ANY)
            p->any[b - begin] = *rays;
        else
            p->closest[b - begin].rays = *rays;
    }
}

static uint64_t met(const turn *t, size_t blocks, const piece *p) {
    uint64_t hits = 0;
    for (size_t i = 0; i < blocks * LANES; ++i) {
        size_t b = i / LANES, k = i % LANES;
        hits += trace_set_query(t->kind) == BARE_ANY ? p->any[b].t_far[k] < 0
                                                     : p->closest[b].hits.geometry[k] != FATHOM_NONE;
    }
    return hits;
}

static void run_piece(void *user, size_t begin, size_t end, unsigned index) {
    const turn *t = user;
    worker *w = &t->workers[index];
    trace_coherence coherence = trace_set_coherence(t->kind);
    size_t rays = (end - begin) * LANES;
    unsigned state = trace_thread_begin();
    load(t, begin, end, w->piece);
    double cpu = clock_thread_seconds(), began = clock_seconds();
    if (trace_set_query(t->kind) == BARE_ANY)
        trace_any(t->tracer, w->piece->any, rays, coherence);
    else
        trace_closest(t->tracer, w->piece->closest, rays, coherence);
    w->seconds += clock_seconds() - began;
    w->cpu += clock_thread_seconds() - cpu;
    trace_thread_end(state);
    w->met += met(t, end - begin, w->piece);
}

typedef struct outcome {
    double seconds, cpu; /* of all threads together */
    uint64_t met;
} outcome;

static outcome take_turn(const turn *t, unsigned threads) {
    turn now = *t;
    for (unsigned i = 0; i < threads; ++i)
        t->workers[i].seconds = t->workers[i].cpu = 0, t->workers[i].met = 0;
    size_t share = (t->blocks + threads - 1) / threads;
    loop_parallel(threads, t->blocks, share < PIECE ? share : PIECE, run_piece, &now);
    outcome sum = {0, 0, 0};
    for (unsigned i = 0; i < threads; ++i) {
        sum.seconds += t->workers[i].seconds, sum.cpu += t->workers[i].cpu;
        sum.met += t->workers[i].met;
    }
    return sum;
}

/* How many blocks fit the time, found by doubling; the first are also what warms the caches. */
static size_t fitting_blocks(turn t, const trace_time_options *options) {
    for (t.blocks = 1;; t.blocks *= 2) {
        if (t.blocks > t.set->count) t.blocks = t.set->count;
        double seconds = take_turn(&t, options->threads).cpu / options->threads;
        if (t.blocks == t.set->count && seconds <= options->seconds) return t.blocks;
        if (seconds < options->seconds / 16 && t.blocks < t.set->count) continue;
        double fit = (double)t.blocks * options->seconds / seconds;
        if (fit < 1) return 1;
        return fit < (double)t.set->count ? (size_t)fit : t.set->count;
    }
}

/* ---- all of them ---- */

typedef struct samples {
    double per_second[TRACE_TIME_REPEATS_MAX], per_cpu_second[TRACE_TIME_REPEATS_MAX];
} samples;

/* Finding how many blocks fit takes up to about two turns. */
#define FITTING 2.0

/* turns: that are done. */
static void tell(const trace_time_options *options, size_t count, double turns) {
    bench_watch_tell(options->watch, turns, (options->repeats + FITTING) * (double)(count * TRACE_SETS));
}

static void measure(const trace_tracer *const *tracers, size_t count, turn turns[][TRACE_SETS],
                    const trace_time_options *options, samples *kept, trace_rate (*out)[TRACE_SETS]) {
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        turn *t = &turns[i / TRACE_SETS][i % TRACE_SETS];
        t->tracer = tracers[i / TRACE_SETS];
        t->blocks = fitting_blocks(*t, options);
        tell(options, count, FITTING * (double)(i + 1));
    }
    const double fitted = FITTING * (double)(count * TRACE_SETS);
    for (unsigned k = 0; k < options->repeats; ++k) {
        for (size_t i = 0; i < count * TRACE_SETS; ++i) {
            size_t tracer = (i + k) % count, set = i / count;
            const turn *t = &turns[tracer][set];
            outcome o = take_turn(t, options->threads);
            double rays = (double)(t->blocks * LANES);
            samples *to = &kept[tracer * TRACE_SETS + set];
            to->per_second[k] = rays * options->threads / o.seconds;
            to->per_cpu_second[k] = rays / o.cpu;
            tell(options, count, fitted + (double)(k * count * TRACE_SETS + i + 1));
            out[tracer][set].rays = t->blocks * LANES, out[tracer][set].met = o.met;
        }
    }
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        trace_rate *rate = &out[i / TRACE_SETS][i % TRACE_SETS];
        rate->per_second = quartiles_of(kept[i].per_second, options->repeats);
        rate->per_cpu_second = quartiles_of(kept[i].per_cpu_second, options->repeats);
    }
}

static bool workers_create(unsigned threads, worker **out) {
    worker *workers = aligned_alloc(64, threads * sizeof *workers);
    bool ok = workers != NULL;
    for (unsigned i = 0; i < threads && workers; ++i) {
        workers[i].piece = aligned_alloc(64, sizeof *workers[i].piece);
        ok &= workers[i].piece != NULL;
    }
    *out = workers;
    return ok;
}

fathom_status trace_time_measure(fathom_context *context, const trace_tracer *const *tracers, size_t count,
                                 const trace_set sets[TRACE_SETS], const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS]) {
    worker *workers;
    bool ok = workers_create(options->threads, &workers);
    samples *kept = calloc(count * TRACE_SETS, sizeof *kept);
    turn turns[TRACE_TIME_TRACERS_MAX][TRACE_SETS];
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        size_t set = i % TRACE_SETS;
        turns[i / TRACE_SETS][set] =
            (turn){.set = &sets[set], .kind = (trace_set_kind)set, .workers = workers};
    }
    if (ok && kept) measure(tracers, count, turns, options, kept, out);
    for (unsigned i = 0; i < options->threads && workers; ++i) free(workers[i].piece);
    free(workers);
    fathom_status status = ok && kept ? FATHOM_OK : fail_memory(context, sizeof(piece));
    free(kept);
    return status;
}
