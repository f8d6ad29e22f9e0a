/* Embree 3.13 and 4 behind one interface. No other file depends on the version.
 *
 * Version 3 passes flags and filter in a context, version 4 in separate arguments; callbacks get a pointer to
 * the context in both. So the data of a call follows the context in a larger struct. */
#pragma once

#include "trace/trace.h"

#if FATHOM_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext embree_context;
#define EMBREE_SCENE_FLAG_FILTER RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
#define EMBREE_COHERENT_16_MAY_HANG false
#elif FATHOM_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext embree_context;
#define EMBREE_SCENE_FLAG_FILTER RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
/* Debian 12's build (3.13.5, gcc 12): the AVX-512 kernels for coherent occlusion of 16 rays over instances,
 * and over triangles that are both compact and robust, keep the 16-bit mask of remaining rays in a 64-bit
 * stack slot. Its upper bits are uninitialised, and the kernels loop until the whole slot is zero. */
#define EMBREE_COHERENT_16_MAY_HANG true
#else
#error "Fathom needs Embree 3.13 or 4"
#endif

/* One level of instances: an instance id is one number. */
_Static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT == 1, "Embree built for nested instances");
_Static_assert(RTC_INVALID_GEOMETRY_ID == FATHOM_NONE, "no hit and no id are the same number");

/* Calls with 16 rays pass the block itself, without a copy. */
_Static_assert(sizeof(struct RTCRay16) == sizeof(trace_rays), "rays");
_Static_assert(offsetof(struct RTCRay16, tnear) == offsetof(trace_rays, t_near), "t_near");
_Static_assert(offsetof(struct RTCRay16, dir_x) == offsetof(trace_rays, dir_x), "dir");
_Static_assert(offsetof(struct RTCRay16, time) == offsetof(trace_rays, time), "time");
_Static_assert(offsetof(struct RTCRay16, tfar) == offsetof(trace_rays, t_far), "t_far");
_Static_assert(offsetof(struct RTCRay16, mask) == offsetof(trace_rays, mask), "mask");
_Static_assert(offsetof(struct RTCRay16, id) == offsetof(trace_rays, id), "id");
_Static_assert(offsetof(struct RTCRay16, flags) == offsetof(trace_rays, flags), "flags");
_Static_assert(sizeof(struct RTCHit16) <= sizeof(trace_hits), "hits");
_Static_assert(sizeof(struct RTCRayHit16) <= sizeof(trace_block), "block");
_Static_assert(offsetof(struct RTCRayHit16, hit) == offsetof(trace_block, hits), "hits in block");
_Static_assert(offsetof(struct RTCHit16, u) == offsetof(trace_hits, u), "u");
_Static_assert(offsetof(struct RTCHit16, primID) == offsetof(trace_hits, primitive), "primitive");
_Static_assert(offsetof(struct RTCHit16, geomID) == offsetof(trace_hits, geometry), "geometry");
_Static_assert(offsetof(struct RTCHit16, instID) == offsetof(trace_hits, instance), "instance");
_Static_assert(_Alignof(struct RTCRayHit16) <= _Alignof(trace_block), "alignment");
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
_Static_assert(offsetof(struct RTCHit16, instPrimID) == offsetof(trace_hits, reserved), "reserved");
#endif

/* A packet of width N consists of rows of N numbers: 12 rows for the ray, then those of the hit. */
enum {
    EMBREE_ROW_ORG = 0,
    EMBREE_ROW_T_NEAR = 3,
    EMBREE_ROW_DIR = 4,
    EMBREE_ROW_T_FAR = 8,
    EMBREE_ROW_ID = 10,
    EMBREE_ROW_FLAGS = 11,
    EMBREE_RAY_ROWS = 12,
    EMBREE_ROW_NG = 0, /* of the hit */
    EMBREE_ROW_U = 3,
    EMBREE_ROW_V = 4,
    EMBREE_ROW_PRIMITIVE = 5,
    EMBREE_ROW_GEOMETRY = 6,
    EMBREE_ROW_INSTANCE = 7,
    EMBREE_HIT_ROWS = sizeof(struct RTCHit16) / (16 * sizeof(float))
};
_Static_assert(sizeof(struct RTCRay8) == EMBREE_RAY_ROWS * 8 * sizeof(float), "rows of 8");
_Static_assert(sizeof(struct RTCRay4) == EMBREE_RAY_ROWS * 4 * sizeof(float), "rows of 4");
_Static_assert(sizeof(struct RTCRay) == EMBREE_RAY_ROWS * sizeof(float), "rows of 1");
_Static_assert(offsetof(struct RTCRayHit8, hit) == sizeof(struct RTCRay8), "hits of 8 follow the rays");
_Static_assert(offsetof(struct RTCRayHit4, hit) == sizeof(struct RTCRay4), "hits of 4 follow the rays");
_Static_assert(offsetof(struct RTCRayHit, hit) == sizeof(struct RTCRay), "the hit follows the ray");

#define EMBREE_BY_WIDTH(call, ...)                                                                           \
    switch (width) {                                                                                         \
    case 16: call##16(valid, __VA_ARGS__); break;                                                            \
    case 8: call##8(valid, __VA_ARGS__); break;                                                              \
    case 4: call##4(valid, __VA_ARGS__); break;                                                              \
    default: call##1(__VA_ARGS__); break;                                                                    \
    }

/* embree_intersect(): closest hits of `width` rays (1, 4, 8 or 16). `filter`, unless NULL, is called for each
 * candidate on Embree's own shapes. embree_occluded(): sets t_far of rays that hit anything to -infinity. */
#if FATHOM_EMBREE_MAJOR == 4

static inline void embree_context_init(embree_context *context) { rtcInitRayQueryContext(context); }

#define EMBREE_QUERY_FLAGS(coherent)                                                                         \
    ((coherent) ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT)

static inline void embree_intersect(unsigned width, const int *valid, RTCScene scene, embree_context *context,
                                    bool coherent, RTCFilterFunctionN filter, void *rayhit) {
    struct RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    args.flags = (enum RTCRayQueryFlags)(EMBREE_QUERY_FLAGS(coherent) |
                                         (filter ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : 0));
    args.context = context;
    args.filter = filter;
    EMBREE_BY_WIDTH(rtcIntersect, scene, rayhit, &args)
}

static inline void embree_occluded(unsigned width, const int *valid, RTCScene scene, embree_context *context,
                                   bool coherent, void *ray) {
    struct RTCOccludedArguments args;
    rtcInitOccludedArguments(&args);
    args.flags = EMBREE_QUERY_FLAGS(coherent);
    args.context = context;
    EMBREE_BY_WIDTH(rtcOccluded, scene, ray, &args)
}

#else

static inline void embree_context_init(embree_context *context) { rtcInitIntersectContext(context); }

static inline void embree_context_set(embree_context *context, bool coherent, RTCFilterFunctionN filter) {
    context->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    context->filter = filter;
}

static inline void embree_intersect(unsigned width, const int *valid, RTCScene scene, embree_context *context,
                                    bool coherent, RTCFilterFunctionN filter, void *rayhit) {
    embree_context_set(context, coherent, filter);
    EMBREE_BY_WIDTH(rtcIntersect, scene, context, rayhit)
}

static inline void embree_occluded(unsigned width, const int *valid, RTCScene scene, embree_context *context,
                                   bool coherent, void *ray) {
    embree_context_set(context, coherent, NULL);
    EMBREE_BY_WIDTH(rtcOccluded, scene, context, ray)
}

#endif
