/* The hand-written intersectors in quadruple precision (_f128): the ground truth for float and double. There
 * is no wider precision to fall back to. About a hundred times slower than float. */
#pragma once

#include "reference/vec_f128.h"

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define SQRT sqrt_f128
#define ABS abs_f128
#define UNIT ((real_f128)0x1p-113)
#define RANGE_LOW ((real_f128)0x1p-4000L)
#define RANGE_HIGH ((real_f128)0x1p4000L)
#define AREA_LOW ((real_f128)0x1p-16000L)
#define AREA_HIGH ((real_f128)0x1p16000L)
#include "reference/stamp.h"
