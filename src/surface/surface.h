/* Sixteen surface points, as materials and lights see them: a structure of arrays. */
#ifndef SURFACE_SURFACE_H
#define SURFACE_SURFACE_H

#include "math/lanes.h"

#include <stdint.h>

typedef struct surface_block {
    _Alignas(64) lanes3 p; /* the point, in the world's coordinates */
    lanes3 ng;             /* geometric normal, unit, facing the viewer */
    lanes3 ns;             /* shading normal, unit, on the same side of the surface as ng */
    lanes3 v;              /* towards the viewer, unit */
    lanes3 lift;           /* from p to where shadow rays begin: off the facet of a smooth mesh, else 0 */
    float offset[LANES];   /* how far along ±ng a ray must begin to be clear of the surface; >= 0 */
    uint32_t material[LANES];
    uint32_t entering[LANES]; /* all ones: the viewer is outside, by the geometric normal; else 0 */
    uint32_t smooth[LANES];   /* all ones: the side of a light is judged by ns, not ng; else 0 */
    uint32_t count;           /* lanes [0, count) are points; the others repeat the last */
    uint32_t mapped;          /* bits: lanes whose ns a normal map has turned */
    uint32_t coated;          /* bits: lanes of which a clear coat has a normal of its own */
    uint32_t directed;        /* bits: lanes with a tangent that materials ask for */
    lanes3 base;  /* where some are: ns without the map. The side of a light is judged by it, too */
    lanes3 coat;  /* the normal of those coats, unit, on the viewer's side as ns */
    lanes3 along; /* the tangent of directed lanes, turned by the material; not quite in the surface */
} surface_block;

/* A coordinate of where a ray begins that leaves p along ±n; offset is negative on the side away from n. */
static inline float surface_start(float p, float offset, float n) { return p + offset * n; }

#endif
