/* The corners of sixteen triangles of one mesh. */
#include "shade/kernels/gather.h"
#include "shade/kernels/kernel.h"

/* Where the numbers of the vertices of each triangle begin, in floats. */
typedef int32_t vertex_places[3][LANES];

static inline void find_vertices(const uint32_t *indices, const uint32_t triangle[LANES], size_t stride,
                                 vertex_places out) {
    const int32_t words = (int32_t)(stride / sizeof(float));
    _Alignas(64) int32_t first[LANES];
    for (int i = 0; i < LANES; ++i) first[i] = (int32_t)(3 * triangle[i]);
    for (int k = 0; k < 3; ++k) {
        gather(indices + k, first, out[k]);
        for (int i = 0; i < LANES; ++i) out[k][i] *= words;
    }
}

static inline void fetch(const float *from, const vertex_places at, float out[3][3][LANES]) {
    for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) gather(from + axis, at[k], out[k][axis]);
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
    vertex_places at;
    find_vertices(mesh->indices, triangle, mesh->position_stride, at);
    fetch(mesh->positions, at, f->corner);
    widen_lanes(org, b->org);
    widen_lanes(dir, b->dir);
    for (int i = 0; i < LANES; ++i) f->facet[i] = ~0u, f->bent[i] = bent;
    if (!bent) return;
    f->smooth = true;
    if (mesh->normal_indices || mesh->normal_stride != mesh->position_stride)
        find_vertices(mesh->normal_indices ? mesh->normal_indices : mesh->indices, triangle,
                      mesh->normal_stride, at);
    fetch(mesh->normals, at, f->normal);
}
