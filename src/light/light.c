#include "light/light.h"

#include "base/kernel.h"

#include <math.h>

void light_prepare(const fathom_light *light, vec3_f64 origin, shade_light *out) {
    *out = (shade_light){.type = light->type};
    for (int c = 0; c < 3; ++c) out->intensity[c] = light->intensity[c];
    if (light->type != FATHOM_LIGHT_DIRECTIONAL) {
        out->position = narrow(sub_f64(load_f64(light->position), origin));
    }
    if (light->type != FATHOM_LIGHT_POINT) {
        out->to_light = narrow(normalize_f64(neg_f64(load_f64(light->direction))));
    }
    if (light->type == FATHOM_LIGHT_SPOT) {
        /* 1 - cos a = 2 sin^2(a/2), and the difference of two of them = 2 sin((o+i)/2) sin((o-i)/2). */
        double outer = (double)light->outer_angle, inner = (double)light->inner_angle;
        double edge = sin(outer / 2), width = 2 * sin((outer + inner) / 2) * sin((outer - inner) / 2);
        out->cone_edge = (float)(2 * edge * edge);
        out->cone_scale = (float)fmin(1 / width, 0x1p100);
    }
}

KERNEL_BEST(light_kernels)
