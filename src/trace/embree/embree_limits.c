#include "trace/embree/embree_limits.h"

#include "trace/embree/embree.h"
#include "trace/search.h"
#include "trace/stretch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- memory ---- */

/* Embree 3.13.5 on a displaced sphere, in bytes per triangle in addition to the mesh. With 2 and 8 million
 * triangles, the usual structures keep 68 and 63 bytes, and need 35 and 32 more during the build; at low
 * quality 92 and 12, with the same peak. Compact ones keep 36 and need 2 more; at low quality 50 and 22.
 * Below a million triangles, compact ones need as much during the build as the usual ones, plus some
 * megabytes. A quad counts as two triangles. */
static const trace_need usual_need = {68, 36}, compact_need = {37, 4};

/* Per sphere in clusters (embree_clusters.h), for 0.2 to 10 million spheres: the usual structures keep 36 to
 * 37 bytes and need 2 to 5 more during the build; compact ones save 2. */
static const trace_need sphere_need = {37, 6};

/* Per instance, measured on one and two million instances of one triangle. Includes memory that Embree does
 * not report. */
static const trace_need instance_need = {440, 120};

/* Copies made in embree_native.c: the indices of a mesh with flat triangles; indices and corners of quads. */
static double copied_bytes(const world_geometry *geometry) {
    double indices = 3 * sizeof(uint32_t) * (double)geometry->count;
    if (geometry->kind == WORLD_QUADS) return 2 * indices + sizeof(world_quad) * (double)geometry->count;
    return geometry->kind == WORLD_MESH && geometry->flat ? indices : 0;
}

trace_need trace_need_of(const world *w, bool is_compact) {
    trace_need each = is_compact ? compact_need : usual_need;
    double n = 0, spheres = 0, more = 0, copied = 0, instances = (double)w->instances.count;
    for (size_t i = 0; i < w->geometries.count; ++i) {
        const world_geometry *geometry = &w->geometries.items[i];
        if (geometry->kind == WORLD_SPHERES)
            spheres += geometry->count;
        else
            n += (geometry->kind == WORLD_QUADS ? 2.0 : 1.0) * geometry->count;
        copied += copied_bytes(geometry);
    }
    if (is_compact && n < 1e6) each.passed = usual_need.passed, more = 16e6;
    return (trace_need){each.kept * n + sphere_need.kept * spheres + instance_need.kept * instances + copied,
                        each.passed * n + sphere_need.passed * spheres + instance_need.passed * instances +
                            more};
}

#define RESERVE 64000000u

static double total(trace_need need) { return need.kept + need.passed; }

static fathom_status refuse(const embree_tracer *tracer, double need) {
    return fail(tracer->context, FATHOM_OUT_OF_RESOURCES,
                "out of memory: building takes about %.1f MB, and %.1f MB are left after program, meshes "
                "and images, which take %.1f MB; raise the limit, %srender on a machine with more memory, or "
                "place repeated parts as instances",
                need * 1e-6, (double)tracer->options->memory * 1e-6, (double)tracer->options->besides * 1e-6,
                tracer->base.world->scene->has_maps ? "lower --texture-memory, " : "");
}

fathom_status embree_fit_memory(embree_tracer *tracer) {
    const world *w = tracer->base.world;
    double room = (double)tracer->options->memory;
    bool chosen = tracer->spec.flags == TRACE_SCENE_COMPACT,
         free_to_choose = !tracer->options->spec && !tracer->options->words;
    double need = total(trace_need_of(w, chosen)), less = total(trace_need_of(w, true));
    tracer->base.foreseen_bytes = (uint64_t)need;
    if (!tracer->options->memory) return FATHOM_OK;
    /* Embree reserves up to twice the memory it uses. This limit only catches estimates that are far too
     * low. */
    tracer->most_bytes = 2 * tracer->options->memory + RESERVE;
    if (need <= room) return FATHOM_OK;
    if (!free_to_choose || less > room) return refuse(tracer, free_to_choose ? fmin(less, need) : need);
    tracer->base.foreseen_bytes = (uint64_t)less;
    tracer->spec.flags = TRACE_SCENE_COMPACT;
    tracer->spec.quality = TRACE_QUALITY_MEDIUM; /* low needs as much during the build as the usual
                                                    structures */
    warn(tracer->context,
         "the usual acceleration structure would take about %.1f MB, and %.1f MB are left after program, "
         "meshes and images: a compact one of %.1f MB is built, which is slower to trace",
         need * 1e-6, room * 1e-6, less * 1e-6);
    return FATHOM_OK;
}

/* ---- how far away rays may start ----
 *
 * Embree may abort on a ray with a coordinate beyond its limit, also in the space of an instance. There an
 * origin has coordinates of up to s |o| + |m| and a direction of up to s |d|, with s the largest row sum of
 * the matrix and m its translation. Rays beyond the reach are not passed to Embree, so the whole world must
 * lie within it. */

static const float limit = REACH_LARGEST / 2; /* a NaN is never below it */

/* ---- what can be hit ---- */

bool reach_usable(vec3_f32 p) { return fabsf(p.x) < limit && fabsf(p.y) < limit && fabsf(p.z) < limit; }

static bool any_sphere(const world_sphere *spheres, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        const vec3_f32 c = spheres[i].center;
        if (reach_usable(c) && largest_f32(c) + fabsf(spheres[i].radius) < limit) return true;
    }
    return false;
}

/* True if any primitive of the geometry can be hit. */
static bool any_usable(const world *w, const world_geometry *geometry) {
    if (geometry->kind == WORLD_SPHERES)
        return any_sphere(&w->spheres.items[geometry->first], geometry->count);
    if (geometry->moving) return geometry->count > 0;
    for (uint32_t i = 0; i < geometry->count; ++i) {
        vec3_f32 v[4];
        const bool quad = search_flat(w, geometry, i, v) == 4;
        if (reach_usable(v[0]) && reach_usable(v[1]) && reach_usable(v[2]) && (!quad || reach_usable(v[3])) &&
            (triangle_has_area_f32(v[0], v[1], v[quad ? 3 : 2]) ||
             (quad && triangle_has_area_f32(v[2], v[3], v[1]))))
            return true;
    }
    return false;
}

bool *reach_placed(const world *w) {
    bool *placed = calloc(w->groups.count, sizeof *placed);
    if (!placed) return NULL;
    for (size_t k = 0; k < w->instances.count; ++k) placed[w->instances.items[k].group] = true;
    for (size_t g = 1; g < w->groups.count; ++g) {
        bool something = false;
        const world_group *group = &w->groups.items[g];
        for (uint32_t i = 0; i < group->count && placed[g] && !something; ++i)
            something = any_usable(w, &w->geometries.items[group->first + i]);
        placed[g] = something;
    }
    placed[0] = true;
    return placed;
}

/* ---- how large the world is ---- */

static float group_size(const world *w, uint32_t index) {
    const world_group *group = &w->groups.items[index];
    float size = 0;
    for (uint32_t g = group->first; g < group->first + group->count; ++g)
        size = fmaxf(size, w->geometries.items[g].largest);
    return size;
}

static float row_sum(const float m[4]) { return fabsf(m[0]) + fabsf(m[1]) + fabsf(m[2]); }

/* The largest world coordinate of an instance's contents, at any motion step. */
static float instance_size(const world *w, uint32_t k, float size) {
    const world_instance *instance = &w->instances.items[k];
    const uint32_t steps = instance->moving ? w->motions.items[instance->moving - 1].steps : 1;
    float most = 0;
    for (uint32_t s = 0; s < steps; ++s) {
        world_instance moved;
        const float time = steps > 1 ? (float)s / (float)(steps - 1) : 0;
        const world_instance *at = world_instance_when(w, k, time, &moved);
        for (int i = 0; i < 3; ++i)
            most = fmaxf(most, row_sum(at->to_world[i]) * size + fabsf(at->to_world[i][3]));
    }
    return most;
}

/* The largest coordinate of the world, among those that Embree accepts; `sizes`: of the groups. *left_out:
 * number of instances that Embree leaves out. */
static float world_size(const world *w, const bool *placed, const float *sizes, uint64_t *left_out) {
    float size = fminf(sizes[0], limit);
    *left_out = 0;
    for (size_t k = 0; k < w->instances.count; ++k) {
        const world_instance *instance = &w->instances.items[k];
        if (!placed[instance->group]) continue;
        const float most = instance_size(w, (uint32_t)k, sizes[instance->group]);
        bool within = most < (float)WORLD_REACH;
        *left_out += !within;
        if (within) size = fmaxf(size, fminf(most, limit));
    }
    return size;
}

/* ---- the reach ---- */

/* Lowers the reach so that rays stay within Embree's limit in the instance's space. */
static void limit_rays(trace_reach *reach, const world_instance *instance) {
    for (int i = 0; i < 3; ++i) {
        const float *m = instance->to_object[i];
        float s = row_sum(m);
        reach->origin = fminf(reach->origin, (limit - fabsf(m[3])) / s);
        reach->direction = fminf(reach->direction, limit / s);
    }
}

/* Does so for each step of a moving instance. False: at some step, float cannot invert the transform. */
static bool limit_steps(const world *w, uint32_t k, trace_reach *reach) {
    const world_instance *instance = &w->instances.items[k];
    const uint32_t steps = instance->moving ? w->motions.items[instance->moving - 1].steps : 1;
    bool fits = true;
    for (uint32_t s = 0; s < steps; ++s) {
        world_instance moved;
        const float time = steps > 1 ? (float)s / (float)(steps - 1) : 0;
        const world_instance *at = world_instance_when(w, k, time, &moved);
        limit_rays(reach, at);
        fits &= world_instance_fits_float(at);
    }
    return fits;
}

/* A mesh far from the others gets its own frame: an instance in the world, but not in the scene. */
static fathom_status refuse_far_mesh(fathom_context *context, const world *w, const world_instance *instance,
                                     float size) {
    return fail(context, FATHOM_BAD_INPUT,
                "object %u: it lies so far away that coordinates of the scene, of up to %g, leave Embree's "
                "range of 1.8e18 when seen from there; place it nearer",
                world_object(w, w->groups.items[instance->group].first, 0), (double)size);
}

static fathom_status refuse_range(fathom_context *context, const world *w, const world_instance *instance,
                                  float size) {
    float s = 0;
    if (instance->id == FATHOM_NONE) return refuse_far_mesh(context, w, instance, size);
    for (int i = 0; i < 3; ++i) s = fmaxf(s, row_sum(instance->to_object[i]));
    bool shrinks = !(limit / s >= size && limit / s >= 2);
    char text[256];
    snprintf(text, sizeof text,
             "it %s that coordinates of the scene, of up to %g, leave Embree's range of 1.8e18 in the group; "
             "%s instead",
             shrinks ? "shrinks its group so far" : "moves its group so far away", (double)size,
             shrinks ? "scale its contents" : "place it nearer");
    return scene_fail_instance(w->scene, instance->id, text);
}

/* Directions of length up to 2 must be valid in every instance: longer ones may be scaled (stretch.h). */
static fathom_status find(fathom_context *context, const world *w, const bool *placed, float size,
                          trace_reach *out) {
    *out = (trace_reach){limit, STRETCH_HIGH};
    for (size_t k = 0; k < w->instances.count; ++k) {
        const world_instance *instance = &w->instances.items[k];
        if (!placed[instance->group]) continue;
        const bool fits = limit_steps(w, (uint32_t)k, out);
        if (!(out->origin >= size && out->direction >= 2)) return refuse_range(context, w, instance, size);
        if (!fits)
            return scene_fail_instance(
                w->scene, instance->id,
                "it scales its group so far that Embree, which inverts its frame in float, would miss what "
                "is there; scale its contents instead");
    }
    return FATHOM_OK;
}

fathom_status reach_find(fathom_context *context, const world *w, const bool *placed, trace_reach *out) {
    float *sizes = malloc(w->groups.count * sizeof *sizes);
    if (!sizes) return fail_memory(context, w->groups.count * sizeof *sizes);
    for (uint32_t g = 0; g < w->groups.count; ++g) sizes[g] = group_size(w, g);
    uint64_t left_out;
    fathom_status status = find(context, w, placed, world_size(w, placed, sizes, &left_out), out);
    if (status == FATHOM_OK && left_out) {
        warn(context, "instances beyond %g from the origin, which Embree leaves out: %llu", WORLD_REACH,
             (unsigned long long)left_out);
    }
    free(sizes);
    return status;
}

fathom_status reach_check(fathom_context *context, const world *w) {
    trace_reach reach;
    bool *placed = reach_placed(w);
    fathom_status status = placed ? reach_find(context, w, placed, &reach)
                                  : fail_memory(context, w->groups.count * sizeof *placed);
    free(placed);
    return status;
}
