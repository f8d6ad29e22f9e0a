/* Sixteen rays or hits of one instance that does not move. */
#include "surface/placed.h"

#include "math/lane.h"
#include "surface/kernels/kernel.h"

void KERNEL(rays_to_object)(const world_instance *instance, local_block *restrict b) {
    const world_instance at = *instance;
    for (unsigned i = 0; i < LANES; ++i) {
        put_lane_f64(b->org, i, placed_point(at.to_object, lane_f64(b->org, i)));
        put_lane_f64(b->dir, i, placed_vector(at.to_object, lane_f64(b->dir, i)));
    }
}

/* Selects each number separately, because a select between structs becomes a branch. */
static inline vec3_f64 kept_f64(bool mine, vec3_f64 yes, vec3_f64 no) {
    return vec_f64(mine ? yes.x : no.x, mine ? yes.y : no.y, mine ? yes.z : no.z);
}

static inline vec3_f32 kept_f32(uint32_t mine, vec3_f32 yes, vec3_f32 no) {
    return vec_f32(chosen(mine, yes.x, no.x), chosen(mine, yes.y, no.y), chosen(mine, yes.z, no.z));
}

void KERNEL(hits_to_world)(const world_instance *instance, uint32_t lanes, local_block *restrict b) {
    const world_instance at = *instance;
    for (unsigned i = 0; i < LANES; ++i) {
        const placed_hit hit = {lane_f64(b->p, i), lane_f64(b->n, i), b->self_hit[i], lane_f32(b->ns, i),
                                lane_f32(b->lift, i)},
                         out = placed_to_world(&at, hit);
        const bool mine = lanes >> i & 1;
        put_lane_f64(b->p, i, kept_f64(mine, out.p, hit.p));
        put_lane_f64(b->n, i, kept_f64(mine, out.n, hit.n));
        b->self_hit[i] = mine ? out.self_hit : hit.self_hit;
        put_lane_f32(b->ns, i, kept_f32(mine ? ~0u : 0, out.ns, hit.ns));
        put_lane_f32(b->lift, i, kept_f32(mine ? ~0u : 0, out.lift, hit.lift));
    }
}
