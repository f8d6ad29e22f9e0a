/* Extensions of glTF's materials that path tracing alone shows: sheen, anisotropy, iridescence, dispersion
 * and diffuse transmission. */
#ifndef READ_GLTF_GLTF_LAYERS_H
#define READ_GLTF_GLTF_LAYERS_H

#include "read/gltf/gltf.h"

typedef struct gltf_layers {
    double sheen_color[3], sheen_roughness;
    double anisotropy, anisotropy_rotation;
    double iridescence, iridescence_ior, thickness[2];
    double dispersion;
    double diffuse_transmission, diffuse_transmission_color[3];
} gltf_layers;

gltf_layers gltf_layers_default(void);
/* extensions: of the material. Sets the maps that are given. */
fathom_status gltf_layers_read(gltf *g, const gltf_value *extensions, fathom_map maps[FATHOM_MAPS],
                               gltf_layers *out);
void gltf_layers_set(const gltf_layers *l, fathom_material *out);

#endif
