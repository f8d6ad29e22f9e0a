/* Shared by the sources in this folder; see base/kernel.h. */
#pragma once

#include "base/kernel.h"
#include "surface/kernels.h"

void KERNEL(facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                          const float dir[3][LANES], facet_block *restrict f, local_block *restrict b);
void KERNEL(quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *restrict f, local_block *restrict b);
void KERNEL(rays_to_object)(const world_instance *instance, local_block *restrict b);
void KERNEL(hits_to_world)(const world_instance *instance, uint32_t lanes, local_block *restrict b);
void KERNEL(facets)(const facet_block *f, bool lifted, local_block *restrict b);
