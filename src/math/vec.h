/* Three-vectors in float and double: vec3_f32 with dot_f32, cross_f32…, and the same with _f64. */
#pragma once

#include <math.h>
#include <stdbool.h>

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define SQRT sqrtf
#include "math/vec_text.h"
#undef REAL
#undef VEC3
#undef FN
#undef SQRT

#define REAL double
#define VEC3 vec3_f64
#define FN(name) name##_f64
#define SQRT sqrt
#include "math/vec_text.h"
#undef REAL
#undef VEC3
#undef FN
#undef SQRT

static inline vec3_f64 widen(vec3_f32 a) { return (vec3_f64){(double)a.x, (double)a.y, (double)a.z}; }
static inline vec3_f32 narrow(vec3_f64 a) { return (vec3_f32){(float)a.x, (float)a.y, (float)a.z}; }
static inline bool finite_f64(vec3_f64 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
static inline bool finite_f32(vec3_f32 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
