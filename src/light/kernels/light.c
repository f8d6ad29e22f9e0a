/* Lights evaluated at sixteen points, and the shadow rays towards them. */
#include "light/light.h"
#include "base/kernel.h"
#include "math/limit.h"

#include <math.h>

/* ---- towards a point ---- */

static void reach_from(const shade_light *light, const lanes3 origin, float (*restrict to)[LANES]) {
    for (unsigned i = 0; i < LANES; ++i) {
        to[0][i] = light->position.x - origin[0][i];
        to[1][i] = light->position.y - origin[1][i];
        to[2][i] = light->position.z - origin[2][i];
    }
}

/* For squared distances beyond the range of float. A light at the point itself, or beyond the range of float,
 * has no direction: distance 0. */
static void reach_stiff(const lanes3 to, unsigned i, lanes3 direction, float *distance, float *inverse) {
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
static void reach_along(const lanes3 to, float (*restrict direction)[LANES], float *restrict distance,
                        float *restrict inverse) {
    float square[LANES];
    int stiff = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        float d2 = to[0][i] * to[0][i] + to[1][i] * to[1][i] + to[2][i] * to[2][i], length = sqrtf(d2);
        inverse[i] = 1 / length;
        for (int c = 0; c < 3; ++c) direction[c][i] = to[c][i] * inverse[i];
        distance[i] = length;
        square[i] = d2;
        stiff |= !(d2 > 0x1p-100f) | !(d2 < 0x1p100f);
    }
    for (unsigned i = 0; stiff && i < LANES; ++i) {
        if (!(square[i] > 0x1p-100f && square[i] < 0x1p100f))
            reach_stiff(to, i, direction, &distance[i], &inverse[i]);
    }
}

/* ---- shadow rays ----
 * A shadow ray ends as it starts: clear of the surface there. If a surface holds the light, both of its sides
 * are lit, so the end moves to the side from which the ray comes. If a surface lies next to the light, it
 * hides the light from one side, so the end moves away from the surface. light_surface
 * (light/light_surfaces.c) has the distance to keep. */

typedef struct ray_ends {
    lanes3 moved;         /* offset of the end from the light */
    float shorter[LANES]; /* how much shorter the ray must be where moving is not enough */
} ray_ends;

/* The side of the surface on which the lane's ray must end; `along` is the normal component of the vector
 * from the ray's start to the light. */
static inline float side_of(const light_surface *s, float along) {
    float from = along > 0 ? -1 : 1;
    return s->above > 0 ? 1 : (s->above < 0 ? -1 : from);
}

static inline float along_of(const light_surface *s, const lanes3 v, unsigned i) {
    return s->normal.x * v[0][i] + s->normal.y * v[1][i] + s->normal.z * v[2][i];
}

/* How much too near to the surface a lane's ray ends. The sum of the absolute coordinates is an upper bound
 * of the length. */
static inline float lack_of(const light_surface *s, const lanes3 to, const ray_ends *ends, float side,
                            unsigned i) {
    float length = fabsf(to[0][i]) + fabsf(to[1][i]) + fabsf(to[2][i]);
    float lack = s->clear + s->slope * length - fabsf(s->above) - side * along_of(s, ends->moved, i);
    return lack > 0 ? lack : 0;
}

static void move_off(const light_surface *s, const lanes3 to, ray_ends *restrict ends) {
    for (unsigned i = 0; i < LANES; ++i) {
        float side = side_of(s, along_of(s, to, i)), by = side * lack_of(s, to, ends, side, i);
        ends->moved[0][i] += by * s->normal.x;
        ends->moved[1][i] += by * s->normal.y;
        ends->moved[2][i] += by * s->normal.z;
    }
}

/* At an edge between surfaces, moving away from one can lead back to another. There the ray is shortened
 * until it is clear of both: by the lack divided by the cosine. */
static void cut_short(const light_surface *s, const lanes3 to, ray_ends *restrict ends) {
    for (unsigned i = 0; i < LANES; ++i) {
        float along = along_of(s, to, i), lack = lack_of(s, to, ends, side_of(s, along), i);
        float length = fabsf(to[0][i]) + fabsf(to[1][i]) + fabsf(to[2][i]);
        float cut = lack > 0 ? lack * (length / fabsf(along)) : 0;
        ends->shorter[i] = cut > ends->shorter[i] ? cut : ends->shorter[i];
    }
}

static void keep_clear(const shade_light *light, lanes3 to, ray_ends *restrict ends) {
    memset(ends, 0, sizeof *ends);
    for (uint32_t k = 0; k < light->surface_count; ++k) move_off(&light->surfaces[k], to, ends);
    for (uint32_t k = 0; light->surface_count > 1 && k < light->surface_count; ++k) {
        if (light->surfaces[k].above == 0) cut_short(&light->surfaces[k], to, ends);
    }
    for (int c = 0; c < 3; ++c) {
        for (unsigned i = 0; i < LANES; ++i) to[c][i] += ends->moved[c][i];
    }
}

/* A ray that cannot be clear of the surfaces counts as unoccluded: it gets the smallest positive length. A
 * length of 0 would mean that there is no light. */
static void shorten(const float shorter[LANES], float *restrict distance) {
    for (unsigned i = 0; i < LANES; ++i) {
        float left = distance[i] - shorter[i], least = distance[i] > 0 ? 0x1p-126f : 0;
        distance[i] = left > least ? left : least;
    }
}

static void aim_parallel(const shade_light *light, light_block *b) {
    for (unsigned i = 0; i < LANES; ++i) {
        b->direction[0][i] = light->to_light.x;
        b->direction[1][i] = light->to_light.y;
        b->direction[2][i] = light->to_light.z;
        b->distance[i] = INFINITY;
    }
}

static void aim(const shade_light *light, light_block *b) {
    float inverse[LANES];
    lanes3 to;
    ray_ends ends;
    if (light->type == FATHOM_LIGHT_DIRECTIONAL) {
        aim_parallel(light, b);
        return;
    }
    reach_from(light, b->origin, to);
    if (light->surface_count) keep_clear(light, to, &ends);
    reach_along(to, b->direction, b->distance, inverse);
    if (light->surface_count) shorten(ends.shorter, b->distance);
}

/* ---- arriving light ---- */

static void fall_off(const shade_light *light, const light_block *out, float falloff[LANES]) {
    for (unsigned i = 0; i < LANES; ++i)
        falloff[i] = light_falloff(light, out->direction[0][i], out->direction[1][i], out->direction[2][i]);
}

/* The division by the squared distance has two steps: the square may be out of range even if the quotient is
 * not. */
static void arrive(const shade_light *light, const float inverse[LANES], float (*restrict radiance)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (unsigned i = 0; i < LANES; ++i) {
            float once = light->intensity[c] * inverse[i], most = 0x1p127f;
            radiance[c][i] = limited((once < most ? once : most) * inverse[i]);
        }
    }
}

static void sample(const shade_light *light, const lanes3 p, light_block *restrict out) {
    float inverse[LANES];
    lanes3 to;
    for (unsigned i = 0; i < LANES; ++i) inverse[i] = out->falloff[i] = 1;
    if (light->type == FATHOM_LIGHT_DIRECTIONAL) {
        aim_parallel(light, out);
    } else {
        reach_from(light, p, to);
        reach_along(to, out->direction, out->distance, inverse);
    }
    if (light->type == FATHOM_LIGHT_SPOT) fall_off(light, out, out->falloff);
    arrive(light, inverse, out->radiance);
}

const light_kernels KERNEL(light_kernels) = {
    .sample = sample,
    .aim = aim,
};
