/* Intersectors as lectures have them, to tell the robust ones from. */
#pragma once

#include "reference/reference.h"
#include "reference/reference_f128.h"

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define SQRT sqrtf
#include "textbook_text.h"
#undef REAL
#undef VEC3
#undef FN
#undef SQRT

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define SQRT sqrt_f128
#include "textbook_text.h"
#undef REAL
#undef VEC3
#undef FN
#undef SQRT
