/* Quadruple precision: vec3_f128 with dot_f128, cross_f128…, like math/vec.h for float and double. real_f128
 * is the compiler's type for binary128; libquadmath is not needed. */
#pragma once

#include "math/vec.h"
#include <float.h>

#if LDBL_MANT_DIG == 113
typedef long double real_f128;
#elif defined(__SIZEOF_FLOAT128__)
typedef __float128 real_f128;
#else
#error "Fathom's reference intersectors need a compiler with binary128"
#endif

/* Square root with an error below one ulp; NaN below zero. Newton's iteration starts from the double root:
 * the relative error falls from 2^-53 to 2^-107, then to the final rounding. */
real_f128 sqrt_f128(real_f128 x);

static inline real_f128 abs_f128(real_f128 x) { return x < 0 ? -x : x; }

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define SQRT sqrt_f128
#include "math/vec_text.h"
#undef REAL
#undef VEC3
#undef FN
#undef SQRT

static inline vec3_f128 quadruple_f32(vec3_f32 a) { return (vec3_f128){a.x, a.y, a.z}; }
static inline vec3_f128 quadruple_f64(vec3_f64 a) { return (vec3_f128){a.x, a.y, a.z}; }
