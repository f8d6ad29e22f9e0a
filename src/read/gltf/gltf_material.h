/* Materials, their variants, and their images. */
#pragma once

#include "read/gltf/gltf_data.h"

struct gltf_image {
    gltf_buffer data;   /* the bytes of a data URI, once decoded */
    bool tried, broken; /* tried: `broken` tells that it cannot be read */
};

struct gltf_material {
    fathom_id id;   /* FATHOM_NONE: not made yet */
    unsigned flags; /* flags of the meshes that have it */
    bool blends;    /* its alpha mode is BLEND or MASK */
};

/* ---- gltf_material.c ---- */

/* Material `index`; GLTF_ABSENT: glTF's default material. False: reading has failed. */
bool gltf_material_make(gltf *g, uint32_t index, gltf_material *out);

/* ---- gltf_variant.c ---- */

/* Sets g->variant to the requested variant. */
void gltf_variant_choose(gltf *g);
/* Replaces *material, the primitive's own, by the material of the variant, if the primitive has one. */
void gltf_variant_material(gltf *g, const gltf_value *primitive, uint32_t *material);

/* ---- gltf_texture.c ---- */

/* The texture that member `key` of `parent` describes; color: its values are sRGB. False if there is no
 * texture, or it cannot be read; the latter adds a note. */
bool gltf_map(gltf *g, const gltf_value *parent, const char *key, bool color, fathom_map *out);

/* ---- gltf_image.c ---- */

/* Sets the image's file or bytes in *out. If there is none, adds a note. The caller frees *path. */
void gltf_image_open(gltf *g, const gltf_value *at, fathom_texture *out, char **path);
/* False, with a note that another image is used, if the image helper cannot read the image. */
bool gltf_image_opens(gltf *g, uint32_t index);
