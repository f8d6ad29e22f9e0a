/* Gathers the corners of sixteen triangles of one mesh, or of sixteen halves of quads.
 *
 * A row of three numbers is one load, and seven shuffles transpose four rows. Gather instructions, three
 * for each corner, take at least twice as long: bench/README.md. */
#include "surface/half.h"
#include "surface/kernels/kernel.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

typedef float row __attribute__((vector_size(16)));

/* Loads three numbers; the fourth is undefined. It does not read past them, because the array may end
 * there. */
static inline row load_row(const float *p) {
#if defined(__AVX512VL__)
    return _mm_maskz_loadu_ps(7, p);
#elif defined(__AVX2__)
    return _mm_maskload_ps(p, _mm_setr_epi32(-1, -1, -1, 0));
#else
    return (row){p[0], p[1], p[2], 0};
#endif
}

static inline void store_column(row column, float *to) { memcpy(to, &column, sizeof column); }

#define LOW(a, b) __builtin_shufflevector((a), (b), 0, 4, 1, 5)
#define HIGH(a, b) __builtin_shufflevector((a), (b), 2, 6, 3, 7)

/* Transposes four rows and stores them in lanes i to i + 3. */
static inline void store_rows(const row r[4], float out[3][LANES], int i) {
    row xy_01 = LOW(r[0], r[1]), xy_23 = LOW(r[2], r[3]);
    row z_01 = HIGH(r[0], r[1]), z_23 = HIGH(r[2], r[3]);
    store_column(__builtin_shufflevector(xy_01, xy_23, 0, 1, 4, 5), out[0] + i);
    store_column(__builtin_shufflevector(xy_01, xy_23, 2, 3, 6, 7), out[1] + i);
    store_column(__builtin_shufflevector(z_01, z_23, 0, 1, 4, 5), out[2] + i);
}

/* stride: distance of rows in bytes. */
static inline void fetch(const float *rows, size_t stride, const uint32_t *indices,
                         const uint32_t triangle[LANES], float out[3][3][LANES]) {
    const size_t words = stride / sizeof(float);
    for (int i = 0; i < LANES; i += 4) {
        row corner[3][4];
        for (int j = 0; j < 4; ++j) {
            const uint32_t *vertices = indices + 3 * (size_t)triangle[i + j];
            for (int k = 0; k < 3; ++k) corner[k][j] = load_row(rows + words * vertices[k]);
        }
        for (int k = 0; k < 3; ++k) store_rows(corner[k], out[k], i);
    }
}

static inline void widen_lanes(const float from[3][LANES], double (*restrict to)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) to[c][i] = (double)from[c][i];
    }
}

void KERNEL(facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                          const float dir[3][LANES], facet_block *restrict f, local_block *restrict b) {
    const uint32_t has_normals = mesh->normals ? ~0u : 0;
    fetch(mesh->positions, mesh->position_stride, mesh->indices, triangle, f->corner);
    widen_lanes(org, b->org);
    widen_lanes(dir, b->dir);
    for (int i = 0; i < LANES; ++i) f->facet[i] = ~0u, f->has_normals[i] = has_normals;
    if (!has_normals) return;
    f->smooth = true;
    fetch(mesh->normals, mesh->normal_stride, mesh->normal_indices ? mesh->normal_indices : mesh->indices,
          triangle, f->normal);
}

/* ---- quads ---- */

typedef float quad_corners[4][3][LANES];

static inline void fetch_quads(const world_quad *quads, const uint32_t primitive[LANES],
                               float (*restrict out)[3][LANES]) {
    for (int i = 0; i < LANES; i += 4) {
        for (int k = 0; k < 4; ++k) {
            row corner[4];
            for (int j = 0; j < 4; ++j) corner[j] = load_row(&quads[primitive[i + j]].corner[k].x);
            store_rows(corner, out[k], i);
        }
    }
}

/* One quad for all lanes, for example a floor. */
static inline void spread_quad(const world_quad *quad, float (*restrict out)[3][LANES]) {
    for (int k = 0; k < 4; ++k) {
        float corner[3];
        store_f32(corner, quad->corner[k]);
        for (int c = 0; c < 3; ++c) {
            for (int i = 0; i < LANES; ++i) out[k][c][i] = corner[c];
        }
    }
}

static inline bool all_same(const uint32_t of[LANES]) {
    uint32_t differ = 0;
    for (int i = 0; i < LANES; ++i) differ |= of[i] ^ of[0];
    return !differ;
}

static inline vec3_f64 corner_of(const float from[3][LANES], int i) {
    return vec_f64((double)from[0][i], (double)from[1][i], (double)from[2][i]);
}

static inline void find_halves(const quad_corners c, const local_block *b, uint32_t *restrict second) {
    for (int i = 0; i < LANES; ++i) {
        vec3_f64 org = {b->org[0][i], b->org[1][i], b->org[2][i]};
        vec3_f64 dir = {b->dir[0][i], b->dir[1][i], b->dir[2][i]};
        double side = half_side(corner_of(c[0], i), corner_of(c[1], i), corner_of(c[3], i), org, dir);
        float below = (float)(side < 0 ? 1.0 : 0.0);
        second[i] = below > 0 ? ~0u : 0;
    }
}

void KERNEL(quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *restrict f, local_block *restrict b) {
    quad_corners corner;
    uint32_t second[LANES];
    if (all_same(primitive))
        spread_quad(&quads[primitive[0]], corner);
    else
        fetch_quads(quads, primitive, corner);
    widen_lanes(org, b->org);
    widen_lanes(dir, b->dir);
    find_halves(corner, b, second);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            f->corner[0][c][i] = chosen(second[i], corner[2][c][i], corner[0][c][i]);
            f->corner[1][c][i] = chosen(second[i], corner[3][c][i], corner[1][c][i]);
            f->corner[2][c][i] = chosen(second[i], corner[1][c][i], corner[3][c][i]);
        }
    }
    for (int i = 0; i < LANES; ++i) f->facet[i] = ~0u, f->has_normals[i] = 0;
}
