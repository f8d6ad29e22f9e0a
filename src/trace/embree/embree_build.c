/* Builds Embree's scenes from the world: one for each group, with the instances in the root. */
#include "trace/embree/embree.h"

#include <stdlib.h>
#include <string.h>

/* ---- errors and progress ---- */

/* Embree 3 reports a bad_alloc of its own code as an unknown error; only the text identifies it. */
static bool lacked_memory(int error, const char *text) {
    return error == RTC_ERROR_OUT_OF_MEMORY ||
           (error == RTC_ERROR_UNKNOWN && (strstr(text, "bad_alloc") || strstr(text, "out of memory")));
}

static fathom_status device_status(embree_tracer *tracer) {
    int error = atomic_load(&tracer->error);
    if (error == RTC_ERROR_NONE) error = (int)rtcGetDeviceError(tracer->device);
    if (error == RTC_ERROR_NONE) return FATHOM_OK;
    if (error == RTC_ERROR_CANCELLED)
        return fail(tracer->context, FATHOM_INTERRUPTED, "building was stopped by the caller");
    return fail(tracer->context,
                lacked_memory(error, tracer->error_text) ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL,
                "Embree, while building: error %d: %s", error, tracer->error_text);
}

static bool go_on(embree_tracer *tracer, double fraction_of_scene) {
    if (!tracer->options->progress) return true;
    double part = fraction_of_scene < 1 ? fraction_of_scene : 1;
    double done = tracer->work_done + part * tracer->work_now;
    return tracer->options->progress(tracer->options->user, tracer->work > 0 ? done / tracer->work : 1);
}

static bool on_progress(void *user, double fraction) { return go_on(user, fraction); }

/* ---- geometries ---- */

/* Sets the mask of every geometry, because the default is all bits in Embree 3 and one bit in Embree 4. Sets
 * the quality too: a scene of low quality builds each mesh with its geometry's own quality. */
static void attach(embree_tracer *tracer, RTCScene scene, RTCGeometry geometry, uint32_t id, unsigned mask) {
    if (!geometry) return;
    rtcSetGeometryBuildQuality(geometry, tracer->quality);
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

static unsigned geometry_mask(const embree_tracer *tracer, const world_geometry *geometry) {
    bool mesh = geometry->kind == WORLD_MESH && embree_is_native(&tracer->spec, tracer->base.world, geometry);
    unsigned mask = EMBREE_SEEN | (mesh ? EMBREE_MESHES : 0);
    if (geometry->flags & FATHOM_CASTS_NO_SHADOW) return mask;
    return mask | EMBREE_SHADOWS | (mesh ? EMBREE_MESH_SHADOWS : 0);
}

/* True if a geometry of the group is in tracer->few, not in the scene. */
static bool is_few(const embree_tracer *tracer, const world_group *group, const world_geometry *geometry) {
    return tracer->few && group == &tracer->base.world->groups.items[0] && geometry->kind == WORLD_SPHERES;
}

static uint32_t instance_of(const embree_tracer *tracer, uint32_t id) {
    return id == RTC_INVALID_GEOMETRY_ID ? FATHOM_NONE : id - tracer->base.world->groups.items[0].count;
}

bool embree_lets_pass(const embree_passing *p, uint32_t primitive, uint32_t instance) {
    const embree_tracer *tracer = p->tracer;
    return tracer
        ->clear[world_material(tracer->base.world, p->geometry, primitive, instance_of(tracer, instance))];
}

static trace_passes passes_at(const embree_passing *p, const struct RTCFilterFunctionNArguments *args,
                              unsigned i) {
    const trace_passing *known = &p->tracer->base.passing;
    const bool mesh = p->tracer->base.world->geometries.items[p->geometry].kind == WORLD_MESH;
    const void *rows = args->hit;
    const float *hit = rows;
    const uint32_t *ids = rows, n = args->N, triangle = ids[EMBREE_ROW_PRIMITIVE * n + i];
    const uint8_t *triangles = known->triangles ? known->triangles[p->geometry] : NULL;
    const uint32_t instance = ids[EMBREE_ROW_INSTANCE * n + i];
    if (triangles && triangles[triangle] != TRACE_PASSES_SOME) return triangles[triangle];
    if (!known->at)
        return mesh || embree_lets_pass(p, triangle / 2, instance) ? TRACE_PASSES_SOME : TRACE_PASSES_NONE;
    return known->at(known->user, p->geometry, triangle, instance_of(p->tracer, instance),
                     hit[EMBREE_ROW_U * n + i], hit[EMBREE_ROW_V * n + i]);
}

/* The filter of any-hit queries on surfaces that light may pass straight: notes hits where a part passes, and
 * goes on; stops where none does. */
static void note_hits(const struct RTCFilterFunctionNArguments *args) {
    uint32_t *flags = (uint32_t *)(void *)args->ray + EMBREE_ROW_FLAGS * args->N;
    for (unsigned i = 0; i < args->N; ++i) {
        if (!args->valid[i]) continue;
        const trace_passes passed = passes_at(args->geometryUserPtr, args, i);
        if (passed != TRACE_PASSES_NONE) args->valid[i] = 0;
        flags[i] |= passed == TRACE_PASSES_SOME  ? TRACE_PASSED_SOME
                    : passed == TRACE_PASSES_ALL ? TRACE_PASSED_ALL
                                                 : 0;
    }
}

/* Quads and triangles with callbacks cannot be told apart. */
static bool can_tell(const world *w, const trace_spec *spec, const uint8_t *passing) {
    for (size_t g = 0; g < w->geometries.count; ++g) {
        const world_geometry *geometry = &w->geometries.items[g];
        if (passing[g] && geometry->kind != WORLD_SPHERES && !embree_is_native(spec, w, geometry))
            return false;
    }
    return true;
}

/* False: out of memory. */
static bool prepare_to_tell(embree_tracer *tracer) {
    const world *w = tracer->base.world;
    uint8_t *passing = world_passing(w);
    if (!passing) return false;
    tracer->base.tells_opaque = can_tell(w, &tracer->spec, passing);
    const bool some = tracer->base.tells_opaque && memchr(passing, 1, w->geometries.count);
    if (some) {
        tracer->passing = calloc(w->geometries.count, sizeof *tracer->passing);
        tracer->clear = calloc(w->scene->materials.count, sizeof *tracer->clear);
    }
    for (uint32_t g = 0; tracer->passing && g < w->geometries.count; ++g)
        tracer->passing[g] = (embree_passing){passing[g] ? tracer : NULL, g};
    for (uint32_t m = 0; tracer->clear && m < w->scene->materials.count; ++m)
        tracer->clear[m] = world_material_passes(w, m);
    free(passing);
    return (tracer->passing && tracer->clear) || !some;
}

/* Spheres have no filter: their callbacks tell. */
static void let_pass(embree_tracer *tracer, RTCGeometry made, uint32_t geometry) {
    if (tracer->base.world->geometries.items[geometry].kind == WORLD_SPHERES) {
        tracer->clusters[geometry].passing = &tracer->passing[geometry];
        return;
    }
    rtcSetGeometryUserData(made, &tracer->passing[geometry]);
    rtcSetGeometryOccludedFilterFunction(made, note_hits);
}

static void attach_geometries(embree_tracer *tracer, RTCScene scene, const world_group *group) {
    const world *w = tracer->base.world;
    for (uint32_t i = 0; i < group->count; ++i) {
        const world_geometry *geometry = &w->geometries.items[group->first + i];
        if (!geometry->count || is_few(tracer, group, geometry)) continue;
        RTCGeometry made = embree_is_native(&tracer->spec, tracer->base.world, geometry)
                               ? embree_native_geometry(tracer->device, w, geometry)
                               : embree_user_geometry(tracer, group->first + i);
        if (made && tracer->passing && tracer->passing[group->first + i].tracer)
            let_pass(tracer, made, group->first + i);
        attach(tracer, scene, made, i, geometry_mask(tracer, geometry));
    }
}

static void set_linear_motion(RTCGeometry geometry, const world_motion *motion) {
    for (uint32_t k = 0; k < motion->steps; ++k) {
        const affine_f64 map = world_motion_map(motion, k);
        float rows[12];
        for (int i = 0; i < 12; ++i) rows[i] = (float)map.m[i / 4][i % 4];
        rtcSetGeometryTransform(geometry, k, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
    }
}

static void set_motion(RTCGeometry geometry, const world_motion *motion) {
    rtcSetGeometryTimeStepCount(geometry, motion->steps);
    if (motion->linear) {
        set_linear_motion(geometry, motion);
        return;
    }
    for (uint32_t k = 0; k < motion->steps; ++k) {
        const motion_parts *p = &motion->parts[k];
        const struct RTCQuaternionDecomposition step = {
            .scale_x = (float)p->scale[0],
            .scale_y = (float)p->scale[1],
            .scale_z = (float)p->scale[2],
            .skew_xy = (float)p->skew[0],
            .skew_xz = (float)p->skew[1],
            .skew_yz = (float)p->skew[2],
            .quaternion_r = (float)p->turn[0],
            .quaternion_i = (float)p->turn[1],
            .quaternion_j = (float)p->turn[2],
            .quaternion_k = (float)p->turn[3],
            .translation_x = (float)p->shift[0],
            .translation_y = (float)p->shift[1],
            .translation_z = (float)p->shift[2],
        };
        rtcSetGeometryTransformQuaternion(geometry, k, &step);
    }
}

static void attach_instances(embree_tracer *tracer, RTCScene root) {
    const world *w = tracer->base.world;
    for (size_t k = 0; k < w->instances.count; ++k) {
        const world_instance *instance = &w->instances.items[k];
        RTCScene scene = tracer->scenes[instance->group];
        if (!scene) continue;
        RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_INSTANCE);
        if (!geometry) return;
        rtcSetGeometryInstancedScene(geometry, scene);
        if (instance->moving)
            set_motion(geometry, &w->motions.items[instance->moving - 1]);
        else
            rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance->to_world);
        attach(tracer, root, geometry, w->groups.items[0].count + (uint32_t)k,
               EMBREE_SEEN | EMBREE_SHADOWS | EMBREE_MESHES | EMBREE_MESH_SHADOWS);
    }
}

/* ---- scenes ---- */

/* Robust by default: it costs packets almost nothing. Never robust and compact together: with both, occlusion
 * of coherent packets does not return on AVX-512. The filter flag costs nothing in calls without a filter. */
static enum RTCSceneFlags scene_flags(const trace_spec *spec) {
    enum RTCSceneFlags filter = spec->ties == TRACE_SETTLED ? EMBREE_SCENE_FLAG_FILTER : RTC_SCENE_FLAG_NONE;
    switch (spec->flags) {
    case TRACE_SCENE_ROBUST: return filter | RTC_SCENE_FLAG_ROBUST;
    case TRACE_SCENE_COMPACT: return filter | RTC_SCENE_FLAG_COMPACT;
    case TRACE_SCENE_DEFAULT: break;
    }
    return filter;
}

static RTCScene new_scene(embree_tracer *tracer) {
    RTCScene scene = rtcNewScene(tracer->device);
    if (!scene) return NULL;
    rtcSetSceneFlags(scene, scene_flags(&tracer->spec));
    rtcSetSceneBuildQuality(scene, tracer->quality);
    if (tracer->options->progress) rtcSetSceneProgressMonitorFunction(scene, on_progress, tracer);
    return scene;
}

static double group_work(const world *w, const world_group *group) {
    double work = 0;
    for (uint32_t i = 0; i < group->count; ++i) work += w->geometries.items[group->first + i].count;
    return work;
}

static fathom_status build_scene(embree_tracer *tracer, uint32_t index) {
    const world *w = tracer->base.world;
    const world_group *group = &w->groups.items[index];
    RTCScene scene = tracer->scenes[index] = new_scene(tracer);
    if (scene) {
        attach_geometries(tracer, scene, group);
        if (index == 0) attach_instances(tracer, scene);
    }
    fathom_status status = device_status(tracer);
    if (status != FATHOM_OK) return status;
    tracer->work_now = group_work(w, group) + (index == 0 ? (double)w->instances.count : 0);
    rtcCommitScene(scene);
    status = device_status(tracer);
    if (status != FATHOM_OK) return status;
    tracer->work_done += tracer->work_now;
    tracer->work_now = 0;
    return FATHOM_OK;
}

static fathom_status build_all(embree_tracer *tracer, const bool *placed) {
    const world *w = tracer->base.world;
    tracer->work = (double)w->instances.count;
    for (size_t g = 0; g < w->groups.count; ++g)
        if (placed[g]) tracer->work += group_work(w, &w->groups.items[g]);
    for (uint32_t g = (uint32_t)w->groups.count; g-- > 0;) {
        if (!go_on(tracer, 0))
            return fail(tracer->context, FATHOM_INTERRUPTED, "building was stopped by the caller");
        fathom_status status = placed[g] ? build_scene(tracer, g) : FATHOM_OK;
        if (status != FATHOM_OK) return status;
    }
    return FATHOM_OK;
}

/* False when out of memory. */
static bool find_halved(embree_tracer *tracer) {
    const world *w = tracer->base.world;
    size_t count = w->geometries.count;
    bool any = false;
    for (size_t g = 0; g < count && !any; ++g)
        any = embree_is_halved(&tracer->spec, w, &w->geometries.items[g]);
    if (!any) return true;
    tracer->halved = calloc(count, sizeof *tracer->halved);
    for (size_t g = 0; tracer->halved && g < count; ++g)
        tracer->halved[g] = embree_is_halved(&tracer->spec, w, &w->geometries.items[g]);
    return tracer->halved != NULL;
}

/* Groups all spheres of the scenes into clusters. */
static fathom_status make_clusters(embree_tracer *tracer, const bool *placed) {
    const world *w = tracer->base.world;
    fathom_status status = FATHOM_OK;
    for (size_t k = 0; k < w->groups.count; ++k) {
        const world_group *group = &w->groups.items[k];
        for (uint32_t g = group->first; g < group->first + group->count && placed[k]; ++g) {
            const world_geometry *geometry = &w->geometries.items[g];
            if (geometry->kind != WORLD_SPHERES || !geometry->count || is_few(tracer, group, geometry))
                continue;
            if (!tracer->clusters) tracer->clusters = calloc(w->geometries.count, sizeof *tracer->clusters);
            if (!tracer->clusters) return fail_memory(tracer->context, w->geometries.count);
            sphere_clusters *c = &tracer->clusters[g];
            c->kernels = few_kernels_best();
            status = clusters_make(tracer->context, &w->spheres.items[geometry->first], geometry->count,
                                   fathom_context_threads(tracer->context), c);
            if (status != FATHOM_OK) return status;
            atomic_fetch_add(&tracer->bytes, (int64_t)(c->count * sizeof *c->items));
        }
    }
    return status;
}

/* The intersectors of user geometry do not support motion. */
static fathom_status check_moving(const embree_tracer *tracer) {
    const world *w = tracer->base.world;
    for (uint32_t g = 0; w->moves && g < w->geometries.count; ++g) {
        const world_geometry *geometry = &w->geometries.items[g];
        if (geometry->moving && !embree_is_native(&tracer->spec, w, geometry))
            return fail(tracer->context, FATHOM_BAD_INPUT,
                        "object %u: its vertices move, and its coordinates, up to %g, leave the range from "
                        "2^-24 to 2^36 in which Embree meets triangles safely; scale the scene",
                        world_object(w, g, 0), (double)geometry->largest);
    }
    return FATHOM_OK;
}

fathom_status embree_build(embree_tracer *tracer) {
    const world *w = tracer->base.world;
    if (tracer->options->tell_opaque && !prepare_to_tell(tracer))
        return fail_memory(tracer->context, w->geometries.count);
    const fathom_status movable = check_moving(tracer);
    if (movable != FATHOM_OK) return movable;
    tracer->scenes = calloc(w->groups.count, sizeof *tracer->scenes);
    bool *placed = reach_placed(w);
    fathom_status status;
    if (tracer->scenes && placed && find_halved(tracer))
        status = reach_find(tracer->context, w, placed, &tracer->reach);
    else
        status = fail_memory(tracer->context, w->groups.count * sizeof *tracer->scenes);
    if (status == FATHOM_OK) status = embree_spheres_choose(tracer);
    if (status == FATHOM_OK) status = make_clusters(tracer, placed);
    if (status == FATHOM_OK) status = build_all(tracer, placed);
    free(placed);
    return status;
}
