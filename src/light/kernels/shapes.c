/* Emissive shapes seen from sixteen points. */
#include "light/kernels/kernel.h"
#include "math/lane.h"

static inline void put(const shape_answers *restrict from, lanes3 direction, float *restrict distance) {
    for (unsigned i = 0; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) direction[c][i] = (float)from->direction[c][i];
        distance[i] = (float)from->distance[i];
    }
}

/* Samples a face seen from the point `at`. One triangle of a quad is chosen by its fraction of the solid
 * angle. */
__attribute__((always_inline)) static inline void face_lane(const vec3_f64 corner[4], double clear,
                                                            double slope, bool quad, vec3_f64 at, double u,
                                                            double v, unsigned i, shape_answers *made) {
    shape_seen s = shape_see(at, corner[0], corner[1], corner[3], clear);
    double all = s.angle, along = u;
    if (quad) {
        const shape_seen other = shape_see(at, corner[2], corner[3], corner[1], clear);
        const double first = all;
        all += other.angle;
        along *= all;
        const bool second = !(along < first);
        s = shape_either(second, &other, &s);
        along = (second ? along - first : along) / (s.angle + 0x1p-1000);
        along = along < 1 ? along : 1;
    }
    const vec3_f64 to = shape_triangle_sample(&s, along, v);
    made->direction[0][i] = to.x, made->direction[1][i] = to.y, made->direction[2][i] = to.z;
    made->distance[i] = shape_face_end(&s, to, slope);
    made->density[i] = shape_inverse(all);
}

__attribute__((always_inline)) static inline void face_lanes(const shape_faces *restrict f,
                                                             const lanes3_f64 p, const lanes3 u, bool quads,
                                                             shape_answers *out) {
    shape_answers made; /* a local variable: it aliases nothing */
    for (unsigned i = 0; i < LANES; ++i) {
        const vec3_f64 corner[4] = {lane_f64(f->corner[0], i), lane_f64(f->corner[1], i),
                                    lane_f64(f->corner[2], i), lane_f64(f->corner[3], i)};
        face_lane(corner, f->clear[i], f->slope[i], quads, lane_f64(p, i), (double)u[0][i], (double)u[1][i],
                  i, &made);
    }
    *out = made;
}

static void faces(const shape_faces *f, const lanes3_f64 p, const lanes3 u, bool quads, shape_answers *out,
                  lanes3 direction, float *distance) {
    if (quads)
        face_lanes(f, p, u, true, out);
    else
        face_lanes(f, p, u, false, out);
    put(out, direction, distance);
}

static void balls(const shape_balls *restrict b, const lanes3_f64 p, const lanes3 u,
                  shape_answers *restrict out, lanes3 direction, float *distance) {
    for (unsigned i = 0; i < LANES; ++i) {
        const vec3_f64 from = sub_f64(lane_f64(p, i), lane_f64(b->center, i));
        const shape_cone cone = shape_cone_of(from, b->radius[i]);
        const vec3_f64 to = shape_cone_sample(&cone, (double)u[0][i], (double)u[1][i]);
        const double end =
            shape_sphere_root(from, to, b->radius[i] + b->clear[i] + b->slope[i] * cone.distance, -1);
        out->direction[0][i] = to.x, out->direction[1][i] = to.y, out->direction[2][i] = to.z;
        out->distance[i] = end > 0x1p-126 ? end : 0x1p-126;
        out->density[i] = shape_inverse(shape_cone_angle(&cone));
    }
    put(out, direction, distance);
}

static void sky(const lanes3 n, const lanes3 u, float (*restrict direction)[LANES],
                float density[restrict LANES]) {
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f64 unit = {(double)n[0][i], (double)n[1][i], (double)n[2][i]};
        const double square = dot_f64(unit, unit), length = sqrt(square > 0 ? square : 1);
        unit = scale_f64(1 / length, unit);
        const vec3_f64 to = shape_all_sample(unit, (double)u[0][i], (double)u[1][i]);
        direction[0][i] = (float)to.x, direction[1][i] = (float)to.y, direction[2][i] = (float)to.z;
        const vec3_f64 as_traced = {(double)direction[0][i], (double)direction[1][i],
                                    (double)direction[2][i]};
        density[i] = (float)shape_all_density(unit, as_traced);
    }
}

const shape_kernels KERNEL(shape_kernels) = {
    .faces = faces, .face = KERNEL(face), .balls = balls, .sky = sky};
