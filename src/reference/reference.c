#include "reference/reference.h"
#include "reference/reference_f128.h"

real_f128 sqrt_f128(real_f128 x) {
    if (!(x > 0) || x - x != 0) return x < 0 ? (x - x) / (x - x) : x; /* zero, NaN and infinity stay */
    /* Scales x into the range of double, by even powers of two. */
    real_f128 scale = 1;
    for (; x > (real_f128)0x1p1000; x *= (real_f128)0x1p-1000) scale *= (real_f128)0x1p500;
    for (; x < (real_f128)0x1p-1000; x *= (real_f128)0x1p1000) scale *= (real_f128)0x1p-500;
    real_f128 root = sqrt((double)x);
    root = (root + x / root) / 2;
    root = (root + x / root) / 2;
    return root * scale;
}

static vec3_f128 quadruple(vec3_f128 v) { return v; }

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define WIDE double
#define WIDE_VEC3 vec3_f64
#define WIDE_FN(name) name##_f64
#define WIDER widen
#define WIDE_UNIT 0x1p-53
#include "reference/wide_text.h"

#define REAL double
#define VEC3 vec3_f64
#define FN(name) name##_f64
#define WIDE real_f128
#define WIDE_VEC3 vec3_f128
#define WIDE_FN(name) name##_f128
#define WIDER quadruple_f64
#define WIDE_UNIT ((real_f128)0x1p-113)
#include "reference/wide_text.h"

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define WIDE real_f128
#define WIDE_VEC3 vec3_f128
#define WIDE_FN(name) name##_f128
#define WIDER quadruple
#define WIDE_UNIT ((real_f128)0x1p-113)
#include "reference/wide_text.h"
