/* The hand-written intersectors, in float (_f32) and double (_f64); reference_f128.h has them in quadruple.
 *
 * They work for any finite input, as well as their precision allows. A hit has t in the open interval (t_min,
 * t_max); t is in units of |dir|, which need not be 1. NaN or infinite input always misses (but t_max may be
 * infinite); so does a zero direction. None of them traps, allocates or keeps state.
 *
 * sphere_robust_f32(center, radius, org, dir, t_min, t_max, &t)
 * triangle_robust_f32(a, b, c, org, dir, t_min, t_max, &hit)
 * quad_robust_f32(v0, v1, v2, v3, org, dir, t_min, t_max, &hit)
 * plane_robust_f32(point, normal, org, dir, t_min, t_max, &t) */
#pragma once

#include "math/vec.h"

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define SQRT sqrtf
#define ABS fabsf
#define UNIT 0x1p-24f
#define RANGE_LOW 0x1p-30f
#define RANGE_HIGH 0x1p30f
#define AREA_LOW 0x1p-90f
#define AREA_HIGH 0x1p120f
#include "reference/stamp.h"

#define REAL double
#define VEC3 vec3_f64
#define FN(name) name##_f64
#define SQRT sqrt
#define ABS fabs
#define UNIT 0x1p-53
#define RANGE_LOW 0x1p-240
#define RANGE_HIGH 0x1p240
#define AREA_LOW 0x1p-900
#define AREA_HIGH 0x1p1000
#include "reference/stamp.h"
