#include "read/gltf/gltf_layers.h"

#include <string.h>

gltf_layers gltf_layers_default(void) {
    return (gltf_layers){
        .iridescence_ior = 1.3, .thickness = {100, 400}, .diffuse_transmission_color = {1, 1, 1}};
}

/* One of these keys: a number, a colour (count 3), or an image of `map`. */
typedef struct layer_key {
    const char *name;
    size_t offset; /* in gltf_layers */
    unsigned count;
    double low, high;
    int map, channel; /* channel: -1 for a colour */
} layer_key;

#define NUMBER(key, member, low, high)                                                                       \
    { key, offsetof(gltf_layers, member), 1, low, high, -1, 0 }
#define COLOR(key, member)                                                                                   \
    { key, offsetof(gltf_layers, member), 3, 0, 1, -1, 0 }
#define IMAGE(key, map, channel)                                                                             \
    { key, 0, 0, 0, 0, map, channel }
enum { LAYER_KEYS = 6 };

static const struct layer {
    const char *name;
    layer_key keys[LAYER_KEYS + 1];
} layers[] = {
    {"KHR_materials_sheen",
     {COLOR("sheenColorFactor", sheen_color), NUMBER("sheenRoughnessFactor", sheen_roughness, 0, 1),
      IMAGE("sheenColorTexture", FATHOM_MAP_SHEEN_COLOR, -1),
      IMAGE("sheenRoughnessTexture", FATHOM_MAP_SHEEN_ROUGHNESS, 3)}},
    {"KHR_materials_anisotropy",
     {NUMBER("anisotropyStrength", anisotropy, 0, 1),
      NUMBER("anisotropyRotation", anisotropy_rotation, -1e6, 1e6),
      IMAGE("anisotropyTexture", FATHOM_MAP_ANISOTROPY, 0)}},
    {"KHR_materials_iridescence",
     {NUMBER("iridescenceFactor", iridescence, 0, 1), NUMBER("iridescenceIor", iridescence_ior, 1, 5),
      NUMBER("iridescenceThicknessMinimum", thickness[0], 0, 1e6),
      NUMBER("iridescenceThicknessMaximum", thickness[1], 0, 1e6),
      IMAGE("iridescenceTexture", FATHOM_MAP_IRIDESCENCE, 0),
      IMAGE("iridescenceThicknessTexture", FATHOM_MAP_IRIDESCENCE_THICKNESS, 1)}},
    {"KHR_materials_dispersion", {NUMBER("dispersion", dispersion, 0, 1e3)}},
    {"KHR_materials_diffuse_transmission",
     {NUMBER("diffuseTransmissionFactor", diffuse_transmission, 0, 1),
      COLOR("diffuseTransmissionColorFactor", diffuse_transmission_color),
      IMAGE("diffuseTransmissionTexture", FATHOM_MAP_DIFFUSE_TRANSMISSION, 3),
      IMAGE("diffuseTransmissionColorTexture", FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR, -1)}},
};

/* An image that cannot be read is noted, and the layer that it would vary is left out. */
static fathom_status read_image(gltf *g, const gltf_value *at, const layer_key *key,
                                fathom_map maps[FATHOM_MAPS], gltf_layers *out) {
    bool there;
    fathom_map map;
    fathom_status status = gltf_map(g, at, key->name, key->channel < 0, &there, &map);
    if (status != FATHOM_OK || !json_object_get(at->json, key->name)) return status;
    if (there) {
        maps[key->map] = map;
        maps[key->map].channel = key->channel < 0 ? 0 : (uint32_t)key->channel;
        return status;
    }
    if (key->map == FATHOM_MAP_SHEEN_COLOR) memset(out->sheen_color, 0, sizeof out->sheen_color);
    if (key->map == FATHOM_MAP_ANISOTROPY) out->anisotropy = 0;
    if (key->map == FATHOM_MAP_IRIDESCENCE) out->iridescence = 0;
    if (key->map == FATHOM_MAP_DIFFUSE_TRANSMISSION) out->diffuse_transmission = 0;
    return status;
}

static fathom_status read_key(gltf *g, const gltf_value *at, const layer_key *key,
                              fathom_map maps[FATHOM_MAPS], gltf_layers *out) {
    double *to = (double *)(void *)((char *)out + key->offset);
    if (!key->count) return read_image(g, at, key, maps, out);
    if (key->count == 1) return gltf_number(g, at, key->name, key->low, key->high, to);
    return gltf_numbers(g, at, key->name, key->count, key->low, key->high, to);
}

fathom_status gltf_layers_read(gltf *g, const gltf_value *extensions, fathom_map maps[FATHOM_MAPS],
                               gltf_layers *out) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < sizeof layers / sizeof *layers && status == FATHOM_OK; ++i) {
        gltf_value layer;
        status = gltf_object(g, extensions, layers[i].name, &layer);
        for (const layer_key *key = layers[i].keys; key->name && layer.json && status == FATHOM_OK; ++key)
            status = read_key(g, &layer, key, maps, out);
    }
    return status;
}

void gltf_layers_set(const gltf_layers *l, fathom_material *out) {
    for (int c = 0; c < 3; ++c) {
        out->sheen_color[c] = (float)l->sheen_color[c];
        out->diffuse_transmission_color[c] = (float)l->diffuse_transmission_color[c];
    }
    out->sheen_roughness = (float)l->sheen_roughness;
    out->anisotropy = (float)l->anisotropy, out->anisotropy_rotation = (float)l->anisotropy_rotation;
    out->iridescence = (float)l->iridescence, out->iridescence_ior = (float)l->iridescence_ior;
    out->iridescence_thickness_min = (float)l->thickness[0];
    out->iridescence_thickness_max = (float)l->thickness[1];
    out->dispersion = (float)l->dispersion, out->diffuse_transmission = (float)l->diffuse_transmission;
}
