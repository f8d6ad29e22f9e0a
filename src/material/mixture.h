/* The blend of dielectric and metal that glTF defines, for shader.c and film.c. */
#pragma once

#include "math/limit.h"

static inline float mixed(float a, float b, float t) { return (1 - t) * a + t * b; }

/* F0 of the dielectric. */
static inline float mixture_layer(float ior, float specular, float color) {
    const float ratio = (ior - 1) / (ior + 1);
    return specular * least(ratio * ratio * color, 1);
}

/* Q of shader.h: of the light that remains after the first scattering, the fraction that is reflected in
 * the end. */
static inline float mixture_again(float f0, float f90, float mean) {
    const float reflected = f0 + (f90 - f0) * (1 / 21.0f);
    return reflected * reflected * mean / (1 - reflected * (1 - mean));
}

/* 1 / (pi lost); 0 if lost is close to 0. lost: the light that remains after the first scattering. */
static inline float mixture_scale(float lost) { return lost > 1e-6f ? 1 / (3.14159265f * lost) : 0; }

/* The mean fraction of light that reaches the base through the layer. */
static inline float mixture_under(float layer0, float layer90, float layer_again, float mean, float edge) {
    return 1 - (layer0 * (mean - edge) + layer90 * edge + layer_again * (1 - mean));
}

/* Lambert's reflectance divided by that mean. */
static inline float mixture_lifted(float diffuse, float under) { return under > 1e-4f ? diffuse / under : 0; }
