/* Sixteen surface points on their way through shading: a structure of arrays. */
#ifndef SHADE_SURFACE_H
#define SHADE_SURFACE_H

#include <stdint.h>

#define LANES 16

typedef float lanes3[3][LANES];

typedef struct surface_block {
    _Alignas(64) lanes3 p;  /* the point, in the world's coordinates */
    lanes3 ng;              /* geometric normal, unit, facing the viewer */
    lanes3 ns;              /* shading normal, unit, on the same side of the surface as ng */
    lanes3 v;               /* towards the viewer, unit */
    lanes3 lift;            /* from p to where shadow rays begin: off the facet of a smooth mesh, else 0 */
    float offset[LANES];    /* how far along ±ng a ray must begin to be clear of the surface; >= 0 */
    float weight[3][LANES]; /* what radiance from here counts in its pixel */
    uint32_t slot[LANES];   /* the pixel sample it counts in */
    uint32_t material[LANES];
    uint32_t entering[LANES]; /* all ones: the viewer is outside, by the geometric normal; else 0 */
    uint32_t smooth[LANES];   /* all ones: the side of a light is judged by ns, not ng; else 0 */
    uint8_t depth[LANES], depth_behind[LANES]; /* closed meshes around the viewer's side, and around the
                                                  other; set where trace/watertight/watertight.h is in use */
    uint32_t count;                            /* lanes [0, count) are points; the rest repeats the last */
} surface_block;

/* A coordinate of where a ray begins that leaves p along ±n; offset is negative on the side away from n. */
static inline float surface_start(float p, float offset, float n) { return p + offset * n; }

/* The materials of a block, lane by lane. */
typedef struct material_block {
    _Alignas(64) lanes3 k_a;
    lanes3 k_d, k_s, k_r, k_t, k_e;
    float shininess[LANES], ior[LANES];
    uint32_t phong[LANES], blinn[LANES], fresnel[LANES], from_behind[LANES]; /* all ones or 0 */
} material_block;

#endif
