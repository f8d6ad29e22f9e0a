/* Indices by themselves: loops that vectorise. */
#include "scene/boundary.h"
#include "scene/kernels/kernel.h"

bool KERNEL(indices)(const uint32_t *indices, size_t count, uint32_t limit) {
    uint32_t highest = 0;
    for (size_t i = 0; i < count; ++i) highest = indices[i] > highest ? indices[i] : highest;
    return highest < limit || !count;
}

uint64_t KERNEL(boundary)(const uint32_t *triangles, size_t count) {
    uint64_t total = 0;
    for (size_t i = 0; i < 3 * count; i += 3) {
        total += boundary_sum(boundary_of_index(triangles[i]), boundary_of_index(triangles[i + 1]),
                              boundary_of_index(triangles[i + 2]));
    }
    return total;
}
