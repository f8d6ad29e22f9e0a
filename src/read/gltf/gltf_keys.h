/* The keys of glTF's materials, used by the reader and the writer of glTF. */
#pragma once

#include <fathom/scene.h>

/* The objects that have the keys: the material itself, an object in it, or an extension. */
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
    GLTF_GLOSSINESS, /* an older workflow, instead of GLTF_PBR */
    GLTF_UNLIT,
    GLTF_HOLDERS
} gltf_holder;

extern const char *const gltf_holder_names[GLTF_HOLDERS]; /* NULL: the material itself */

/* A key for a number or a colour; if count is 0, for an image. */
typedef struct gltf_key {
    gltf_holder of;
    const char *name;
    size_t offset; /* of the floats in fathom_material */
    unsigned count;
    double fallback, low, high; /* glTF's default; the range of each number */
    int map, channel;           /* channel: -1 for a colour */
} gltf_key;

/* All keys except baseColorFactor, diffuseFactor and glossinessFactor, which have no member in
 * fathom_material. */
extern const gltf_key gltf_keys[];
extern const size_t gltf_key_count;
