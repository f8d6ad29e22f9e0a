#include "shade/kernels/kernel.h"

void KERNEL(camera_directions)(const shade_camera *camera, const double x[LANES], const double y[LANES],
                               lanes3 out) {
    const shade_camera c = *camera;
    for (int i = 0; i < LANES; ++i) {
        vec3_f32 d = camera_direction(&c, x[i], y[i]);
        out[0][i] = d.x, out[1][i] = d.y, out[2][i] = d.z;
    }
}
