/* The public API for rays of one's own.
 *
 * Rays are moved near the world's origin in double before they become float, and t, point and normals of
 * what they hit are computed in double. So that a hit is in the interval exactly when its double t is, the
 * float ray's interval is a little wider, and a hit outside the user's is passed by. */
#include "trace/user_hit.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

struct fathom_tracer {
    fathom_context *context;
    pthread_mutex_t message; /* guards the context's message: calls may run at the same time */
    fathom_scene scene;      /* the caller's, seen through this context */
    world *world;
    trace_tracer *tracer;
};

/* ---- life ---- */

fathom_status fathom_tracer_create(fathom_context *context, const fathom_scene *scene,
                                   fathom_tracer_kind kind, fathom_tracer **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !scene) return fail_null(context, "scene");
    if ((unsigned)kind > FATHOM_TRACER_REFERENCE)
        return fail_field(context, FATHOM_BAD_USAGE, "tracer", "there is no kind %u", (unsigned)kind);
    fathom_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->context = context;
    tracer->scene = scene_through(scene, context);
    pthread_mutex_init(&tracer->message, NULL);
    trace_options options = {.kind = kind, .width = LANES, .threads = fathom_context_threads(context)};
    fathom_status status = fathom_scene_check(&tracer->scene);
    if (status == FATHOM_OK) status = world_create(&tracer->scene, &tracer->world);
    if (status == FATHOM_OK) status = trace_create(context, tracer->world, &options, &tracer->tracer);
    if (status != FATHOM_OK) {
        fathom_tracer_destroy(tracer);
        return status;
    }
    *out = tracer;
    return FATHOM_OK;
}

void fathom_tracer_destroy(fathom_tracer *tracer) {
    if (!tracer) return;
    trace_destroy(tracer->tracer);
    world_destroy(tracer->world);
    pthread_mutex_destroy(&tracer->message);
    free(tracer);
}

/* ---- rays ---- */

/* A ray as it is traced: t_user = (t + skipped) 2^exponent. */
typedef struct user_ray {
    vec3_f64 org, dir;
    double skipped, t_min, t_max; /* in the traced ray's units */
    int exponent;
} user_ray;

static fathom_status refuse(const fathom_tracer *tracer, size_t index, const char *what) {
    fathom_tracer *own = (fathom_tracer *)(uintptr_t)tracer;
    pthread_mutex_lock(&own->message);
    fail_item(tracer->context, FATHOM_BAD_USAGE, "rays", index, "%s", what);
    pthread_mutex_unlock(&own->message);
    return FATHOM_BAD_USAGE;
}

static fathom_status refuse_null(const fathom_tracer *tracer, const char *argument) {
    fathom_tracer *own = (fathom_tracer *)(uintptr_t)tracer;
    pthread_mutex_lock(&own->message);
    fail_null(tracer->context, argument);
    pthread_mutex_unlock(&own->message);
    return FATHOM_BAD_USAGE;
}

static bool in_range(vec3_f64 p) {
    return fabs(p.x) < WORLD_REACH && fabs(p.y) < WORLD_REACH && fabs(p.z) < WORLD_REACH;
}

/* Scales the direction by a power of two, exactly, so that any length is good. Moves the origin to a negative
 * t_min, so that the traced interval begins at 0. */
static const char *ray_prepare(const world *w, const fathom_ray *ray, user_ray *out) {
    vec3_f64 org = load_f64(ray->origin), dir = load_f64(ray->direction);
    if (!finite_f64(org)) return "origin: is not finite";
    if (!finite_f64(dir)) return "direction: is not finite";
    double longest = fmax(fabs(dir.x), fmax(fabs(dir.y), fabs(dir.z)));
    if (!(longest > 0)) return "direction: is zero";
    if (!isfinite(ray->t_min)) return "t_min: is not finite";
    if (isnan(ray->t_max)) return "t_max: is not a number";
    frexp(longest, &out->exponent);
    out->dir =
        vec_f64(ldexp(dir.x, -out->exponent), ldexp(dir.y, -out->exponent), ldexp(dir.z, -out->exponent));
    double t_min = ldexp(ray->t_min, out->exponent), t_max = ldexp(ray->t_max, out->exponent);
    out->skipped = t_min < 0 ? t_min : 0;
    out->org = madd_f64(sub_f64(org, w->origin), out->skipped, out->dir);
    out->t_min = t_min - out->skipped, out->t_max = t_max - out->skipped;
    if (!in_range(out->org)) return "origin: lies more than 1e18 from the scene";
    return NULL;
}

/* Float moves the origin by half a unit of its coordinates, the direction by half a unit, and t by a few
 * units of what it is computed from: 16 units of t and of the origin's distance cover them on surfaces that
 * are not grazed. */
static void ray_narrow(const user_ray *ray, trace_rays *rays, unsigned lane) {
    double size = length_f64(ray->org), slack = 16 * 0x1p-24;
    double t_near = ray->t_min - slack * (ray->t_min + size),
           t_far = ray->t_max + slack * (ray->t_max + size);
    rays->org_x[lane] = (float)ray->org.x, rays->org_y[lane] = (float)ray->org.y,
    rays->org_z[lane] = (float)ray->org.z;
    rays->dir_x[lane] = (float)ray->dir.x, rays->dir_y[lane] = (float)ray->dir.y,
    rays->dir_z[lane] = (float)ray->dir.z;
    rays->t_near[lane] = t_near > 0 ? (float)t_near : 0;
    rays->t_far[lane] = ray->t_min < ray->t_max ? (float)t_far : -1;
}

/* Looks at what each lane met. A hit outside the interval is passed by: true when a lane has to go on. */
static bool take_hits(const fathom_tracer *tracer, const user_ray *rays, trace_block *block, unsigned lanes,
                      const float *t_far, fathom_hit *hits) {
    bool again = false;
    for (unsigned i = 0; i < lanes; ++i) {
        if (!(block->rays.t_near[i] < t_far[i]) || block->hits.geometry[i] == FATHOM_NONE) {
            block->rays.t_far[i] = -1;
            continue;
        }
        const user_ray *ray = &rays[i];
        float met = block->rays.t_far[i];
        user_hit_resolve(tracer->world, block, i, ray->org, ray->dir, &hits[i]);
        bool inside = hits[i].t > ray->t_min && hits[i].t < ray->t_max;
        hits[i].t = inside ? ldexp(hits[i].t + ray->skipped, -ray->exponent) : HUGE_VAL;
        block->rays.t_near[i] = met; /* the interval is open, so the ray goes on behind this hit */
        block->rays.t_far[i] = inside ? -1 : t_far[i];
        again = again || !inside;
    }
    return again;
}

/* Up to 16 rays. A lane that is done has an empty interval. */
static void closest_block(const fathom_tracer *tracer, const user_ray *rays, unsigned lanes,
                          fathom_hit *hits) {
    trace_block block = {0};
    float t_far[LANES];
    for (unsigned i = 0; i < lanes; ++i) {
        ray_narrow(&rays[i], &block.rays, i);
        hits[i].t = HUGE_VAL;
    }
    bool again = true;
    while (again) {
        for (unsigned i = 0; i < lanes; ++i) t_far[i] = block.rays.t_far[i];
        trace_closest(tracer->tracer, &block, lanes, TRACE_INCOHERENT);
        again = take_hits(tracer, rays, &block, lanes, t_far, hits);
    }
}

static fathom_status trace_user(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                fathom_hit *hits, bool *met) {
    for (size_t first = 0; first < count; first += LANES) {
        unsigned lanes = count - first < LANES ? (unsigned)(count - first) : LANES;
        user_ray own[LANES];
        fathom_hit found[LANES];
        for (unsigned i = 0; i < lanes; ++i) {
            const char *wrong = ray_prepare(tracer->world, &rays[first + i], &own[i]);
            if (wrong) return refuse(tracer, first + i, wrong);
        }
        unsigned mode = trace_thread_begin();
        closest_block(tracer, own, lanes, hits ? &hits[first] : found);
        trace_thread_end(mode);
        for (unsigned i = 0; met && i < lanes; ++i) met[first + i] = found[i].t < HUGE_VAL;
    }
    return FATHOM_OK;
}

fathom_status fathom_tracer_closest(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                    fathom_hit *hits) {
    if (!tracer) return FATHOM_BAD_USAGE;
    if (count && !(rays && hits)) return refuse_null(tracer, rays ? "hits" : "rays");
    return trace_user(tracer, rays, count, hits, NULL);
}

/* By closest hits: shadow rays would pass through what casts none. */
fathom_status fathom_tracer_any(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                bool *hits) {
    if (!tracer) return FATHOM_BAD_USAGE;
    if (count && !(rays && hits)) return refuse_null(tracer, rays ? "hits" : "rays");
    return trace_user(tracer, rays, count, NULL, hits);
}
