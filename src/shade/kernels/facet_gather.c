/* The corners of sixteen triangles of one mesh.
 *
 * A row of three numbers is one load, and four rows are turned into columns by seven shuffles. Gather
 * instructions, three for each corner, take twice as long or more: bench/README.md. */
#include "shade/kernels/kernel.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

typedef float row __attribute__((vector_size(16)));

/* Three numbers and something. Nothing is read behind them: the array may end there. */
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

/* Of lanes i to i + 3. */
static inline void store_rows(const row r[4], float out[3][LANES], int i) {
    row xy_01 = LOW(r[0], r[1]), xy_23 = LOW(r[2], r[3]);
    row z_01 = HIGH(r[0], r[1]), z_23 = HIGH(r[2], r[3]);
    store_column(__builtin_shufflevector(xy_01, xy_23, 0, 1, 4, 5), out[0] + i);
    store_column(__builtin_shufflevector(xy_01, xy_23, 2, 3, 6, 7), out[1] + i);
    store_column(__builtin_shufflevector(z_01, z_23, 0, 1, 4, 5), out[2] + i);
}

/* stride: of the rows, in bytes. */
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

void KERNEL(facet_gather)(const fathom_mesh *mesh, bool normals, const uint32_t triangle[LANES],
                          const float org[3][LANES], const float dir[3][LANES], facet_block *restrict f,
                          local_block *restrict b) {
    const uint32_t bent = normals && mesh->normals ? ~0u : 0;
    fetch(mesh->positions, mesh->position_stride, mesh->indices, triangle, f->corner);
    widen_lanes(org, b->org);
    widen_lanes(dir, b->dir);
    for (int i = 0; i < LANES; ++i) f->facet[i] = ~0u, f->bent[i] = bent;
    if (!bent) return;
    f->smooth = true;
    fetch(mesh->normals, mesh->normal_stride, mesh->normal_indices ? mesh->normal_indices : mesh->indices,
          triangle, f->normal);
}
