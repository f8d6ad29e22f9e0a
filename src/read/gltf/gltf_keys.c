#include "read/gltf/gltf_keys.h"

const char *const gltf_holder_names[GLTF_HOLDERS] = {
    [GLTF_PBR] = "pbrMetallicRoughness",
    [GLTF_IOR] = "KHR_materials_ior",
    [GLTF_SPECULAR] = "KHR_materials_specular",
    [GLTF_TRANSMISSION] = "KHR_materials_transmission",
    [GLTF_VOLUME] = "KHR_materials_volume",
    [GLTF_CLEARCOAT] = "KHR_materials_clearcoat",
    [GLTF_SHEEN] = "KHR_materials_sheen",
    [GLTF_ANISOTROPY] = "KHR_materials_anisotropy",
    [GLTF_IRIDESCENCE] = "KHR_materials_iridescence",
    [GLTF_DISPERSION] = "KHR_materials_dispersion",
    [GLTF_DIFFUSE_TRANSMISSION] = "KHR_materials_diffuse_transmission",
    [GLTF_STRENGTH] = "KHR_materials_emissive_strength",
    [GLTF_GLOSSINESS] = "KHR_materials_pbrSpecularGlossiness",
    [GLTF_UNLIT] = "KHR_materials_unlit",
};

#define NUMBER(holder, name, member, fallback, low, high)                                                    \
    { GLTF_##holder, name, offsetof(fathom_material, member), 1, fallback, low, high, 0, 0 }
#define COLOR(holder, name, member, fallback, high)                                                          \
    { GLTF_##holder, name, offsetof(fathom_material, member), 3, fallback, 0, high, 0, 0 }
#define IMAGE(holder, name, map, channel)                                                                    \
    { GLTF_##holder, name, 0, 0, 0, 0, 0, FATHOM_MAP_##map, channel }

const gltf_key gltf_keys[] = {
    NUMBER(PBR, "metallicFactor", metallic, 1, 0, 1),
    NUMBER(PBR, "roughnessFactor", roughness, 1, 0, 1),
    IMAGE(PBR, "baseColorTexture", COLOR, -1),
    IMAGE(PBR, "metallicRoughnessTexture", METALLIC, 2),
    COLOR(CORE, "emissiveFactor", emissive, 0, 1e30),
    IMAGE(CORE, "emissiveTexture", EMISSIVE, -1),
    IMAGE(CORE, "normalTexture", NORMAL, -1),
    NUMBER(IOR, "ior", ior, 1.5, 0, 1e3),
    NUMBER(SPECULAR, "specularFactor", specular_factor, 1, 0, 1),
    COLOR(SPECULAR, "specularColorFactor", specular_color, 1, 1e6),
    IMAGE(SPECULAR, "specularTexture", SPECULAR, 3),
    IMAGE(SPECULAR, "specularColorTexture", SPECULAR_COLOR, -1),
    NUMBER(TRANSMISSION, "transmissionFactor", transmission, 0, 0, 1),
    IMAGE(TRANSMISSION, "transmissionTexture", TRANSMISSION, 0),
    NUMBER(VOLUME, "thicknessFactor", thickness, 0, 0, 1e30),
    COLOR(VOLUME, "attenuationColor", attenuation_color, 1, 1),
    NUMBER(VOLUME, "attenuationDistance", attenuation_distance, 0, 0, 1e30),
    NUMBER(CLEARCOAT, "clearcoatFactor", clearcoat, 0, 0, 1),
    NUMBER(CLEARCOAT, "clearcoatRoughnessFactor", clearcoat_roughness, 0, 0, 1),
    IMAGE(CLEARCOAT, "clearcoatTexture", CLEARCOAT, 0),
    IMAGE(CLEARCOAT, "clearcoatRoughnessTexture", CLEARCOAT_ROUGHNESS, 1),
    IMAGE(CLEARCOAT, "clearcoatNormalTexture", CLEARCOAT_NORMAL, -1),
    COLOR(SHEEN, "sheenColorFactor", sheen_color, 0, 1),
    NUMBER(SHEEN, "sheenRoughnessFactor", sheen_roughness, 0, 0, 1),
    IMAGE(SHEEN, "sheenColorTexture", SHEEN_COLOR, -1),
    IMAGE(SHEEN, "sheenRoughnessTexture", SHEEN_ROUGHNESS, 3),
    NUMBER(ANISOTROPY, "anisotropyStrength", anisotropy, 0, 0, 1),
    NUMBER(ANISOTROPY, "anisotropyRotation", anisotropy_rotation, 0, -1e6, 1e6),
    IMAGE(ANISOTROPY, "anisotropyTexture", ANISOTROPY, 0),
    NUMBER(IRIDESCENCE, "iridescenceFactor", iridescence, 0, 0, 1),
    NUMBER(IRIDESCENCE, "iridescenceIor", iridescence_ior, 1.3, 1, 5),
    NUMBER(IRIDESCENCE, "iridescenceThicknessMinimum", iridescence_thickness_min, 100, 0, 1e6),
    NUMBER(IRIDESCENCE, "iridescenceThicknessMaximum", iridescence_thickness_max, 400, 0, 1e6),
    IMAGE(IRIDESCENCE, "iridescenceTexture", IRIDESCENCE, 0),
    IMAGE(IRIDESCENCE, "iridescenceThicknessTexture", IRIDESCENCE_THICKNESS, 1),
    NUMBER(DISPERSION, "dispersion", dispersion, 0, 0, 1e3),
    NUMBER(DIFFUSE_TRANSMISSION, "diffuseTransmissionFactor", diffuse_transmission, 0, 0, 1),
    COLOR(DIFFUSE_TRANSMISSION, "diffuseTransmissionColorFactor", diffuse_transmission_color, 1, 1),
    IMAGE(DIFFUSE_TRANSMISSION, "diffuseTransmissionTexture", DIFFUSE_TRANSMISSION, 3),
    IMAGE(DIFFUSE_TRANSMISSION, "diffuseTransmissionColorTexture", DIFFUSE_TRANSMISSION_COLOR, -1),
    NUMBER(STRENGTH, "emissiveStrength", emissive_strength, 1, 0, 1e30),
    COLOR(GLOSSINESS, "specularFactor", specular_color, 1, 1),
    IMAGE(GLOSSINESS, "diffuseTexture", COLOR, -1),
    IMAGE(GLOSSINESS, "specularGlossinessTexture", SPECULAR_COLOR, -1),
};
const size_t gltf_key_count = sizeof gltf_keys / sizeof *gltf_keys;
