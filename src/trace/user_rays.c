/* The public API for the user's own rays. Rays are converted to world coordinates in double and then to
 * float; t, point and normals of hits are computed in double. A hit counts if its double t is in the
 * interval: the float ray's interval is slightly wider, and hits outside the user's interval are skipped. */
#include "reference/reference.h"
#include "trace/approach.h"
#include "trace/trace.h"

#include <fathom/trace.h>

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

/* ---- hits: point, normals, uv and ids, in double ---- */

/* A hit in the space of its geometry. Normals need not be unit. */
typedef struct local_hit {
    double t;
    vec3_f64 point, geometric, shading;
    double u, v;
} local_hit;

static double clamp_unit(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

static vec3_f64 weighted(const vec3_f64 v[3], double u, double w) {
    return madd_f64(madd_f64(scale_f64(1 - u - w, v[0]), u, v[1]), w, v[2]);
}

/* ---- shapes ---- */

/* The root nearest to t; if the double ray misses, the point of closest approach. */
static local_hit sphere_hit(const world_sphere *s, vec3_f64 org, vec3_f64 dir, double t) {
    double roots[2], radius = world_sphere_radius(s);
    vec3_f64 center = world_sphere_center(s), from = sub_f64(org, center);
    if (sphere_roots_f64(center, radius, org, dir, roots))
        t = fabs(roots[0] - t) <= fabs(roots[1] - t) ? roots[0] : roots[1];
    else
        t = -dot_f64(from, dir) / dot_f64(dir, dir);
    vec3_f64 n = normalize_f64(madd_f64(from, t, dir));
    double phi = atan2(n.y, n.x);
    return (local_hit){.t = t,
                       .point = madd_f64(center, radius, n),
                       .geometric = n,
                       .shading = n,
                       .u = (phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI),
                       .v = acos(n.z < -1 ? -1 : (n.z > 1 ? 1 : n.z)) / M_PI};
}

/* For a double ray that misses the triangle: its hit with the plane of a, b and c, and the clamped weights of
 * b and c there. */
static reference_hit_f64 nearest_hit(vec3_f64 a, vec3_f64 b, vec3_f64 c, vec3_f64 org, vec3_f64 dir,
                                     double t) {
    const vec3_f64 e = sub_f64(b, a), g = sub_f64(c, a), n = cross_f64(e, g);
    const double exact = dot_f64(sub_f64(a, org), n) / dot_f64(dir, n), n2 = dot_f64(n, n);
    if (isfinite(exact)) t = exact;
    const vec3_f64 q = sub_f64(madd_f64(org, t, dir), a);
    return (reference_hit_f64){t, clamp_unit(dot_f64(cross_f64(q, g), n) / n2),
                               clamp_unit(dot_f64(cross_f64(e, q), n) / n2)};
}

static local_hit quad_hit(const world_quad *quad, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 c[4];
    for (int i = 0; i < 4; ++i) c[i] = widen(quad->corner[i]);
    reference_hit_f64 hit = {.t = t};
    if (!quad_robust_f64(c[0], c[1], c[2], c[3], org, dir, -INFINITY, INFINITY, &hit)) {
        hit = nearest_hit(c[0], c[1], c[3], org, dir, t);
        if (hit.u + hit.v > 1) {
            hit = nearest_hit(c[2], c[3], c[1], org, dir, t);
            hit.u = 1 - hit.u, hit.v = 1 - hit.v;
        }
    }
    const vec3_f64 near[3] = {c[0], c[1], c[3]}, far[3] = {c[2], c[3], c[1]};
    vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    return (local_hit){.t = hit.t,
                       .point = hit.u + hit.v <= 1 ? weighted(near, hit.u, hit.v)
                                                   : weighted(far, 1 - hit.u, 1 - hit.v),
                       .geometric = n,
                       .shading = n,
                       .u = hit.u,
                       .v = hit.v};
}

static local_hit plane_hit(const world_plane *plane, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double exact = dot_f64(sub_f64(point, org), n) / dot_f64(dir, n);
    if (isfinite(exact)) t = exact;
    vec3_f64 p = madd_f64(org, t, dir), q = sub_f64(p, point);
    return (local_hit){.t = t,
                       .point = p,
                       .geometric = n,
                       .shading = n,
                       .u = dot_f64(q, widen(plane->u)),
                       .v = dot_f64(q, widen(plane->v))};
}

static void mesh_attributes(const fathom_mesh *mesh, uint32_t triangle, local_hit *hit) {
    size_t first = 3 * (size_t)triangle;
    double u = hit->u, v = hit->v;
    if (mesh->normals) {
        const uint32_t *index = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + first;
        vec3_f64 n[3];
        for (int c = 0; c < 3; ++c)
            n[c] = normalize_f64(widen(load_f32(mesh_row(mesh->normals, mesh->normal_stride, index[c]))));
        vec3_f64 shading = weighted(n, u, v);
        if (finite_f64(shading) && dot_f64(shading, shading) > 0) hit->shading = shading;
    }
    if (mesh->uvs) {
        const uint32_t *index = (mesh->uv_indices ? mesh->uv_indices : mesh->indices) + first;
        const float *uv[3];
        for (int c = 0; c < 3; ++c) uv[c] = mesh_row(mesh->uvs, mesh->uv_stride, index[c]);
        hit->u = (1 - u - v) * (double)uv[0][0] + u * (double)uv[1][0] + v * (double)uv[2][0];
        hit->v = (1 - u - v) * (double)uv[0][1] + u * (double)uv[1][1] + v * (double)uv[2][1];
    }
}

static local_hit mesh_hit(const fathom_mesh *mesh, uint32_t triangle, vec3_f64 org, vec3_f64 dir, double t) {
    vec3_f64 c[3];
    for (int i = 0; i < 3; ++i)
        c[i] = widen(load_f32(mesh_vertex(mesh, mesh->indices[3 * (size_t)triangle + (size_t)i])));
    vec3_f64 n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[2], c[0]));
    reference_hit_f64 hit = {.t = t};
    if (!triangle_robust_f64(c[0], c[1], c[2], org, dir, -INFINITY, INFINITY, &hit)) {
        hit = nearest_hit(c[0], c[1], c[2], org, dir, t);
        if (hit.u + hit.v > 1) hit.v = 1 - hit.u;
    }
    local_hit out = {
        .t = hit.t, .point = weighted(c, hit.u, hit.v), .geometric = n, .shading = n, .u = hit.u, .v = hit.v};
    mesh_attributes(mesh, triangle, &out);
    return out;
}

/* ---- from the geometry's space to the scene's ---- */

static local_hit geometry_hit(const world *w, const world_geometry *geometry, uint32_t primitive,
                              vec3_f64 org, vec3_f64 dir, double t) {
    switch (geometry->kind) {
    case WORLD_SPHERES: return sphere_hit(&w->spheres.items[geometry->first + primitive], org, dir, t);
    case WORLD_QUADS: return quad_hit(&w->quads.items[geometry->first + primitive], org, dir, t);
    case WORLD_MESH: break;
    }
    return mesh_hit(&w->meshes.items[geometry->first], primitive, org, dir, t);
}

/* A hit in an instance. It inverts the rounded map in double, so that a transform there and back loses
 * nothing. */
static local_hit instance_hit(const world *w, const world_instance *instance, const world_geometry *geometry,
                              uint32_t primitive, vec3_f64 org, vec3_f64 dir, double t) {
    const affine_f64 to_world = affine_widen(instance->to_world);
    affine_f64 to_object = affine_widen(instance->to_object);
    affine_invert(&to_world, &to_object);
    local_hit hit = geometry_hit(w, geometry, primitive, affine_point(&to_object, org),
                                 affine_vector(&to_object, dir), t);
    hit.point = affine_point(&to_world, hit.point);
    hit.geometric = affine_transposed_vector(&to_object, normalize_f64(hit.geometric));
    hit.shading = affine_transposed_vector(&to_object, normalize_f64(hit.shading));
    return hit;
}

static void set_out(const world *w, const local_hit *hit, fathom_hit *out) {
    out->t = hit->t;
    store_f64(out->position, add_f64(hit->point, w->origin));
    store_f32(out->geometric_normal, narrow(normalize_f64(hit->geometric)));
    store_f32(out->shading_normal, narrow(normalize_f64(hit->shading)));
    out->u = (float)hit->u, out->v = (float)hit->v;
}

/* Computes the lane's hit for the ray org + t dir in world coordinates. If the double ray just misses the
 * primitive, it takes the nearest point. */
static void resolve_hit(const world *w, const trace_block *block, unsigned lane, vec3_f64 org, vec3_f64 dir,
                        fathom_hit *out) {
    uint32_t geometry = block->hits.geometry[lane], primitive = block->hits.primitive[lane];
    uint32_t instance = block->hits.instance[lane];
    double t = (double)block->rays.t_far[lane];
    local_hit hit;
    if (geometry == TRACE_PLANE) {
        const world_plane *plane = &w->planes.items[primitive];
        hit = plane_hit(plane, org, dir, t);
        out->object = plane->object, out->material = plane->material;
        out->primitive = 0, out->instance = FATHOM_NONE;
    } else {
        const world_geometry *g = &w->geometries.items[geometry];
        const world_instance *placed = instance == FATHOM_NONE ? NULL : &w->instances.items[instance];
        hit = placed ? instance_hit(w, placed, g, primitive, org, dir, t)
                     : geometry_hit(w, g, primitive, org, dir, t);
        out->object = world_object(w, geometry, primitive);
        out->material = world_material(w, geometry, primitive, instance);
        out->primitive = world_primitive(w, geometry, primitive);
        out->instance = placed ? placed->id : g->instance;
    }
    set_out(w, &hit, out);
}

struct fathom_tracer {
    fathom_context *context;
    pthread_mutex_t message; /* guards the context's message: calls may run at the same time */
    fathom_scene scene;      /* the caller's scene with this context */
    world *world;
    trace_tracer *tracer;
    trace_approach approach;
};

fathom_status fathom_tracer_check(fathom_context *context, const char *words) {
    trace_spec spec;
    return trace_spec_parse(context, words, &spec);
}

fathom_status fathom_tracer_create(fathom_context *context, const fathom_scene *scene, const char *words,
                                   fathom_tracer **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !scene) return fail_null(context, "scene");
    trace_spec spec; /* reports a wrong word before the world is built */
    fathom_status status = trace_spec_parse(context, words, &spec);
    if (status != FATHOM_OK) return status;
    fathom_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->context = context;
    tracer->scene = scene_through(scene, context);
    pthread_mutex_init(&tracer->message, NULL);
    trace_options options = {.spec = &spec, .width = LANES, .threads = fathom_context_threads(context)};
    status = fathom_scene_check(&tracer->scene);
    if (status == FATHOM_OK) status = world_create(&tracer->scene, &tracer->world);
    if (status == FATHOM_OK) tracer->world->one_sided = false; /* callers ask for the nearest hit */
    if (status == FATHOM_OK) status = trace_approach_find(tracer->world, &tracer->approach);
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

/* The traced ray: t_user = (t + skipped) 2^-exponent. */
typedef struct user_ray {
    vec3_f64 org, dir;
    double skipped, t_min, t_max; /* in the traced ray's units */
    int exponent;
} user_ray;

/* what: the problem of ray `index`. NULL: the argument `null` is NULL. */
static fathom_status refuse(const fathom_tracer *tracer, const char *what, size_t index, const char *null) {
    fathom_tracer *own = (fathom_tracer *)(uintptr_t)tracer;
    pthread_mutex_lock(&own->message);
    if (what)
        fail_item(tracer->context, FATHOM_BAD_USAGE, "rays", index, "%s", what);
    else
        fail_null(tracer->context, null);
    pthread_mutex_unlock(&own->message);
    return FATHOM_BAD_USAGE;
}

/* Scales the direction by a power of two, and moves the origin to where the ray starts. Returns NULL, or the
 * problem. */
static const char *ray_prepare(const fathom_tracer *tracer, const fathom_ray *ray, user_ray *out) {
    vec3_f64 org = load_f64(ray->origin), dir = load_f64(ray->direction);
    if (!finite_f64(org)) return "origin: is not finite";
    if (!finite_f64(dir)) return "direction: is not finite";
    const double longest = largest_f64(dir);
    if (!(longest > 0)) return "direction: is zero";
    if (!isfinite(ray->t_min)) return "t_min: is not finite";
    if (isnan(ray->t_max)) return "t_max: is not a number";
    frexp(longest, &out->exponent);
    out->dir =
        vec_f64(ldexp(dir.x, -out->exponent), ldexp(dir.y, -out->exponent), ldexp(dir.z, -out->exponent));
    double t_min = ldexp(ray->t_min, out->exponent), t_max = ldexp(ray->t_max, out->exponent);
    org = sub_f64(org, tracer->world->origin);
    if (!(largest_f64(org) < WORLD_REACH)) return "origin: lies more than 1e18 from the scene";
    out->skipped = trace_approach_start(&tracer->approach, org, out->dir, t_min < 0 ? t_min : 0);
    out->org = madd_f64(org, out->skipped, out->dir);
    out->t_min = t_min - out->skipped, out->t_max = t_max - out->skipped;
    if (!(largest_f64(out->org) < WORLD_REACH)) return "t_min: lies more than 1e18 from the scene";
    return NULL;
}

/* Rounding to float changes the origin by half a unit of its coordinates, the direction by half a unit, and t
 * by a few units of its inputs. 16 units of t and of the origin's distance cover this, except at grazing
 * angles. */
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

/* Computes the hits of all lanes. Hits outside the user's interval are skipped. True when some lane must
 * continue. */
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
        resolve_hit(tracer->world, block, i, ray->org, ray->dir, &hits[i]);
        bool inside = hits[i].t > ray->t_min && hits[i].t < ray->t_max;
        hits[i].t = inside ? ldexp(hits[i].t + ray->skipped, -ray->exponent) : HUGE_VAL;
        block->rays.t_near[i] = met; /* the interval is open, so the ray continues behind this hit */
        block->rays.t_far[i] = inside ? -1 : t_far[i];
        again = again || !inside;
    }
    return again;
}

/* Traces up to 16 rays. A finished lane has an empty interval. */
static void closest_block(const fathom_tracer *tracer, const user_ray *rays, unsigned lanes,
                          fathom_hit *hits) {
    trace_block block = {0};
    float t_far[LANES];
    for (unsigned i = 0; i < lanes; ++i) {
        ray_narrow(&rays[i], &block.rays, i);
        hits[i].t = HUGE_VAL;
    }
    do {
        for (unsigned i = 0; i < lanes; ++i) t_far[i] = block.rays.t_far[i];
        trace_closest(tracer->tracer, &block, lanes, TRACE_INCOHERENT);
    } while (take_hits(tracer, rays, &block, lanes, t_far, hits));
}

static fathom_status trace_user(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                fathom_hit *hits, bool *met) {
    if (!tracer) return FATHOM_BAD_USAGE;
    if (count && !(rays && (hits || met))) return refuse(tracer, NULL, 0, rays ? "hits" : "rays");
    for (size_t first = 0; first < count; first += LANES) {
        unsigned lanes = 0;
        const char *wrong = NULL;
        user_ray own[LANES];
        fathom_hit found[LANES];
        for (; lanes < LANES && first + lanes < count; ++lanes)
            if ((wrong = ray_prepare(tracer, &rays[first + lanes], &own[lanes]))) break;
        unsigned mode = trace_thread_begin();
        closest_block(tracer, own, lanes, hits ? &hits[first] : found);
        trace_thread_end(mode);
        for (unsigned i = 0; met && i < lanes; ++i) met[first + i] = found[i].t < HUGE_VAL;
        if (wrong) return refuse(tracer, wrong, first + lanes, NULL);
    }
    return FATHOM_OK;
}

fathom_status fathom_tracer_closest(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                    fathom_hit *hits) {
    return trace_user(tracer, rays, count, hits, NULL);
}

/* Uses closest hits, because any-hit queries skip shapes that cast no shadow. */
fathom_status fathom_tracer_any(const fathom_tracer *tracer, const fathom_ray *rays, size_t count,
                                bool *hits) {
    return trace_user(tracer, rays, count, NULL, hits);
}
