/* Sixteen hits in the coordinates of their objects: what the primitives say of the points, whoever found
 * them.
 *
 * Position and normals are computed from the ray and the primitive alone, so that every tracer, packet width
 * and grouping of rays that finds the same primitive gives the same pixel. */
#ifndef SURFACE_LOCAL_H
#define SURFACE_LOCAL_H

#include "math/lanes.h"

#include <stdbool.h>
#include <stdint.h>

/* Near its plane a triangle of side L and normal n is told from a ray by t = n·v / n·d, the corners v seen
 * from the start: each is off by u L, each term of n and of the two products by some units of L², L³. Were
 * all roundings at their worst and of one sign, 26 u L² / |n| sides of distance could be lost
 * (verify/verdict/verdict_bound.c), 30 u L for an equilateral one. They are not: of 1e6 rays from triangles
 * up to four times as long as wide none needs more than 2 u L, neither by our form nor by Embree's
 * (bench/offset.sh). Six times that is taken; and all of it, with the point's own rounding, stays below 32
 * units. Slivers would need more, as the inverse of their width: bench/README.md says how many of their rays
 * meet them again. */
#define LOCAL_FACE_SELF_HIT (12 * 0x1p-24)

typedef struct local_block {
    _Alignas(64) lanes3_f64 org, dir; /* the ray; dir need not be unit */
    lanes3_f64 p;                     /* on the surface, but for a few roundings of double */
    lanes3_f64 n;                     /* geometric normal, unit, as the shape defines its outside */
    double self_hit[LANES]; /* a ray that starts farther than this from the surface, its rounded origin taken
                             as it is, and leaves, is not found to meet it again */
    lanes3 ns;              /* shading normal, unit */
    lanes3 lift; /* on the viewer's side, off the facet to the round surface that its normals stand for
                    (Hanika 2021); else 0 */
    uint32_t smooth[LANES]; /* all ones: lift is set */
    lanes3 ray;             /* direction in the world */
    lanes3 weight;          /* of a facet's corners at the point; of other shapes not set */
} local_block;

/* Corners of the triangle or half quad that a lane met, and the normals there. */
typedef struct facet_block {
    _Alignas(64) float corner[3][3][LANES]; /* corner, axis, lane */
    float normal[3][3][LANES];
    uint32_t facet[LANES];       /* all ones: the lane is a triangle's or a quad's */
    uint32_t has_normals[LANES]; /* all ones: it has normals; they need not be unit */
    bool smooth;                 /* some lane has */
} facet_block;

#endif
