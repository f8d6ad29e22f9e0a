/* Regions of surfaces, by place and perhaps by normal: the leaves of a binary tree. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Divides a region in two. below and above are indices of splits, or REGION_LEAF + an index that the tree's
 * owner gives a meaning. */
typedef struct region_split {
    float at; /* points with a smaller coordinate are below */
    uint32_t axis, below, above;
} region_split;

#define REGION_LEAF (1u << 31)

/* Returns a leaf without REGION_LEAF. Coordinate k is at[k * stride]. */
static inline uint32_t region_find(const region_split *splits, uint32_t root, const float *at,
                                   size_t stride) {
    uint32_t k = root;
    while (!(k & REGION_LEAF))
        k = at[splits[k].axis * stride] < splits[k].at ? splits[k].below : splits[k].above;
    return k & ~REGION_LEAF;
}

/* Items that begin with their coordinates, as floats. */
typedef struct region_items {
    void *first;
    size_t size, count; /* size: bytes of an item */
} region_items;

/* Scales for places and normals: normals that differ by a right angle are as far apart as the two ends of the
 * longest side of the items' bounds. */
void region_scales(const region_items *items, float scales[6]);
/* Splits at the mean along the axis whose variance times the square of its scale is the largest; below and
 * above are 0. */
region_split region_choose(const region_items *items, unsigned axes, const float scales[]);
/* Moves the items below the split to the front; returns their number. */
size_t region_part(const region_items *items, const region_split *split);
