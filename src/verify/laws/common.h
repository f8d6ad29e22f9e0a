/* Names and values that the laws share. */
#pragma once

#include "verify/laws/room.h"

static const vec3_f64 origin = {0, 0, 0}, up = {0, 0, 1}, down = {0, 0, -1}, white = {1, 1, 1},
                      law_left = {0.25, 0.5, 0.875};

static inline double square(double x) { return x * x; }
static inline vec3_f64 gray(double x) { return vec_f64(x, x, x); }
