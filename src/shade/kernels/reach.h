/* From sixteen points to a light: what light_evaluate.c and light_aim.c share. */
#ifndef SHADE_KERNELS_REACH_H
#define SHADE_KERNELS_REACH_H

#include "shade/kernels/kernel.h"

#include <math.h>

static inline void reach_from(const shade_light *light, const lanes3 origin, float (*restrict to)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        to[0][i] = light->position.x - origin[0][i];
        to[1][i] = light->position.y - origin[1][i];
        to[2][i] = light->position.z - origin[2][i];
    }
}

/* Where the squared distance leaves the range of float. A light in the very point, or beyond float's reach,
 * has no direction: distance 0. */
static inline void reach_stiff(const lanes3 to, int i, lanes3 direction, float *distance, float *inverse) {
    double x = (double)to[0][i], y = (double)to[1][i], z = (double)to[2][i],
           length = sqrt(x * x + y * y + z * z);
    bool within = length > 0x1p-126 && length < 0x1p126;
    double scale = within ? 1 / length : 0;
    direction[0][i] = within ? (float)(x * scale) : 0;
    direction[1][i] = within ? (float)(y * scale) : 0;
    direction[2][i] = within ? (float)(z * scale) : 0;
    *distance = within ? (float)length : 0;
    *inverse = (float)scale;
}

/* Unit directions, distances and their inverses. */
static inline void reach_along(const lanes3 to, float (*restrict direction)[LANES], float *restrict distance,
                               float *restrict inverse) {
    float square[LANES];
    int stiff = 0;
    for (int i = 0; i < LANES; ++i) {
        float d2 = to[0][i] * to[0][i] + to[1][i] * to[1][i] + to[2][i] * to[2][i], length = sqrtf(d2);
        inverse[i] = 1 / length;
        for (int c = 0; c < 3; ++c) direction[c][i] = to[c][i] * inverse[i];
        distance[i] = length;
        square[i] = d2;
        stiff |= !(d2 > 0x1p-100f) | !(d2 < 0x1p100f);
    }
    for (int i = 0; stiff && i < LANES; ++i) {
        if (!(square[i] > 0x1p-100f && square[i] < 0x1p100f))
            reach_stiff(to, i, direction, &distance[i], &inverse[i]);
    }
}

#endif
