/* Sixteen rays or hits of one instance that rests. */
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

static inline double of_lane(bool mine, double yes, double no) { return mine ? yes : no; }

void KERNEL(hits_to_world)(const world_instance *instance, uint32_t lanes, local_block *restrict b) {
    const world_instance at = *instance;
    for (unsigned i = 0; i < LANES; ++i) {
        const placed_hit hit = {lane_f64(b->p, i), lane_f64(b->n, i), b->self_hit[i], lane_f32(b->ns, i),
                                lane_f32(b->lift, i)},
                         out = placed_to_world(&at, hit);
        const bool mine = lanes >> i & 1;
        const uint32_t bits = mine ? ~0u : 0;
        put_lane_f64(b->p, i,
                     vec_f64(of_lane(mine, out.p.x, hit.p.x), of_lane(mine, out.p.y, hit.p.y),
                             of_lane(mine, out.p.z, hit.p.z)));
        put_lane_f64(b->n, i,
                     vec_f64(of_lane(mine, out.n.x, hit.n.x), of_lane(mine, out.n.y, hit.n.y),
                             of_lane(mine, out.n.z, hit.n.z)));
        b->self_hit[i] = of_lane(mine, out.self_hit, hit.self_hit);
        put_lane_f32(b->ns, i,
                     vec_f32(chosen(bits, out.ns.x, hit.ns.x), chosen(bits, out.ns.y, hit.ns.y),
                             chosen(bits, out.ns.z, hit.ns.z)));
        put_lane_f32(b->lift, i,
                     vec_f32(chosen(bits, out.lift.x, hit.lift.x), chosen(bits, out.lift.y, hit.lift.y),
                             chosen(bits, out.lift.z, hit.lift.z)));
    }
}
