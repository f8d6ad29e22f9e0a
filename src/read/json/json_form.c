/* The format of scene JSON as tables. They are in one file, longer than others, because a test compares them
 * with the schema. */
#include "read/json/json_form.h"

#include "scene/settings.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#define AT(values, member) .offset = offsetof(values, member)
#define END_KEYS                                                                                             \
    { .name = NULL }
#define END_RULES                                                                                            \
    { .kind = FORM_NO_RULE }

#define POSITIVE .range = {0, INFINITY, FORM_OPEN_LOW}
#define UNIT .range = {0, 1, 0}
/* Far below the largest float, so that products of a few numbers stay finite. */
#define FLOATS .range = {-1e30, 1e30, 0}
#define RADIANCE .range = {0, 1e30, 0}

static const char group_name[] = "^[A-Za-z0-9_]{1,31}$";

static const form_unit degrees = {NULL, 0, 0};

/* ---- frames and placement ---- */

static const form_key frame_keys[] = {
    {"origin", FORM_F64, AT(form_frame_values, origin), .count = 3, .required = true},
    {"x", FORM_F64, AT(form_frame_values, x), .count = 3, .nonzero = true},
    {"y", FORM_F64, AT(form_frame_values, y), .count = 3, .nonzero = true},
    {"z", FORM_F64, AT(form_frame_values, z), .count = 3, .nonzero = true, .required = true},
    END_KEYS,
};
static const form_rule frame_rules[] = {{FORM_NEEDS, "x", {"y"}}, END_RULES};
const form form_frame = {.name = "frame", .parts = {frame_keys}, .rules = {frame_rules}};

static const form_key turn_keys[] = {
    {"axis", FORM_F64, AT(form_turn_values, axis), .count = 3, .nonzero = true, .required = true},
    {"angle", FORM_F64, AT(form_turn_values, angle), .required = true, .unit = &degrees},
    END_KEYS,
};
const form form_turn = {.name = "rotate", .parts = {turn_keys}};

#define PLACE(member) AT(form_object_values, place.member)
static const form_key place_keys[] = {
    {"translation", FORM_F64, PLACE(translation), .count = 3},
    {"rotation", FORM_F64, PLACE(rotation), .count = 4, .nonzero = true, .range = {-1, 1, 0},
     .meaning = " of the quaternion x, y, z, w (\"rotate\" takes degrees about an axis)"},
    {"rotate", FORM_OBJECT, PLACE(rotate), .form = &form_turn},
    {"scale", FORM_F64, PLACE(scale), .count = 3, .range = {0, 0, FORM_NO_ZERO}},
    {"frame", FORM_OBJECT, PLACE(frame), .form = &form_frame},
    {"matrix", FORM_F64, PLACE(matrix), .count = 16},
    END_KEYS,
};
static const form_key motion_keys[] = {
    {"motion", FORM_LIST, AT(form_object_values, motion), .count = 1, .form = &form_place_key},
    END_KEYS,
};
static const form_key time_keys[] = {{"time", FORM_F64, PLACE(time), .required = true}, END_KEYS};
static const form_rule motion_rules[] = {
    {FORM_HOLDS, "motion", {"matrix", "translation", "rotation", "rotate", "scale", "frame"}}, END_RULES};
static const form_rule place_rules[] = {
    {FORM_EXCLUDES, "matrix", {"translation", "rotation", "rotate", "scale", "frame"}},
    {FORM_EXCLUDES, "frame", {"translation", "rotation", "rotate"}},
    {FORM_EXCLUDES, "rotation", {"rotate"}},
    END_RULES,
};

const form form_place_key = {.name = "placeKey", .parts = {time_keys, place_keys}, .rules = {place_rules}};

/* ---- camera and image ---- */

static const form_key view_keys[] = {
    {"eye", FORM_F64, AT(form_camera_values, eye), .count = 3},
    {"target", FORM_F64, AT(form_camera_values, target), .count = 3},
    {"up", FORM_F64, AT(form_camera_values, up), .count = 3, .nonzero = true},
    {"frame", FORM_OBJECT, AT(form_camera_values, frame), .form = &form_frame},
    END_KEYS,
};
static const form_rule view_rules[] = {
    {FORM_NEEDS, "eye", {"target"}},
    {FORM_NEEDS, "target", {"eye"}},
    {FORM_NEEDS, "up", {"eye"}},
    END_RULES,
};
static const form_key camera_keys[] = {
    {"fovy", FORM_F64, AT(form_camera_values, fovy), .range = {0, 180, FORM_OPEN_LOW | FORM_OPEN_HIGH},
     .unit = &degrees},
    {"orthographic", FORM_F64, AT(form_camera_values, orthographic), POSITIVE},
    {"d", FORM_F64, AT(form_camera_values, d), POSITIVE},
    {"w", FORM_F64, AT(form_camera_values, w), POSITIVE},
    {"h", FORM_F64, AT(form_camera_values, h), POSITIVE},
    {"lensRadius", FORM_F64, AT(form_camera_values, lens_radius), .range = {0, INFINITY}},
    {"fStop", FORM_F64, AT(form_camera_values, f_stop), POSITIVE},
    {"focalLength", FORM_F64, AT(form_camera_values, focal_length), POSITIVE},
    {"focusDistance", FORM_F64, AT(form_camera_values, focus_distance), POSITIVE},
    {"blades", FORM_U32, AT(form_camera_values, blades), .range = {3, 64, 0}},
    {"bladeRotation", FORM_F64, AT(form_camera_values, blade_rotation), .unit = &degrees},
    {"nearClip", FORM_F64, AT(form_camera_values, near_clip), .range = {0, INFINITY}},
    {"farClip", FORM_F64, AT(form_camera_values, far_clip), POSITIVE},
    {"shutter", FORM_F64, AT(form_camera_values, shutter), .count = 2},
    {"motion", FORM_LIST, AT(form_camera_values, motion), .count = 1, .form = &form_camera_key},
    END_KEYS,
};
static const form_rule camera_rules[] = {
    {FORM_HOLDS, "motion", {"eye", "target", "up", "frame"}},
    {FORM_ONE_OF, NULL, {"eye", "frame", "motion"}},
    {FORM_NEEDS, "d", {"h"}},
    {FORM_NEEDS, "h", {"d"}},
    {FORM_NEEDS, "w", {"h"}},
    {FORM_EXCLUDES, "fovy", {"d", "w", "h"}},
    {FORM_EXCLUDES, "orthographic", {"fovy", "d", "w", "h", "lensRadius", "fStop"}},
    {FORM_NEEDS, "fStop", {"focalLength"}},
    {FORM_NEEDS, "focalLength", {"fStop"}},
    {FORM_EXCLUDES, "lensRadius", {"fStop"}},
    {FORM_NEEDS, "bladeRotation", {"blades"}},
    {FORM_WANTS_ONE_OF, "focusDistance", {"lensRadius", "fStop"}},
    {FORM_WANTS_ONE_OF, "blades", {"lensRadius", "fStop"}},
    END_RULES,
};
static const form_key camera_key_keys[] = {
    {"time", FORM_F64, AT(form_camera_values, time), .required = true},
    END_KEYS,
};
static const form_rule camera_key_rules[] = {{FORM_ONE_OF, NULL, {"eye", "frame"}}, END_RULES};
const form form_camera_key = {
    .name = "cameraKey", .parts = {camera_key_keys, view_keys}, .rules = {view_rules, camera_key_rules}};
const form form_camera = {
    .name = "camera", .parts = {view_keys, camera_keys}, .rules = {view_rules, camera_rules}};

/* Filled in by form_prepare(). */
enum { FILLED_KEYS = 48 };
static form_key image_keys[FILLED_KEYS], classic_keys[FILLED_KEYS], metallic_keys[FILLED_KEYS];
const form form_image = {.name = "image", .parts = {image_keys}};

/* ---- materials ---- */

/* In the order of fathom_wrap and of fathom_texture_filter. */
static const char wrap_words[] = "repeat|mirror|clamp",
                  filter_words[] = "nearest|linear|trilinear|stochastic";

static const form_key texture_keys[] = {
    {"file", FORM_TEXT, AT(form_texture_values, file), .required = true, .words = "."},
    {"colorSpace", FORM_TEXT, AT(form_texture_values, color_space)},
    {"channel", FORM_WORD, AT(form_texture_values, channel), .words = "r|g|b|a"},
    {"inverted", FORM_BOOL, AT(form_texture_values, inverted)},
    {"uvSet", FORM_U32, AT(form_texture_values, uv_set), UNIT},
    {"scale", FORM_F64, AT(form_texture_values, scale), .count = 2, .range = {-1e6, 1e6, 0}},
    {"rotation", FORM_F64, AT(form_texture_values, rotation), .unit = &degrees},
    {"offset", FORM_F64, AT(form_texture_values, offset), .count = 2, .range = {-1e6, 1e6, 0}},
    {"wrapU", FORM_WORD, AT(form_texture_values, wrap_u), .words = wrap_words},
    {"wrapV", FORM_WORD, AT(form_texture_values, wrap_v), .words = wrap_words},
    {"filter", FORM_WORD, AT(form_texture_values, filter), .words = filter_words},
    END_KEYS,
};
const form form_texture = {.name = "texture", .parts = {texture_keys}};

#define TEXTURE(key, kind)                                                                                   \
    { key, FORM_OBJECT, AT(form_material_values, textures[kind]), .form = &form_texture }
static const form_key classic_textures[] = {
    TEXTURE("kdTexture", FATHOM_MAP_COLOR),        TEXTURE("ksTexture", FATHOM_MAP_SPECULAR_COLOR),
    TEXTURE("keTexture", FATHOM_MAP_EMISSIVE),     TEXTURE("shininessTexture", FATHOM_MAP_SHININESS),
    TEXTURE("opacityTexture", FATHOM_MAP_OPACITY), TEXTURE("normalTexture", FATHOM_MAP_NORMAL),
    TEXTURE("bumpTexture", FATHOM_MAP_BUMP),       END_KEYS,
};
static const form_key metallic_textures[] = {
    TEXTURE("baseColorTexture", FATHOM_MAP_COLOR),
    TEXTURE("metallicTexture", FATHOM_MAP_METALLIC),
    TEXTURE("roughnessTexture", FATHOM_MAP_ROUGHNESS),
    TEXTURE("metallicRoughnessTexture", FORM_METALLIC_ROUGHNESS),
    TEXTURE("emissiveTexture", FATHOM_MAP_EMISSIVE),
    TEXTURE("normalTexture", FATHOM_MAP_NORMAL),
    TEXTURE("bumpTexture", FATHOM_MAP_BUMP),
    TEXTURE("transmissionTexture", FATHOM_MAP_TRANSMISSION),
    TEXTURE("specularTexture", FATHOM_MAP_SPECULAR),
    TEXTURE("specularColorTexture", FATHOM_MAP_SPECULAR_COLOR),
    TEXTURE("clearcoatTexture", FATHOM_MAP_CLEARCOAT),
    TEXTURE("clearcoatRoughnessTexture", FATHOM_MAP_CLEARCOAT_ROUGHNESS),
    TEXTURE("clearcoatNormalTexture", FATHOM_MAP_CLEARCOAT_NORMAL),
    TEXTURE("sheenColorTexture", FATHOM_MAP_SHEEN_COLOR),
    TEXTURE("sheenRoughnessTexture", FATHOM_MAP_SHEEN_ROUGHNESS),
    TEXTURE("anisotropyTexture", FATHOM_MAP_ANISOTROPY),
    TEXTURE("iridescenceTexture", FATHOM_MAP_IRIDESCENCE),
    TEXTURE("iridescenceThicknessTexture", FATHOM_MAP_IRIDESCENCE_THICKNESS),
    TEXTURE("diffuseTransmissionTexture", FATHOM_MAP_DIFFUSE_TRANSMISSION),
    TEXTURE("diffuseTransmissionColorTexture", FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR),
    TEXTURE("opacityTexture", FATHOM_MAP_OPACITY),
    END_KEYS,
};
static const form_rule metallic_rules[] = {
    {FORM_EXCLUDES, "metallicRoughnessTexture", {"metallicTexture", "roughnessTexture"}},
    {FORM_NEEDS, "dispersion", {"thickness"}},
    {FORM_NEEDS, "priority", {"thickness"}},
    {FORM_WANTS, "dispersion", {"transmission"}},
    {FORM_WANTS, "emissiveStrength", {"emissive"}},
    {FORM_WANTS, "emissiveTexture", {"emissive"}},
    {FORM_WANTS, "metallicTexture", {"metallic"}},
    {FORM_WANTS, "transmissionTexture", {"transmission"}},
    {FORM_WANTS, "attenuationColor", {"attenuationDistance", "thickness"}},
    {FORM_WANTS_ONE_OF, "attenuationColor", {"transmission", "diffuseTransmission"}},
    {FORM_WANTS, "attenuationDistance", {"attenuationColor", "thickness"}},
    {FORM_WANTS_ONE_OF, "attenuationDistance", {"transmission", "diffuseTransmission"}},
    {FORM_WANTS, "clearcoatTexture", {"clearcoat"}},
    {FORM_WANTS, "clearcoatRoughness", {"clearcoat"}},
    {FORM_WANTS, "clearcoatRoughnessTexture", {"clearcoat", "clearcoatRoughness"}},
    {FORM_WANTS, "clearcoatNormalTexture", {"clearcoat"}},
    {FORM_WANTS, "clearcoatNormalScale", {"clearcoat", "clearcoatNormalTexture"}},
    {FORM_WANTS, "sheenColorTexture", {"sheenColor"}},
    {FORM_WANTS, "sheenRoughness", {"sheenColor"}},
    {FORM_WANTS, "sheenRoughnessTexture", {"sheenColor", "sheenRoughness"}},
    {FORM_WANTS, "anisotropyRotation", {"anisotropy"}},
    {FORM_WANTS, "anisotropyTexture", {"anisotropy"}},
    {FORM_WANTS, "iridescenceTexture", {"iridescence"}},
    {FORM_WANTS, "iridescenceThicknessTexture", {"iridescence"}},
    {FORM_WANTS, "iridescenceIor", {"iridescence"}},
    {FORM_WANTS, "iridescenceThicknessMin", {"iridescence", "iridescenceThicknessTexture"}},
    {FORM_WANTS, "iridescenceThicknessMax", {"iridescence"}},
    {FORM_WANTS, "diffuseTransmissionTexture", {"diffuseTransmission"}},
    {FORM_WANTS, "diffuseTransmissionColor", {"diffuseTransmission"}},
    {FORM_WANTS, "diffuseTransmissionColorTexture", {"diffuseTransmission"}},
    {FORM_WANTS, "normalScale", {"normalTexture"}},
    {FORM_WANTS, "bumpScale", {"bumpTexture"}},
    /* The reader adds the opacities of meshes. */
    {FORM_WANTS_ONE_OF, "opacityCutoff", {"opacity", "opacityTexture", FORM_OPACITIES}},
    END_RULES,
};

/* Without a lobe, k_s and its exponent would have no effect. */
static const form_rule classic_rules[] = {
    {FORM_NEEDS, "ks", {"specular"}},           {FORM_NEEDS, "shininess", {"specular"}},
    {FORM_WANTS, "specular", {"ks"}},           {FORM_WANTS, "shininess", {"ks"}},
    {FORM_WANTS, "ksTexture", {"ks"}},          {FORM_WANTS, "shininessTexture", {"ks"}},
    {FORM_WANTS, "keTexture", {"ke"}},          {FORM_WANTS_ONE_OF, "fresnel", {"kr", "kt"}},
    {FORM_WANTS_ONE_OF, "ior", {"kr", "kt"}},   {FORM_WANTS, "normalScale", {"normalTexture"}},
    {FORM_WANTS, "bumpScale", {"bumpTexture"}}, END_RULES,
};
static const form_key model_keys[] = {
    {"model", FORM_TAG, .required = false},
    {"group", FORM_TEXT, AT(form_material_values, group), .words = group_name},
    END_KEYS};
static const form classic_form = {.name = "classic",
                                  .id = FATHOM_MODEL_CLASSIC,
                                  .parts = {model_keys, classic_keys, classic_textures},
                                  .rules = {classic_rules}};
static const form metallic_form = {.name = "metallicRoughness",
                                   .id = FATHOM_MODEL_METALLIC_ROUGHNESS,
                                   .parts = {model_keys, metallic_keys, metallic_textures},
                                   .rules = {metallic_rules}};
static const form *const material_forms[] = {&classic_form, &metallic_form, NULL};
const form form_material = {.name = "material", .variants = material_forms, .tag = "model"};

/* ---- lights ---- */

static const form_key light_keys[] = {
    {"type", FORM_TAG, .required = true},
    {"name", FORM_TEXT, AT(form_light_values, name)},
    {"group", FORM_TEXT, AT(form_light_values, group), .words = group_name},
    {"color", FORM_F32, AT(form_light_values, color), .count = 3, RADIANCE},
    {"intensity", FORM_F32, AT(form_light_values, intensity), RADIANCE},
    END_KEYS,
};
static const form_key position_keys[] = {
    {"position", FORM_F64, AT(form_light_values, position), .count = 3, .required = true},
    {"radius", FORM_F32, AT(form_light_values, radius), .range = {0, 1e18, 0}},
    {"radiantIntensity", FORM_F32, AT(form_light_values, radiant_intensity), RADIANCE},
    END_KEYS,
};
static const form_rule position_rules[] = {{FORM_EXCLUDES, "intensity", {"radiantIntensity"}}, END_RULES};
static const form_key direction_keys[] = {
    {"direction", FORM_F64, AT(form_light_values, direction), .count = 3, .nonzero = true, .required = true},
    {"irradiance", FORM_F32, AT(form_light_values, irradiance), RADIANCE},
    END_KEYS,
};
static const form_rule direction_rules[] = {{FORM_EXCLUDES, "intensity", {"irradiance"}}, END_RULES};
static const form_key sun_keys[] = {
    {"angularDiameter", FORM_F64, AT(form_light_values, angular_diameter), .range = {0, 180, FORM_OPEN_HIGH}},
    END_KEYS,
};
static const form_key environment_keys[] = {
    {"file", FORM_TEXT, AT(form_light_values, file), .required = true, .words = "."},
    {"rotation", FORM_F64, AT(form_light_values, rotation), .unit = &degrees},
    {"up", FORM_F64, AT(form_light_values, up), .count = 3, .nonzero = true},
    END_KEYS,
};
static const form_key spot_keys[] = {
    {"direction", FORM_F64, AT(form_light_values, direction), .count = 3, .nonzero = true},
    {"target", FORM_F64, AT(form_light_values, target), .count = 3},
    {"innerAngle", FORM_F64, AT(form_light_values, inner_angle), .range = {0, 90, FORM_OPEN_HIGH}},
    {"outerAngle", FORM_F64, AT(form_light_values, outer_angle), .range = {0, 90, FORM_OPEN_LOW},
     .unit = &degrees},
    END_KEYS,
};
static const form_rule spot_rules[] = {{FORM_ONE_OF, NULL, {"direction", "target"}}, END_RULES};

static const form point_form = {
    .name = "point", .id = FORM_POINT, .parts = {light_keys, position_keys}, .rules = {position_rules}};
static const form directional_form = {.name = "directional",
                                      .id = FORM_DIRECTIONAL,
                                      .parts = {light_keys, direction_keys},
                                      .rules = {direction_rules}};
static const form spot_form = {.name = "spot",
                               .id = FORM_SPOT,
                               .parts = {light_keys, position_keys, spot_keys},
                               .rules = {position_rules, spot_rules}};
static const form sun_form = {.name = "sun",
                              .id = FORM_SUN,
                              .parts = {light_keys, direction_keys, sun_keys},
                              .rules = {direction_rules}};
static const form environment_form = {
    .name = "environment", .id = FORM_ENVIRONMENT, .parts = {light_keys, environment_keys}};
static const form *const light_forms[] = {&point_form, &directional_form, &spot_form,
                                          &sun_form,   &environment_form, NULL};
const form form_light = {.name = "light", .variants = light_forms};

/* ---- objects ---- */

#define OBJECT(member) AT(form_object_values, member)
static const form_key object_keys[] = {
    {"type", FORM_TAG, .required = true},
    {"name", FORM_TEXT, OBJECT(name)},
    {"material", FORM_TEXT, OBJECT(material),
     .meaning = ", the name of a material in \"materials\" of the scene"},
    END_KEYS,
};
static const form_key shadow_keys[] = {{"castsShadow", FORM_BOOL, OBJECT(casts_shadow)},
                                       {"group", FORM_TEXT, OBJECT(light_group), .words = group_name},
                                       END_KEYS};

static const form_key sphere_keys[] = {
    {"center", FORM_F64, OBJECT(as.sphere.center), .count = 3, .required = true},
    {"radius", FORM_F64, OBJECT(as.sphere.radius), POSITIVE, .required = true},
    END_KEYS,
};
static const form_key quad_keys[] = {
    {"corners", FORM_F64, OBJECT(as.quad.corners), .count = 3, .rows = 4},
    {"center", FORM_F64, OBJECT(as.quad.center), .count = 3},
    {"u", FORM_F64, OBJECT(as.quad.u), .count = 3, .nonzero = true},
    {"v", FORM_F64, OBJECT(as.quad.v), .count = 3, .nonzero = true},
    END_KEYS,
};
static const form_rule quad_rules[] = {
    {FORM_ONE_OF, NULL, {"corners", "center"}},
    {FORM_NEEDS, "center", {"u", "v"}},
    {FORM_NEEDS, "u", {"center"}},
    {FORM_NEEDS, "v", {"center"}},
    END_RULES,
};
static const form_key plane_keys[] = {
    {"point", FORM_F64, OBJECT(as.plane.point), .count = 3, .required = true},
    {"normal", FORM_F64, OBJECT(as.plane.normal), .count = 3, .nonzero = true, .required = true},
    END_KEYS,
};
static const form_key triangle_keys[] = {
    {"vertices", FORM_F64, OBJECT(as.triangle.vertices), FLOATS, .count = 3, .rows = 3, .required = true},
    {"normals", FORM_F64, OBJECT(as.triangle.normals), FLOATS, .count = 3, .rows = 3},
    {"uvs", FORM_F64, OBJECT(as.triangle.uvs), FLOATS, .count = 2, .rows = 3},
    END_KEYS,
};

/* In the order of form_shading. */
static const char shading_words[] = "given|flat|smooth";

static const form_key mesh_keys[] = {
    {"file", FORM_TEXT, OBJECT(as.mesh.file), .words = "."},
    {"positions", FORM_ROWS, OBJECT(as.mesh.positions), FLOATS, .count = 3},
    {"indices", FORM_ROWS, OBJECT(as.mesh.indices), .count = 3, .whole = true, .range = {0, UINT32_MAX, 0}},
    {"normals", FORM_ROWS, OBJECT(as.mesh.normals), FLOATS, .count = 3},
    {"uvs", FORM_ROWS, OBJECT(as.mesh.uvs), FLOATS, .count = 2},
    {"uvs1", FORM_ROWS, OBJECT(as.mesh.uvs_1), FLOATS, .count = 2},
    {"colors", FORM_ROWS, OBJECT(as.mesh.colors), .count = 3, RADIANCE},
    {FORM_OPACITIES, FORM_ROWS, OBJECT(as.mesh.opacities), .count = 1, UNIT},
    {"tangents", FORM_ROWS, OBJECT(as.mesh.tangents), .count = 4, FLOATS},
    {"pointRadius", FORM_F32, OBJECT(as.mesh.point_radius), .range = {1e-30, 1e30, 0}},
    {"shading", FORM_WORD, OBJECT(as.mesh.shading), .words = shading_words},
    {"vertexKeys", FORM_LIST, OBJECT(as.mesh.keys), .count = 1, .form = &form_vertex_key},
    END_KEYS,
};
static const form_key vertex_key_keys[] = {
    {"time", FORM_F64, AT(form_vertex_values, time), .required = true},
    {"positions", FORM_ROWS, AT(form_vertex_values, positions), FLOATS, .count = 3, .required = true},
    {"normals", FORM_ROWS, AT(form_vertex_values, normals), FLOATS, .count = 3},
    END_KEYS,
};
const form form_vertex_key = {.name = "vertexKey", .parts = {vertex_key_keys}};
static const form_rule mesh_rules[] = {
    {FORM_ONE_OF, NULL, {"file", "indices", "pointRadius"}},
    {FORM_EXCLUDES, "file", {"positions"}},
    {FORM_NEEDS, "indices", {"positions"}},
    {FORM_NEEDS, "pointRadius", {"positions"}},
    {FORM_NEEDS, "normals", {"indices"}},
    {FORM_NEEDS, "uvs", {"indices"}},
    {FORM_NEEDS, "uvs1", {"indices"}},
    {FORM_NEEDS, "colors", {"positions"}},
    {FORM_NEEDS, "opacities", {"colors"}},
    {FORM_NEEDS, "tangents", {"indices"}},
    {FORM_NEEDS, "vertexKeys", {"indices"}},
    END_RULES,
};

/* In the order of fathom_generator. */
static const char generator_words[] = "sphere|terrain|sponge|forest";

static const form_key generate_keys[] = {
    {"kind", FORM_WORD, OBJECT(as.generate.kind), .words = generator_words, .required = true},
    {"triangles", FORM_U64, OBJECT(as.generate.triangles), .range = {1, 1e11, 0}, .required = true},
    {"seed", FORM_U64, OBJECT(as.generate.seed), .range = {0, 9007199254740991, 0}},
    END_KEYS,
};
static const form_key group_keys[] = {
    {"children", FORM_LIST, OBJECT(as.group.children), .form = &form_object, .required = true},
    END_KEYS,
};
static const form_key instance_keys[] = {
    {"of", FORM_TEXT, OBJECT(as.instance.of), .required = true,
     .meaning = ", the name of a group in \"groups\" of the scene"},
    END_KEYS,
};

/* Every shape can have a material, a transform and a motion, and can be set to cast no shadow. */
#define SHAPE(shape, shape_id, shape_rules)                                                                  \
    {                                                                                                        \
        .name = #shape, .id = shape_id,                                                                      \
        .parts = {object_keys, shape##_keys, shadow_keys, place_keys, motion_keys}, .rules = {               \
            motion_rules,                                                                                    \
            place_rules,                                                                                     \
            shape_rules                                                                                      \
        }                                                                                                    \
    }

static const form sphere_form = SHAPE(sphere, FORM_SPHERE, NULL);
static const form quad_form = SHAPE(quad, FORM_QUAD, quad_rules);
static const form plane_form = SHAPE(plane, FORM_PLANE, NULL);
static const form triangle_form = SHAPE(triangle, FORM_TRIANGLE, NULL);
static const form mesh_form = SHAPE(mesh, FORM_MESH, mesh_rules);
static const form generate_form = SHAPE(generate, FORM_GENERATE, NULL);
static const form group_form = {.name = "group",
                                .id = FORM_GROUP,
                                .parts = {object_keys, group_keys, place_keys, motion_keys},
                                .rules = {motion_rules, place_rules}};
static const form instance_form = {.name = "instance",
                                   .id = FORM_INSTANCE,
                                   .parts = {object_keys, instance_keys, place_keys, motion_keys},
                                   .rules = {motion_rules, place_rules}};
static const form *const object_forms[] = {&sphere_form,   &quad_form,     &plane_form,
                                           &triangle_form, &mesh_form,     &generate_form,
                                           &group_form,    &instance_form, NULL};
const form form_object = {.name = "object", .variants = object_forms};

/* ---- the document ---- */

static const form_key scene_keys[] = {
    {"$schema", FORM_TEXT, AT(form_scene_values, schema)},
    {"name", FORM_TEXT, AT(form_scene_values, name)},
    {"camera", FORM_OBJECT, AT(form_scene_values, camera), .form = &form_camera},
    {"image", FORM_OBJECT, AT(form_scene_values, image), .form = &form_image},
    {"background", FORM_F32, AT(form_scene_values, background), .count = 3, RADIANCE},
    {"backgroundGroup", FORM_TEXT, AT(form_scene_values, background_group), .words = group_name},
    {"ambient", FORM_F32, AT(form_scene_values, ambient), .count = 3, RADIANCE},
    {"materials", FORM_MAP, AT(form_scene_values, materials), .form = &form_material},
    {"lights", FORM_LIST, AT(form_scene_values, lights), .form = &form_light},
    {"groups", FORM_MAP_OF_LISTS, AT(form_scene_values, groups), .form = &form_object},
    {"objects", FORM_LIST, AT(form_scene_values, objects), .form = &form_object, .required = true},
    END_KEYS,
};
const form form_scene = {.name = "scene", .parts = {scene_keys}};

/* ---- settings and material parameters ---- */

_Static_assert((int)FORM_TEXT == FATHOM_PARAMETER_TEXT, "kinds begin with the types of parameters");

/* Integers up to 2^53 - 1 mean the same in every JSON tool. */
#define MOST_INTEGER 9007199254740991.0

static form_range range_of(const fathom_parameter *p) {
    const bool above = p->flags & FATHOM_PARAMETER_OPEN_LOW && !p->zero;
    return (form_range){
        p->zero ? 0 : p->low, p->type == FATHOM_PARAMETER_U64 ? fmin(p->high, MOST_INTEGER) : p->high,
        (above ? FORM_OPEN_LOW : 0u) | (p->flags & FATHOM_PARAMETER_OPEN_HIGH ? FORM_OPEN_HIGH : 0u)};
}

static const form_unit *unit_of(const char *name) {
    static const struct {
        const char *key;
        form_unit unit;
    } units[] = {{"anisotropyRotation", {"radians", 0, 7}},
                 {"iridescenceThicknessMin", {"nanometres", 1, 1e5}},
                 {"iridescenceThicknessMax", {"nanometres", 1, 1e5}},
                 {"dispersion", {"20 divided by the Abbe number", 0, 15}}};
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i)
        if (strcmp(units[i].key, name) == 0) return &units[i].unit;
    return NULL;
}

/* names: memory for the names of the keys; it must outlive the keys. */
static void fill_keys(parameter_table table, form_key *keys, char names[][PARAMETER_NAME]) {
    for (size_t i = 0; i < table.count; ++i) {
        const fathom_parameter *p = &table.rows[i];
        if (!(p->flags & FATHOM_PARAMETER_FILE)) continue;
        parameter_name(p, 0, *names);
        *keys++ = (form_key){.name = *names,
                             .kind = (form_kind)p->type,
                             .offset = p->offset,
                             .range = range_of(p),
                             .count = p->count,
                             .words = p->words,
                             .unit = unit_of(*names)};
        ++names;
    }
}

static void fill(void) {
    static char names[3][FILLED_KEYS][PARAMETER_NAME];
    fill_keys(settings_table, image_keys, names[0]);
    fill_keys(classic_table, classic_keys, names[1]);
    fill_keys(metallic_table, metallic_keys, names[2]);
}

void form_prepare(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, fill);
}

const form_key *form_find(const form *f, const char *name) {
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (strcmp(key->name, name) == 0) return key;
        }
    }
    return NULL;
}
