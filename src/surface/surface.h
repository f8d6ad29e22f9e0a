/* Sixteen surface points, as materials and lights see them: a structure of arrays. */
#pragma once

#include "math/lanes.h"

#include <stdint.h>

typedef struct surface_block {
    _Alignas(64) lanes3 p; /* the point, in the world's coordinates */
    lanes3 ng;             /* geometric normal, unit, facing the viewer */
    lanes3 ns;             /* shading normal, unit, on the same side of the surface as ng */
    lanes3 v;              /* towards the viewer, unit */
    lanes3 lift; /* from p on a facet to the smooth surface that the mesh's normals describe, else 0: where
                    rays below the facet's horizon, but above that of ns, start (Hanika 2021) */
    float offset[LANES]; /* distance along ±ng at which a ray must start to avoid self-intersection; >= 0 */
    uint32_t material[LANES];
    uint32_t entering[LANES]; /* all ones: the viewer is outside, by the geometric normal; else 0 */
    uint32_t smooth[LANES];   /* all ones: ns alone decides whether light is reflected; else ng, too */
    uint32_t count;           /* lanes [0, count) are points; the others repeat the last */
    uint32_t mapped;          /* bits: lanes whose ns comes from a normal map */
    uint32_t coated;          /* bits: lanes with a clear coat that has its own normal */
    uint32_t directed;        /* bits: lanes with a tangent, for materials that need one */
    lanes3 base;  /* if some lanes are mapped: ns without the map; it also decides on which side a light is */
    lanes3 coat;  /* the coats' normals, unit, on the viewer's side like ns */
    lanes3 along; /* the tangent of directed lanes, rotated by the material; only roughly in the surface */
} surface_block;

/* One coordinate of the origin of a ray that leaves p along ±n; offset is negative on the side opposite to
 * n. */
static inline float surface_start(float p, float offset, float n) { return p + offset * n; }
