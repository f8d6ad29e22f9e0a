#include "measure/trace_sets.h"

#include "camera/camera.h"
#include "light/light.h"
#include "verify/search/rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool set_create(size_t blocks, trace_set *out) {
    out->blocks = aligned_alloc(64, blocks * sizeof *out->blocks);
    out->count = out->blocks ? blocks : 0;
    if (out->blocks) memset(out->blocks, 0, blocks * sizeof *out->blocks);
    return out->blocks != NULL;
}

void trace_sets_free(trace_sets *sets) {
    for (size_t i = 0; i < TRACE_SETS; ++i) free(sets->items[i].blocks);
    *sets = (trace_sets){{{.count = 0}}};
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
            vec3_f32 org, dir;
            camera_ray(&camera, x + 0.5, y + 0.5, &org, &dir);
            set_ray(out, b * LANES + k, org, dir, 0, INFINITY);
        }
    }
    return true;
}

/* ---- from visible points ---- */

/* A visible point, rounded to float, and its distance from the eye. */
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

/* Rays start above their own surface, by this fraction of the distance from the eye: far more than the
 * rounding error of float. */
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

/* The direction has length 1, so distances from the eye are valid as t. */
static void between_ray(trace_set *set, size_t i, const seen_points *points) {
    rays_random random = rays_random_of(1, TRACE_SET_BETWEEN, i);
    const seen *from = any_of(points, &random), *to = any_of(points, &random);
    vec3_f32 d = sub_f32(to->point, from->point);
    float length = sqrtf(dot_f32(d, d));
    d = length > 0 ? scale_f32(1 / length, d) : (vec3_f32){0, 1, 0};
    set_ray(set, i, from->point, d, OFF * from->t, fmaxf(length - OFF * to->t, OFF * from->t));
}

/* The first light; a light from above if the scene has none. */
static shade_light first_light(const world *w) {
    shade_light light = {.type = FATHOM_LIGHT_DIRECTIONAL, .to_light = {0, 1, 0}};
    if (w->scene->lights.count) light_prepare(&w->scene->lights.items[0], w->origin, &light);
    return light;
}

static bool make_others(const world *w, const seen_points *points, trace_set out[TRACE_SETS]) {
    const shade_light light = first_light(w);
    size_t blocks = points->count / LANES + !(points->count / LANES);
    for (int s = TRACE_SET_CAMERA + 1; s < TRACE_SETS; ++s)
        if (!set_create(blocks, &out[s])) return false;
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
    *out = (trace_sets){{[TRACE_SET_CAMERA] = {"camera", false, TRACE_COHERENT, NULL, 0},
                         [TRACE_SET_BOUNCE] = {"bounce", false, TRACE_INCOHERENT, NULL, 0},
                         [TRACE_SET_SHADOW] = {"shadow", true, TRACE_COHERENT, NULL, 0},
                         [TRACE_SET_BETWEEN] = {"between", true, TRACE_INCOHERENT, NULL, 0}}};
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
