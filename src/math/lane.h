/* Access to one lane of a block, as a vector; sets of lanes as bit masks. */
#pragma once

#include "math/lanes.h"
#include "math/vec.h"

/* The lowest lane of a bit mask, which must not be 0. */
static inline unsigned lane_first(unsigned lanes) { return (unsigned)__builtin_ctz(lanes); }

static inline vec3_f32 lane_f32(const lanes3 v, unsigned i) { return (vec3_f32){v[0][i], v[1][i], v[2][i]}; }
static inline vec3_f64 lane_f64(const lanes3_f64 v, unsigned i) {
    return (vec3_f64){v[0][i], v[1][i], v[2][i]};
}

static inline void put_lane_f32(lanes3 v, unsigned i, vec3_f32 a) {
    v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z;
}
static inline void put_lane_f64(lanes3_f64 v, unsigned i, vec3_f64 a) {
    v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z;
}
