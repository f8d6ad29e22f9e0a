/* Shadow rays from where they begin to where they end.
 *
 * A ray ends as it begins: clear of the surface it touches there. A light that a surface holds is seen from
 * both sides of it, so the end moves to the side from which the ray comes; a surface that lies beside the
 * light hides it from one side, so the end moves away from it. What the end must be clear of is in
 * light_surface (render/light_surfaces.c). */
#include "shade/kernels/reach.h"

typedef struct ray_ends {
    lanes3 moved;         /* from the light */
    float shorter[LANES]; /* what moving could not do */
} ray_ends;

/* The side of the surface on which the lane's ray must end; `along` is from its start to the light. */
static inline float side_of(const light_surface *s, float along) {
    float from = along > 0 ? -1 : 1;
    return s->above > 0 ? 1 : (s->above < 0 ? -1 : from);
}

static inline float along_of(const light_surface *s, const lanes3 v, int i) {
    return s->normal.x * v[0][i] + s->normal.y * v[1][i] + s->normal.z * v[2][i];
}

/* How much nearer to the surface than it must be a lane's ray ends. The sum of its coordinates is at least
 * its length. */
static inline float lack_of(const light_surface *s, const lanes3 to, const ray_ends *ends, float side,
                            int i) {
    float length = fabsf(to[0][i]) + fabsf(to[1][i]) + fabsf(to[2][i]);
    float lack = s->clear + s->slope * length - fabsf(s->above) - side * along_of(s, ends->moved, i);
    return lack > 0 ? lack : 0;
}

static void move_off(const light_surface *s, const lanes3 to, ray_ends *restrict ends) {
    for (int i = 0; i < LANES; ++i) {
        float side = side_of(s, along_of(s, to, i)), by = side * lack_of(s, to, ends, side, i);
        ends->moved[0][i] += by * s->normal.x;
        ends->moved[1][i] += by * s->normal.y;
        ends->moved[2][i] += by * s->normal.z;
    }
}

/* In the edge between surfaces, moving off one can lead back to another. There the ray ends where it is still
 * clear of it: by the lack over the cosine. */
static void cut_short(const light_surface *s, const lanes3 to, ray_ends *restrict ends) {
    for (int i = 0; i < LANES; ++i) {
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
        for (int i = 0; i < LANES; ++i) to[c][i] += ends->moved[c][i];
    }
}

/* A ray that has nowhere to go without meeting the surfaces sees the light: it keeps the least length there
 * is. 0 would mean that there is no light. */
static void shorten(const float shorter[LANES], float *restrict distance) {
    for (int i = 0; i < LANES; ++i) {
        float left = distance[i] - shorter[i], least = distance[i] > 0 ? 0x1p-126f : 0;
        distance[i] = left > least ? left : least;
    }
}

static void aim_parallel(const shade_light *light, light_block *b) {
    for (int i = 0; i < LANES; ++i) {
        b->direction[0][i] = light->to_light.x;
        b->direction[1][i] = light->to_light.y;
        b->direction[2][i] = light->to_light.z;
        b->distance[i] = INFINITY;
    }
}

void KERNEL(light_aim)(const shade_light *light, light_block *b) {
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
