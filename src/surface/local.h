/* Sixteen hits in object space: points and normals, computed from the primitives.
 *
 * Position and normals depend only on the ray and the primitive. So every tracer, packet width and grouping
 * of rays that finds the same primitive gives the same pixel. */
#pragma once

#include "math/lanes.h"

#include <stdbool.h>
#include <stdint.h>

/* Offset against self-intersection of a facet, as a fraction of its largest side. Near its plane, a triangle
 * of side L and normal n is intersected by t = n·v / n·d, with the corners v relative to the origin: each v
 * has an error of u L, each term of n and of the two products one of some units of L², L³. If all roundings
 * were at their worst and of one sign, the error could be 26 u L² / |n| sides of distance
 * (verify/verdict/verdict_bound.c), 30 u L for an equilateral triangle. In practice it is smaller: of 1e6
 * rays from triangles up to four times as long as wide, none needs more than 2 u L, with our form or Embree's
 * (bench/offset.sh). We use six times this; with the point's own rounding it stays below 32 units. Slivers
 * would need more, in proportion to 1 / width: bench/README.md gives the fraction of their rays that hit them
 * again. */
#define LOCAL_FACE_SELF_HIT (12 * 0x1p-24)

typedef struct local_block {
    _Alignas(64) lanes3_f64 org, dir; /* the ray; dir need not be unit */
    lanes3_f64 p;                     /* on the surface, up to a few roundings of double */
    lanes3_f64 n;                     /* geometric normal, unit, as the shape defines its outside */
    double self_hit[LANES]; /* minimum distance from the surface at which a ray that leaves does not hit it
                               again; measured from the ray's rounded origin */
    lanes3 ns;              /* shading normal, unit */
    lanes3 lift; /* on the viewer's side, from the facet to the smooth surface that its normals describe
                    (Hanika 2021); else 0 */
    uint32_t smooth[LANES]; /* all ones: lift is set */
    lanes3 ray;             /* direction in the world */
    lanes3 weight;          /* weights of a facet's corners at the point; not set for other shapes */
} local_block;

/* Corners of the triangle or half quad that a lane hit, and the normals there. */
typedef struct facet_block {
    _Alignas(64) float corner[3][3][LANES]; /* corner, axis, lane */
    float normal[3][3][LANES];
    uint32_t facet[LANES];       /* all ones: the lane hit a triangle or a quad */
    uint32_t has_normals[LANES]; /* all ones: the facet has normals; they need not be unit */
    bool smooth;                 /* some lane has normals */
} facet_block;
