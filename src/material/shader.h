/* Materials under path tracing: BSDFs that are evaluated and sampled, sixteen points at a time.
 *
 * The density of a direction is counted per solid angle, over all lobes. A direction that a smooth lobe
 * (mirror, clear glass) chooses has no density: it is marked by an infinite one, and evaluate() leaves such
 * lobes out. Directions l and v point away from the surface. */
#ifndef MATERIAL_SHADER_H
#define MATERIAL_SHADER_H

#include "scene/scene.h"
#include "surface/surface.h"

/* A material's constants, made once before rendering. */
typedef struct shader {
    fathom_model model;
    float emission[3];   /* radiance of both sides */
    float albedo[3];     /* for the AOV: what it reflects or lets through of white light, about */
    float absorption[3]; /* per unit of length, of the volume that the surface encloses: -ln c / d; else 0 */
    float opacity;       /* chance that a ray meets the surface at all */
    bool transmits;      /* some lobe sends light to the other side */
    /* The members below are the model's own; materials of the classic model are read as LIGHT.md says. */
    fathom_material values;
} shader;

void shader_prepare(const fathom_material *material, shader *out);

/* The BSDFs of a block of points: what evaluate() and sample() need of the materials and the viewer. */
typedef struct shader_block {
    const shader *at[LANES]; /* of each lane */
} shader_block;

/* One direction a lane that continues a path. */
typedef struct shader_sample {
    _Alignas(64) lanes3 direction; /* unit */
    lanes3 weight; /* f |cosine| / density: what radiance along the ray counts at the point; 0: the path
                      ends (absorbed, or the direction left the side it was meant for) */
    float density[LANES];    /* INFINITY: a smooth lobe's */
    uint32_t through[LANES]; /* all ones: the ray leaves on the side that the viewer is not on; else 0 */
} shader_sample;

typedef struct shader_kernels {
    /* `table` is indexed by material id. */
    void (*make)(const shader *table, const surface_block *s, shader_block *out);

    /* Of light from unit directions l: f |cosine|, and the density with which sample() takes l. */
    void (*evaluate)(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]);

    /* u: three numbers in [0,1) a lane; the third chooses the lobe. */
    void (*sample)(const surface_block *s, const shader_block *b, const lanes3 u, shader_sample *out);
} shader_kernels;

const shader_kernels *shader_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const shader_kernels *shader_kernels_at(unsigned index);

#endif
