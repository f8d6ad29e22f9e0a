/* One lane of a block, as a vector. */
#ifndef LIGHT_LANE_H
#define LIGHT_LANE_H

#include "math/lanes.h"
#include "math/vec.h"

static inline vec3_f32 lane_f32(const lanes3 v, int i) { return (vec3_f32){v[0][i], v[1][i], v[2][i]}; }
static inline vec3_f64 lane_f64(const lanes3_f64 v, int i) { return (vec3_f64){v[0][i], v[1][i], v[2][i]}; }

static inline void put_lane(lanes3 v, int i, vec3_f32 a) { v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z; }
static inline void put_lane_f64(lanes3_f64 v, int i, vec3_f64 a) {
    v[0][i] = a.x, v[1][i] = a.y, v[2][i] = a.z;
}

#endif
