#include "measure/trace_sets.h"

#include "camera/camera.h"
#include "integrate/wave.h"
#include "light/light.h"
#include "measure/replay.h"
#include "verify/search/rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool set_create(size_t blocks, trace_set *out) {
    out->blocks = aligned_alloc(64, blocks * sizeof *out->blocks);
    out->count = out->blocks ? blocks : 0;
    if (out->blocks) memset(out->blocks, 0, blocks * sizeof *out->blocks);
    return out->blocks != NULL;
}

void trace_sets_free(trace_sets *sets) {
    for (size_t i = 0; i < sets->count; ++i) free(sets->items[i].blocks);
    sets->count = 0;
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

/* ---- from visible points ---- */

/* A point as float has it, and its distance from the eye. */
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

/* Rays begin a ten-thousandth of the distance from the eye above their own surface: far more than float
 * rounds. */
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

/* A light from above where the scene has none. */
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
                                uint64_t rays, trace_sets *out) {
    *out = (trace_sets){{[TRACE_SET_CAMERA] = {"camera", BARE_CLOSEST, TRACE_COHERENT, NULL, 0},
                         [TRACE_SET_BOUNCE] = {"bounce", BARE_CLOSEST, TRACE_INCOHERENT, NULL, 0},
                         [TRACE_SET_SHADOW] = {"shadow", BARE_ANY, TRACE_COHERENT, NULL, 0},
                         [TRACE_SET_BETWEEN] = {"between", BARE_ANY, TRACE_INCOHERENT, NULL, 0}},
                        TRACE_SETS};
    trace_set *camera = &out->items[TRACE_SET_CAMERA];
    seen_points points = {.items = NULL};
    bool ok = make_camera(w, rays, camera) && find_seen(tracer, camera, &points);
    bool none = ok && points.count == 0;
    if (ok && !none) ok = make_others(w, &points, out->items);
    array_free(&points);
    if (none)
        return fail(context, FATHOM_BAD_INPUT,
                    "the camera sees nothing; expected hits to send further rays from");
    return ok ? FATHOM_OK : fail_memory(context, (size_t)rays * sizeof(trace_rays) / LANES);
}

/* ---- the rays of a render ---- */

enum { DEPTHS = 9 }; /* camera rays and eight bounces */
typedef enum kind { CAMERA, MIRRORED, REFRACTED, SHADOW, KINDS } kind;
_Static_assert(DEPTHS *KINDS == TRACE_SETS_MAX, "a set for each");

typedef struct recording {
    trace_tracer *recorder; /* keeps shadow rays alone: the others wait in the wave's queue */
    record shadows;
    wave wave;
    size_t most; /* rays of each set */
    trace_set sets[DEPTHS][KINDS];
    size_t rays[DEPTHS][KINDS];
} recording;

static bool is_wanted(const recording *r, uint32_t depth, kind k) {
    return depth < DEPTHS && r->rays[depth][k] < r->most;
}

/* False when out of memory. */
static bool keep(recording *r, uint32_t depth, kind k, const trace_rays *from, size_t lane) {
    if (!is_wanted(r, depth, k)) return true;
    trace_set *set = &r->sets[depth][k];
    const size_t i = r->rays[depth][k]++;
    if (!set->blocks) set->blocks = aligned_alloc(64, r->most / LANES * sizeof *set->blocks);
    if (!set->blocks) return false;
    if (i % LANES == 0) memset(&set->blocks[i / LANES], 0, sizeof *set->blocks);
    trace_rays_move(from, lane, &set->blocks[i / LANES], i % LANES);
    return true;
}

static bool keep_waiting(recording *r, uint32_t depth) {
    const path_queue *now = &r->wave.now;
    bool ok = true;
    for (size_t i = 0; i < now->count && ok; ++i) {
        const kind k = depth == 0 ? CAMERA : (i < now->mirrored ? MIRRORED : REFRACTED);
        ok = keep(r, depth, k, &now->rays[i / LANES].rays, i % LANES);
    }
    return ok;
}

static bool keep_shadows(recording *r, uint32_t depth) {
    bool ok = !r->shadows.out_of_memory;
    for (size_t c = 0; c < r->shadows.calls.count; ++c) {
        const record_call *call = &r->shadows.calls.items[c];
        if (depth < DEPTHS) r->sets[depth][SHADOW].coherence = call->coherence;
        for (size_t i = 0; i < call->rays && ok; ++i)
            ok = keep(r, depth, SHADOW, record_block(&r->shadows, call->first + i / LANES), i % LANES);
    }
    record_clear(&r->shadows);
    return ok;
}

static bool record_wave(recording *r, const wave_region *region) {
    memset(r->wave.run.samples.radiance[0], 0, 3 * WAVE_SLOTS * sizeof(float));
    wave_batch batch;
    batch.count = wave_list_squares(region, wave_region_bits(region), batch.squares);
    if (!wave_camera_rays(&r->wave, region, &batch)) return false;
    for (uint32_t depth = 0; r->wave.now.count; ++depth) {
        if (!keep_waiting(r, depth) || !classic_step(&r->wave, depth) || !keep_shadows(r, depth))
            return false;
    }
    return true;
}

static bool is_complete(const recording *r) {
    for (uint32_t i = 0; i < DEPTHS * KINDS; ++i) {
        if (is_wanted(r, i / KINDS, (kind)(i % KINDS))) return false;
    }
    return true;
}

/* Steps of a prime that divides hardly any image's number of waves: wave after wave is far away. */
static bool record_waves(recording *r, const fathom_settings *s) {
    const wave_grid grid = wave_grid_of(0, 0, s->width, s->height);
    const uint64_t prime = grid.count % 7919 ? 7919 : 1;
    for (uint64_t k = 0; k < grid.count && !is_complete(r); ++k) {
        const wave_region region = wave_grid_region(&grid, (uint32_t)(k * prime % grid.count));
        if (!record_wave(r, &region)) return false;
    }
    return true;
}

static void finish(recording *r, trace_sets *out) {
    static const char *const names[KINDS] = {"camera", "mirrored", "refracted", "shadow"};
    for (uint32_t i = 0; i < DEPTHS * KINDS; ++i) {
        const uint32_t depth = i / KINDS, k = i % KINDS;
        trace_set set = r->sets[depth][k];
        set.count = r->rays[depth][k] / LANES;
        set.query = k == SHADOW ? BARE_ANY : BARE_CLOSEST;
        if (k != SHADOW) set.coherence = classic_coherence(depth, k == MIRRORED);
        snprintf(set.name, sizeof set.name, "%u %s", depth, names[k]);
        if (set.count)
            out->items[out->count++] = set;
        else
            free(set.blocks);
    }
}

fathom_status trace_sets_record(fathom_context *context, const render_plan *plan, uint64_t rays,
                                trace_sets *out) {
    out->count = 0;
    static const atomic_bool never = false;
    if (plan->integrator != &integrator_classic)
        return fail(context, FATHOM_BAD_INPUT,
                    "the rays of a path tracer are not recorded; expected the integrator classic");
    render_plan recorded = *plan;
    recording *r = calloc(1, sizeof *r);
    if (!r) return fail_memory(context, sizeof *r);
    r->most = (size_t)(rays + LANES - 1) / LANES * LANES;
    recorded.tracer = r->recorder = record_tracer(plan->tracer, NULL, &r->shadows);
    bool ok = r->recorder && wave_create(&recorded, &never, &classic_stages, &r->wave);
    if (ok) {
        unsigned state = trace_thread_begin();
        ok = record_waves(r, &plan->settings);
        trace_thread_end(state);
        wave_destroy(&r->wave);
    }
    trace_destroy(r->recorder);
    record_free(&r->shadows);
    finish(r, out);
    free(r);
    return ok ? FATHOM_OK : fail_memory(context, (size_t)rays * sizeof(trace_rays) / LANES);
}
