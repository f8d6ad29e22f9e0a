#include "trace/bvh/bvh.h"
#include "trace/search.h"

/* One pending node per level: 48 levels of splits in bvh_build.c, then halvings of at most 2^32 items. */
#define BVH_STACK 80

/* Flushed denormals change a depth by a few times the smallest normal float. This is larger, and smaller than
 * lengths in scenes. */
#define TINY 0x1p-120f

#define REAL float
#define FN(name) name##_f32
#define ABS fabsf
#define UNIT 0x1p-24f
#include "trace/bvh/bvh_text.h"

#define REAL double
#define FN(name) name##_f64
#define ABS fabs
#define UNIT 0x1p-53
#include "trace/bvh/bvh_text.h"

#define REAL real_f128
#define FN(name) name##_f128
#define ABS abs_f128
#define UNIT ((real_f128)0x1p-113)
#include "trace/bvh/bvh_text.h"

const trace_ops bvh_ops_f32 = {bvh_destroy, bvh_closest_f32, bvh_any_f32, true, true};
const trace_ops bvh_ops_f64 = {bvh_destroy, bvh_closest_f64, bvh_any_f64, true, true};
const trace_ops bvh_ops_f128 = {bvh_destroy, bvh_closest_f128, bvh_any_f128, true, true};
