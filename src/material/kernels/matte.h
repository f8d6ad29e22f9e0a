/* Blocks whose materials are all pure Lambert, as most of a room is. The results are the same as those of the
 * general code, which reads and writes four times as much. */
#pragma once

#include "material/kernels/block.h"
#include "math/turn.h"

/* If a normal map rotated normals, the test of sides also needs the normal without the map. */
static inline bool is_matte(const surface_block *s, uint32_t lobes) {
    return lobes == SHADER_DIFFUSE && !s->mapped;
}

static void set_diffuse(shader_block *restrict out) {
    uint32_t differ = 0;
    for (int i = 1; i < LANES; ++i) differ |= out->at[i] != out->at[0];
    if (differ) {
        for (int i = 0; i < LANES; ++i) set_colour(out->at[i]->diffuse, i, out->diffuse);
        return;
    }
    const float rgb[3] = {out->at[0]->diffuse[0], out->at[0]->diffuse[1], out->at[0]->diffuse[2]};
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->diffuse[c][i] = rgb[c];
    }
}

/* Returns false if the block is not matte. */
static bool make_matte(const surface_block *s, shader_block *restrict out) {
    uint32_t lobes = 0;
    float up[LANES] = {0};
    for (int i = 0; i < LANES; ++i) lobes |= out->at[i]->lobes;
    if (!is_matte(s, lobes)) return false;
    out->lobes = lobes;
    set_diffuse(out);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) up[i] += s->ns[c][i] * s->v[c][i];
    }
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->n[c][i] = chosen(up[i] > 0 ? ~0u : 0, s->ns[c][i], s->ng[c][i]);
    }
    take_diffuse(out);
    return true;
}

/* f |cosine|, the density and the side masks of direction l. */
static inline void matte_lane(const surface_block *s, const shader_block *b, int i, const float l[3],
                              float f[3], float *density, uint32_t *reflected, uint32_t *cross) {
    float z = 0, side = 0;
    for (int c = 0; c < 3; ++c) z += b->n[c][i] * l[c], side += s->ng[c][i] * l[c];
    *reflected = (z > 0 ? ~0u : 0) & ((side > 0 ? ~0u : 0) | s->smooth[i]);
    *cross = (z < 0 ? ~0u : 0) & (side < 0 ? ~0u : 0);
    const float cosine = lambert(*reflected, z);
    for (int c = 0; c < 3; ++c) f[c] = limited(b->diffuse[c][i] * cosine);
    *density = cosine_density(chosen(*reflected, b->take[SHADER_TAKE_DIFFUSE][i], 0), z);
}

static void evaluate_matte(const surface_block *s, const shader_block *b, const lanes3 l,
                           float (*restrict f)[LANES], float *restrict density) {
    lanes3 value;
    for (int i = 0; i < LANES; ++i) {
        const float to[3] = {l[0][i], l[1][i], l[2][i]};
        float of[3];
        uint32_t reflected, cross;
        matte_lane(s, b, i, to, of, &density[i], &reflected, &cross);
        for (int c = 0; c < 3; ++c) value[c][i] = of[c];
    }
    memcpy(f, value, sizeof value);
}

/* Samples proportionally to the cosine; a black surface gets its normal. */
static inline void matte_direction(const shader_block *b, int i, const float u[2], float d[3]) {
    const uint32_t some = b->take[SHADER_TAKE_DIFFUSE][i] > 0 ? ~0u : 0;
    float r = sqrtf(u[0]), up = 1 - u[0], z = sqrtf(up > 0 ? up : 0), cosine, sine, t[3], across_t[3];
    turn_by(u[1], &cosine, &sine);
    const float x = chosen(some, r * cosine, 0), y = chosen(some, r * sine, 0);
    z = chosen(some, z, 1);
    across(b->n[0][i], b->n[1][i], b->n[2][i], t, across_t);
    float square = 0;
    for (int c = 0; c < 3; ++c) {
        d[c] = t[c] * x + across_t[c] * y + b->n[c][i] * z;
        square += d[c] * d[c];
    }
    const float unit = 1 / sqrtf(square);
    for (int c = 0; c < 3; ++c) d[c] *= unit;
}

static void sample_matte(const surface_block *s, const shader_block *b, const lanes3 u,
                         shader_sample *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const float at[2] = {u[0][i], u[1][i]};
        float d[3], f[3], density;
        uint32_t reflected, cross;
        matte_direction(b, i, at, d);
        matte_lane(s, b, i, d, f, &density, &reflected, &cross);
        const uint32_t some = density > 0 ? ~0u : 0;
        const float inverse = chosen(some, 1 / (density + 0x1p-126f), 0);
        out->density[i] = chosen(some, density, 0);
        for (int c = 0; c < 3; ++c) {
            out->direction[c][i] = d[c];
            out->weight[c][i] = limited(f[c] * inverse);
        }
        out->through[i] = cross, out->straight[i] = out->pane[i] = 0;
    }
}
