/* The keys of glTF's materials, which the reader and the writer of glTF follow. */
#ifndef READ_GLTF_KEYS_H
#define READ_GLTF_KEYS_H

#include <fathom/scene.h>

/* The objects that hold them: the material itself, one within, or an extension. */
typedef enum gltf_holder {
    GLTF_PBR,
    GLTF_CORE,
    GLTF_IOR,
    GLTF_SPECULAR,
    GLTF_TRANSMISSION,
    GLTF_VOLUME,
    GLTF_CLEARCOAT,
    GLTF_SHEEN,
    GLTF_ANISOTROPY,
    GLTF_IRIDESCENCE,
    GLTF_DISPERSION,
    GLTF_DIFFUSE_TRANSMISSION,
    GLTF_STRENGTH,
    GLTF_GLOSSINESS, /* an older workflow, in place of GLTF_PBR */
    GLTF_UNLIT,
    GLTF_HOLDERS
} gltf_holder;

extern const char *const gltf_holder_names[GLTF_HOLDERS]; /* NULL: the material itself */

/* A number or a colour; or, without a count, an image. */
typedef struct gltf_key {
    gltf_holder of;
    const char *name;
    size_t offset; /* of the floats in fathom_material */
    unsigned count;
    double fallback, low, high; /* what glTF takes for an absent number; the range of each */
    int map, channel;           /* channel: -1 for a colour */
} gltf_key;

/* All but baseColorFactor, diffuseFactor and glossinessFactor, which are no members of a fathom_material. */
extern const gltf_key gltf_keys[];
extern const size_t gltf_key_count;

#endif
