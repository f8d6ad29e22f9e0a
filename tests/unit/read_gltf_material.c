/* glTF materials: the mapping's laws, and each kind of material by name. */
#include "gltf_file.h"
#include "materials.h"

#include "scene/mesh/absent.h"

static const double pi = 3.14159265358979324;

/* The scene's first material of its own; everything else is as in the file. */
static scene_named_material read_both(const char *material) {
    fathom_scene *scene = read_triangle(unit_text(
        SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'materials':[{%s}]"),
        material));
    assert_int_equal(scene->materials.count, 2);
    assert_int_equal(scene->meshes.items[0].material, 1);
    scene_named_material out = scene->materials.items[1];
    out.name = NULL;
    return out;
}

static fathom_material read_material(const char *material) { return read_both(material).classic; }

static fathom_material read_factors(double base, double metallic, double roughness, const char *more) {
    return read_material(unit_text(
        "'pbrMetallicRoughness':{'baseColorFactor':[%g,%g,%g,1],'metallicFactor':%g,'roughnessFactor':%g}%s",
        base, base / 2, base / 4, metallic, roughness, more));
}

/* The integral of (n·h)^n cos over the light's directions, seen head on: h lies half way between normal and
 * light. Midpoints; t = cos of the half angle runs over [cos 45°, 1]. */
static double lobe_integral(double n) {
    const int steps = 200000;
    double sum = 0, low = sqrt(0.5), width = (1 - low) / steps;
    for (int i = 0; i < steps; ++i) {
        double t = low + (i + 0.5) * width;
        /* cos theta = 2t^2 - 1, sin theta dtheta = 4t dt */
        sum += pow(t, n) * (2 * t * t - 1) * 4 * t * width;
    }
    return 2 * pi * sum;
}

/* The highlight of a rough surface sends back F0 of the light that meets it head on: k_s times the lobe's
 * integral is pi F0 (the model's terms carry no 1 / pi). F0 of glass 1.5 is 0.04. */
UNIT_TEST(highlight_reflects_f0) {
    const double roughness[] = {1, 0.8, 0.6, 0.5};
    for (size_t i = 0; i < sizeof roughness / sizeof *roughness; ++i) {
        fathom_material m = read_factors(0.25, 0, roughness[i], "");
        double reflected = (double)m.k_s[0] * lobe_integral((double)m.shininess) / pi;
        /* Midpoint rule with 2e5 steps on a smooth integrand, and floats: 1e-6. */
        assert_near(reflected / 0.04, 1, 1e-6);
    }
    fathom_material metal = read_factors(0.5, 1, 1, "");
    assert_near((double)metal.k_s[0] * lobe_integral((double)metal.shininess) / pi, 0.5, 1e-6);
}

/* A leaf passes half of its light on: the classic model lights it from both sides, each half as much. */
UNIT_TEST(diffuse_transmission_lights_from_behind) {
    const fathom_material matt = read_factors(0.5, 0, 1, ""),
                          leaf = read_factors(0.5, 0, 1,
                                              ",'extensions':{'KHR_materials_diffuse_transmission':{"
                                              "'diffuseTransmissionFactor':0.5}}");
    assert_true(leaf.lit_from_behind && !matt.lit_from_behind);
    for (int c = 0; c < 3; ++c) assert_near(leaf.k_d[c], 0.5 * (double)matt.k_d[c], 0x1p-24);
}

static double normal_reflectance(double ior) { return pow((ior - 1) / (ior + 1), 2); }

/* No material of the format makes light: for every combination of factors, in every channel, k_d + k_s <= 1
 * and k_d + k_r F + k_t (1 - F) <= 1 head on, and no coefficient is negative. */
UNIT_TEST(no_material_makes_light) {
    const double values[] = {0, 0.3, 0.7, 1}, iors[] = {0, 1, 1.5, 2.4};
    for (int i = 0; i < 1024; ++i) {
        double base = values[i % 4], metallic = values[i / 4 % 4], roughness = values[i / 16 % 4],
               transmission = values[i / 64 % 4], ior = iors[i / 256];
        fathom_material m =
            read_factors(base, metallic, roughness,
                         unit_text(",'alphaMode':'%s','extensions':{'KHR_materials_ior':{'ior':%g},"
                                   "'KHR_materials_transmission':{'transmissionFactor':%g}}",
                                   i % 3 ? "OPAQUE" : "BLEND", ior, transmission));
        double fresnel = normal_reflectance((double)m.ior);
        assert_true(m.shininess >= 1 && m.shininess <= 1e6f && m.ior > 0);
        for (int c = 0; c < 3; ++c) {
            double r = (double)m.k_r[c] * (m.fresnel ? fresnel : 1), d = (double)m.k_d[c],
                   t = (double)m.k_t[c] * (m.fresnel ? 1 - fresnel : 1);
            assert_true(m.k_d[c] >= 0 && m.k_s[c] >= 0 && m.k_r[c] >= 0 && m.k_t[c] >= 0 && m.k_a[c] >= 0);
            /* Sums of a few floats below 1. */
            assert_true(d + (double)m.k_s[c] <= 1 + 4 * 0x1p-24);
            assert_true(d + r + t <= 1 + 4 * 0x1p-24);
        }
    }
}

UNIT_TEST(plastic_and_metal_follow_their_formulas) {
    fathom_material plastic = read_factors(0.8, 0, 0.5, "");
    assert_near(plastic.k_d[0], 0.8 * 0.96, 0x1p-24);
    assert_near(plastic.k_d[2], 0.2 * 0.96, 0x1p-24);
    assert_int_equal(plastic.specular, FATHOM_SPECULAR_BLINN);
    assert_near(plastic.shininess, 2 / pow(0.5, 4) - 2, 1e-5);
    assert_near(plastic.k_s[0], plastic.k_s[2], 0); /* white highlight */
    assert_near(plastic.k_r[0], 0, 0);
    fathom_material metal = read_factors(0.8, 1, 0.5, "");
    assert_near(metal.k_d[0], 0, 0);
    assert_near(metal.k_s[0] / metal.k_s[2], 4, 1e-6); /* coloured highlight */
    fathom_material mirror = read_factors(0.8, 1, 0, "");
    assert_false(mirror.fresnel);
    assert_near(mirror.k_r[0], 0.8, 0x1p-24);
    assert_near(mirror.k_r[2], 0.2, 0x1p-24);
    fathom_material polished = read_factors(0.8, 0, 0, "");
    assert_true(polished.fresnel);
    assert_near(polished.k_r[0], 1, 0);
}

UNIT_TEST(glass_transmits_its_colour) {
    fathom_material m = read_factors(1, 0, 0,
                                     ",'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
                                     "'KHR_materials_ior':{'ior':1.33}}");
    assert_true(m.fresnel);
    assert_near(m.ior, 1.33, 0x1p-23);
    assert_near(m.k_t[0], 1, 0);
    assert_near(m.k_t[1], 0.5, 0);
    assert_near(m.k_r[0], 1, 0);
    assert_near(m.k_d[0], 0, 0);
    /* A metal lets nothing through. */
    m = read_factors(1, 1, 0, ",'extensions':{'KHR_materials_transmission':{'transmissionFactor':1}}");
    assert_near(m.k_t[0], 0, 0);
}

UNIT_TEST(ior_zero_takes_the_specular_colour) {
    fathom_material none =
        read_factors(0.8, 0, 0, ",'extensions':{'KHR_materials_specular':{'specularFactor':0}}");
    assert_near(none.k_d[0], 0.8, 0x1p-24);
    assert_near(none.k_s[0] + none.k_r[0], 0, 0);
    /* The specular-glossiness workflow carried over: F0 is the specular colour. */
    fathom_material old =
        read_factors(0.5, 0, 0,
                     ",'extensions':{'KHR_materials_ior':{'ior':0},'KHR_materials_specular':{"
                     "'specularColorFactor':[0.75,0.5,0.25]}}");
    assert_false(old.fresnel);
    assert_near(old.k_r[0], 0.75, 0x1p-24);
    assert_near(old.k_d[0], 0.25 * 0.5, 0x1p-24);
    assert_near(old.k_r[2], 0.25, 0x1p-24);
}

/* What lights a material is the same, whichever of the two workflows describes it. */
UNIT_TEST(specular_glossiness_keeps_its_colour) {
    const char *more =
        ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0.1,0.8,0.2,1],"
        "'specularFactor':[0.75,0.5,0.25],'glossinessFactor':0.4}}";
    fathom_material m = read_factors(1, 1, 1, more);
    assert_near(m.k_d[0], 0.25 * 0.1, 0x1p-24);
    assert_near(m.k_d[1], 0.5 * 0.8, 0x1p-24);
    assert_near(m.k_d[2], 0.75 * 0.2, 0x1p-24);
    assert_near(m.shininess, 2 / pow(0.6, 4) - 2, 1e-5);
    assert_near(m.k_s[0] / m.k_s[2], 3, 1e-6);
    assert_false(m.fresnel);
    assert_int_equal(warning_count, 0);
}

/* A texture without its image is taken as one even value: no silhouette, no mirror, no glass all over. */
UNIT_TEST(textures_without_images_become_even_values) {
    const char *all =
        "'pbrMetallicRoughness':{'baseColorTexture':{'index':0},'metallicRoughnessTexture':{'index':0}},"
        "'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0},'occlusionTexture':{'index':0},"
        "'extensions':{'KHR_materials_transmission':{'transmissionFactor':1,'transmissionTexture':{'index':0}"
        "}}";
    fathom_material grey = read_factors(0.5, 0, 1, "");
    fathom_scene *scene = read_triangle(unit_text(
        SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'materials':[{%s}],"
              "'textures':[{'source':0}],'images':[{'uri':'no.png'}]"),
        all));
    const fathom_material m = scene->materials.items[1].classic;
    for (int c = 0; c < 3; ++c) {
        assert_near(m.k_d[c], grey.k_d[0], 0);
        assert_near(m.k_s[c], grey.k_s[0], 0);
        assert_near(m.k_e[c] + m.k_t[c] + m.k_r[c], 0, 0);
    }
    assert_false(material_has_maps(&scene->materials.items[1].value));
    assert_int_equal(warning_count, 1);
    expect_warning("images[0].uri: \"no.png\": there is no such file");
}

/* A PPM of one texel as a data URI, which is enough to be named: what is in it is checked before rendering.
 */
#define TEXEL "'images':[{'uri':'data:image/x-portable-pixmap;base64,UDYKMSAxCjI1NQoAAAA='}]"

UNIT_TEST(textures_become_maps) {
    const char *json = SHOWN(
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}]," TEXEL
        ",'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728}],'textures':[{'source':0},{'source':"
        "0,"
        "'sampler':0}],'materials':[{'alphaMode':'MASK','alphaCutoff':0.25,'pbrMetallicRoughness':{"
        "'baseColorTexture':{'index':0,'texCoord':1},'metallicRoughnessTexture':{'index':0}},"
        "'normalTexture':{'index':1,'scale':0.5},'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0,'"
        "extensions':{"
        "'KHR_texture_transform':{'offset':[0,1],'rotation':1.5707963267948966,'scale':[0.5,0.5]}}},"
        "'extensions':{'KHR_materials_clearcoat':{'clearcoatNormalTexture':{'index':1,'scale':0.25}}}}"
        "]");
    fathom_scene *scene = read_triangle(json);
    const fathom_material *m = &scene->materials.items[1].value;
    const fathom_map *maps = m->maps;
    assert_int_equal(scene->textures.count, 3); /* sRGB, linear, and with the sampler */
    assert_true(m->opacity_cutoff == 0.25f && m->normal_scale == 0.5f && m->opacity == 1);
    assert_true(m->clearcoat_normal_scale == 0.25f);
    assert_int_equal(maps[FATHOM_MAP_CLEARCOAT_NORMAL].texture, maps[FATHOM_MAP_NORMAL].texture);
    assert_true(maps[FATHOM_MAP_COLOR].uv_set == 1 && maps[FATHOM_MAP_OPACITY].channel == 3);
    assert_int_equal(maps[FATHOM_MAP_COLOR].texture, maps[FATHOM_MAP_OPACITY].texture);
    assert_int_equal(scene->textures.items[maps[FATHOM_MAP_COLOR].texture].color_space, FATHOM_COLOR_AUTO);
    assert_true(maps[FATHOM_MAP_METALLIC].channel == 2 && maps[FATHOM_MAP_ROUGHNESS].channel == 1);
    const fathom_texture *numbers = &scene->textures.items[maps[FATHOM_MAP_METALLIC].texture],
                         *normal = &scene->textures.items[maps[FATHOM_MAP_NORMAL].texture];
    assert_int_equal(numbers->color_space, FATHOM_COLOR_LINEAR);
    assert_int_equal(normal->wrap_u, FATHOM_WRAP_CLAMP);
    assert_int_equal(normal->wrap_v, FATHOM_WRAP_MIRROR);
    assert_int_equal(normal->filter, FATHOM_TEXTURE_NEAREST);
    /* The extension's own example: the lower left quadrant of the image. */
    const float *t = maps[FATHOM_MAP_EMISSIVE].transform, expected[6] = {0, 0.5f, 0, -0.5f, 0, 1};
    for (int i = 0; i < 6; ++i) assert_near(t[i], expected[i], 1e-7);
    /* The mesh has neither set of texture coordinates, and both are used: one warning. */
    const fathom_mesh *mesh = &scene->meshes.items[0];
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        const float *uv = mesh_row(mesh->uvs, mesh->uv_stride, i),
                    *uv_1 = mesh_row(mesh->uvs_1, mesh->uv_1_stride, i);
        assert_true(uv[0] == 0 && uv[1] == 0 && uv_1[0] == 0 && uv_1[1] == 0);
    }
    assert_int_equal(warning_count, 1);
}

/* glTF's default factors of layers are 0, so a texture alone does nothing: it is told once, with a count. */
UNIT_TEST(textures_with_factors_of_zero_are_told) {
    static const struct {
        const char *material, *told;
    } cases[] = {
        {"'emissiveTexture':{'index':0}},{'emissiveTexture':{'index':0}",
         ": materials[0].emissiveTexture: emissiveTexture has no effect, because its factor emissiveFactor "
         "is 0, the "
         "default; expected a factor above 0 (2 such)"},
        {"'emissiveFactor':[0,0,0],'emissiveTexture':{'index':0}},{",
         "because its factor emissiveFactor is 0; expected"},
        {"'extensions':{'KHR_materials_anisotropy':{'anisotropyTexture':{'index':0}}}},{",
         "anisotropyTexture has no effect, because its factor anisotropyStrength is 0, the default"},
        {"'extensions':{'KHR_materials_specular':{'specularTexture':{'index':0},'specularColorTexture':{'"
         "index':0}}},"
         "'pbrMetallicRoughness':{'metallicFactor':0,'metallicRoughnessTexture':{'index':0}}},{",
         NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        read_triangle(unit_text(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0},{"
                                      "'attributes':{'POSITION':0},'material':1}]}]," TEXEL
                                      ",'textures':[{'source':0}],'materials':[{%s}]"),
                                cases[i].material));
        if (cases[i].told) expect_warning(cases[i].told);
        if (!cases[i].told) assert_null(strstr(warned, "no effect"));
    }
}

#define BASISU "'extensions':{'KHR_texture_basisu':{'source':0}}"

#define PIXMAP "data:image/x-portable-pixmap;base64,"

/* A texture with an image of its own and one of an extension, which is read from this URI. */
static fathom_scene *read_two_images(const char *extension, const char *uri) {
    const char *json = unit_text(
        SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'images':[{"
              "'name':'own','uri':'" PIXMAP "UDYKMSAxCjI1NQoAAAA='},{'name':'of the extension','uri':'%s'"
              "}],'textures':[{'source':0,'extensions':{'%s':{'source':1}}}],'materials':[{"
              "'pbrMetallicRoughness':{'baseColorTexture':{'index':0}},'emissiveTexture':{'index':0}}]"),
        uri, extension);
    fathom_scene *scene = read_triangle(json);
    assert_int_equal(scene->textures.count, 1);
    return scene;
}

static const char *const image_extensions[] = {"EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds",
                                               "KHR_texture_basisu"};

/* The image of the extension is the one that its author made for programs that know it. */
UNIT_TEST(images_of_extensions_go_before_others) {
    for (size_t i = 0; i < sizeof image_extensions / sizeof *image_extensions; ++i) {
        fathom_scene *scene = read_two_images(image_extensions[i], PIXMAP "UDYKMSAxCjI1NQoBAgM=");
        assert_string_equal(scene->textures.items[0].name, "of the extension");
        assert_memory_equal(scene->textures.items[0].bytes, "P6\n1 1\n255\n\1\2\3", 14);
        assert_null(strstr(warned, "cannot be read"));
    }
}

/* Header, data, the second row of two, and file are missing in turn. */
UNIT_TEST(an_image_that_cannot_be_read_gives_way_to_the_other) {
    static const char *const uris[] = {"data:image/ktx2;base64,AAAA", PIXMAP "UDYKMSAxCjI1NQo=",
                                       PIXMAP "UDYKMSAyCjI1NQoBAgM=", "missing.ktx2"};
    for (size_t i = 0; i < sizeof image_extensions / sizeof *image_extensions; ++i) {
        for (size_t k = 0; k < sizeof uris / sizeof *uris; ++k) {
            fathom_scene *scene = read_two_images(image_extensions[i], uris[k]);
            assert_string_equal(scene->textures.items[0].name, "own");
            assert_int_equal(scene->textures.items[0].color_space, FATHOM_COLOR_AUTO);
            expect_warning("images[1] (of the extension): cannot be read as a texture: ");
            expect_warning("; the other image of its texture is used (1 such)");
        }
    }
}

/* The format fixes the encoding, whatever a PNG or a file of Basis Universal says: sRGB for colours, linear
 * for the rest. Files of floats say theirs by being so. */
UNIT_TEST(colours_are_srgb_whatever_their_image_says) {
    static const struct {
        const char *material, *texture, *bytes;
        fathom_color_space space;
    } cases[] = {
        {"'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}", BASISU, "AAAA", FATHOM_COLOR_SRGB},
        {"'normalTexture':{'index':0}", BASISU, "AAAA", FATHOM_COLOR_LINEAR},
        {"'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}", "'source':0", "AAAA", FATHOM_COLOR_AUTO},
        {"'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}", "'source':0", "iVBORw0K",
         FATHOM_COLOR_SRGB},
        {"'normalTexture':{'index':0}", "'source':0", "iVBORw0K", FATHOM_COLOR_LINEAR}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene = read_triangle(unit_text(
            SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'images':[{"
                  "'uri':'data:;base64,%s'}],'textures':[{%s}],'materials':[{%s}]"),
            cases[i].bytes, cases[i].texture, cases[i].material));
        assert_int_equal(scene->textures.count, 1);
        assert_int_equal(scene->textures.items[0].color_space, cases[i].space);
    }
}

UNIT_TEST(emission_is_scaled_by_its_strength) {
    fathom_material m = read_factors(0, 0, 1,
                                     ",'emissiveFactor':[1,0.5,0],'extensions':{"
                                     "'KHR_materials_emissive_strength':{'emissiveStrength':6}}");
    assert_near(m.k_e[0], 6, 0);
    assert_near(m.k_e[1], 3, 0);
    assert_near(m.k_e[2], 0, 0);
    m = read_factors(0.5, 0, 1, ",'extensions':{'KHR_materials_unlit':{}}");
    assert_near(m.k_e[0], 0.5, 0);
    assert_near(m.k_e[2], 0.125, 0);
    for (int c = 0; c < 3; ++c) assert_near(m.k_d[c] + m.k_s[c] + m.k_r[c] + m.k_t[c] + m.k_a[c], 0, 0);
}

UNIT_TEST(alpha_modes_cover_their_part) {
    fathom_material opaque = read_factors(0.8, 0, 1, "");
    fathom_material half =
        read_material("'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[0.8,0.8,0.8,0.25],"
                      "'metallicFactor':0}");
    assert_near(half.k_t[0], 0.75, 0);
    assert_near(half.ior, 1, 0);
    assert_false(half.fresnel);
    assert_near(half.k_d[0], 0.25 * (double)opaque.k_d[0], 0x1p-24);
    assert_near(half.k_s[0], 0.25 * (double)opaque.k_s[0], 0x1p-24);
    fathom_material hidden = read_material(
        "'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.25],'metallicFactor':0}");
    assert_near(hidden.k_t[0], 1, 0);
    assert_near(hidden.k_d[0] + hidden.k_s[0] + hidden.k_r[0], 0, 0);
    fathom_material shown = read_material("'alphaMode':'MASK','alphaCutoff':0.25,'pbrMetallicRoughness':{"
                                          "'baseColorFactor':[1,1,1,0.25],'metallicFactor':0}");
    assert_near(shown.k_t[0], 0, 0);
    assert_near(shown.k_d[0], 0.96, 0x1p-24);
    fathom_material all = read_material("'alphaMode':'MASK','alphaCutoff':0,'pbrMetallicRoughness':{"
                                        "'baseColorFactor':[1,1,1,0],'metallicFactor':0}");
    assert_near(all.k_t[0], 0, 0);
}

static void assert_shadow_by(fathom_integrator integrator, bool casts, const char *material) {
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    asked.choose_integrator = true, asked.integrator = integrator;
    write_triangle(unit_text(
        SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'images':[{'uri':'"
              "none.png'}],'textures':[{'source':0}],'materials':[{%s}]"),
        material));
    assert_ok(context, fathom_scene_read_with(context, file_path, &asked, &scene));
    own_scene(scene);
    assert_int_equal(scene->meshes.items[0].flags, casts ? 0 : FATHOM_CASTS_NO_SHADOW);
}

static void assert_shadow(bool casts, const char *material) {
    assert_shadow_by(FATHOM_INTEGRATOR_PATH, casts, material);
}

#define SENDS "'KHR_materials_transmission':{'transmissionFactor':1}"
#define GLASS(rough, more)                                                                                   \
    "'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':" rough "},'extensions':{" SENDS more "}"
#define INK(thickness)                                                                                       \
    ",'KHR_materials_volume':{'thicknessFactor':" thickness                                                  \
    ",'attenuationColor':[0.1,0.1,0.2],'attenuationDistance':1}"

#define COVERS(mode, alpha, rough)                                                                           \
    mode ",'pbrMetallicRoughness':{'baseColorFactor':[1,1,1," alpha "],'roughnessFactor':" rough "}"

/* Shadow rays pass what a surface does not cover, so only one that covers nothing needs no shadow. */
UNIT_TEST(surfaces_that_cover_a_part_cast_a_shadow) {
    assert_shadow(true, COVERS("'alphaMode':'BLEND'", "0.25", "1"));
    assert_shadow(true, COVERS("'alphaMode':'BLEND'", "0.25", "0"));
    assert_shadow(true, COVERS("'alphaMode':'MASK','alphaCutoff':0.125", "0.25", "1"));
    assert_shadow(false, COVERS("'alphaMode':'MASK'", "0.25", "1"));
    assert_shadow(false, COVERS("'alphaMode':'BLEND'", "0", "1"));
}

/* Rough glass scatters light of lamps, and so has a shadow; so has ink, if it is thick. */
UNIT_TEST(glass_that_is_rough_or_dark_casts_a_shadow) {
    assert_shadow(false, GLASS("0.01", INK("0.1")));
    assert_shadow(true, GLASS("0.05", INK("0.1")));
    assert_shadow(true, GLASS("0", INK("0.1") ",'KHR_materials_anisotropy':{'anisotropyStrength':0.5}"));
    assert_shadow(true, GLASS("0.4", ""));
    assert_shadow(false, GLASS("0", INK("0.1")));
    assert_shadow(true, GLASS("0", INK("1")));
    assert_shadow(false, GLASS("0", INK("0.1")) ",'normalTexture':{'index':0}");
    assert_shadow(true,
                  "'extensions':{'KHR_materials_transmission':{'transmissionFactor':1,'transmissionTexture':{"
                  "'index':0}}},'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0}");
}

/* Shadow rays of path tracing pass smooth walls with their tint; rough ones scatter light of lamps. */
UNIT_TEST(thin_walls_cast_a_shadow_unless_the_integrator_is_classic) {
    assert_shadow(true, GLASS("0", ""));
    assert_shadow(true, GLASS("0", "") ",'normalTexture':{'index':0}");
    assert_shadow(true, GLASS("0.1", ""));
    assert_shadow_by(FATHOM_INTEGRATOR_CLASSIC, false, GLASS("0", ""));
    assert_shadow_by(FATHOM_INTEGRATOR_CLASSIC, false, GLASS("0.1", ""));
    assert_shadow_by(FATHOM_INTEGRATOR_CLASSIC, true, GLASS("0.4", ""));
}

/* Whatever else the material has: the shape is not there. */
UNIT_TEST(masked_surfaces_are_absent) {
    static const char *const more[] = {
        "", "'emissiveFactor':[1,1,1]", "'extensions':{'KHR_materials_unlit':{}}",
        ("'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},'"
         "KHR_materials_ior':{'ior':1.33}}")};
    for (size_t i = 0; i < sizeof more / sizeof *more; ++i) {
        fathom_scene *scene = read_triangle(unit_text(
            SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'materials':[{"
                  "'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.25]}%s%s}]"),
            *more[i] ? "," : "", more[i]));
        assert_true(absent_object(scene, 0));
    }
}

/* Path tracing takes the format's own numbers. */
UNIT_TEST(factors_are_kept_for_path_tracing) {
    fathom_material m =
        read_both("'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,1,0.75],'metallicFactor':0.25,"
                  "'roughnessFactor':0.125},'alphaMode':'BLEND','emissiveFactor':[1,0.5,0],'extensions':{"
                  "'KHR_materials_ior':{'ior':1.25},'KHR_materials_emissive_strength':{'emissiveStrength':8},"
                  "'KHR_materials_transmission':{'transmissionFactor':0.5},'KHR_materials_specular':{"
                  "'specularFactor':0.5,'specularColorFactor':[1,0.5,2]},'KHR_materials_volume':{"
                  "'thicknessFactor':2,'attenuationDistance':3,'attenuationColor':[0.5,1,0.25]},"
                  "'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'clearcoatRoughnessFactor':0.25}}")
            .value;
    assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
    assert_true(m.base_color[0] == 0.5f && m.base_color[1] == 0.25f && m.opacity == 0.75f);
    assert_true(m.metallic == 0.25f && m.roughness == 0.125f && m.ior == 1.25f && m.transmission == 0.5f);
    assert_true(m.emissive[0] == 1 && m.emissive[1] == 0.5f && m.emissive_strength == 8);
    assert_true(m.specular_factor == 0.5f && m.specular_color[2] == 2);
    assert_true(m.clearcoat == 0.5f && m.clearcoat_roughness == 0.25f);
    assert_true(m.thickness == 2 && m.attenuation_distance == 3 && m.attenuation_color[2] == 0.25f);
    m = read_both("'extensions':{'KHR_materials_unlit':{}}").value;
    assert_true(m.emissive[0] == 1 && m.base_color[0] == 0 && m.specular_factor == 0 && m.metallic == 0);
    m = read_both("'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.25]}").value;
    assert_true(material_opacity(&m) == 0);
}

UNIT_TEST(layers_are_kept_for_path_tracing) {
    const fathom_material m =
        read_both("'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[0.5,0.25,1],"
                  "'sheenRoughnessFactor':0.75},'KHR_materials_anisotropy':{'anisotropyStrength':0.5,"
                  "'anisotropyRotation':1.5},'KHR_materials_iridescence':{'iridescenceFactor':0.25,"
                  "'iridescenceIor':1.75,'iridescenceThicknessMinimum':50,'iridescenceThicknessMaximum':800},"
                  "'KHR_materials_dispersion':{'dispersion':0.25},'KHR_materials_diffuse_transmission':{"
                  "'diffuseTransmissionFactor':0.75,'diffuseTransmissionColorFactor':[1,0.5,0.25]}}")
            .value;
    assert_true(m.sheen_color[1] == 0.25f && m.sheen_roughness == 0.75f);
    assert_true(m.anisotropy == 0.5f && m.anisotropy_rotation == 1.5f);
    assert_true(m.iridescence == 0.25f && m.iridescence_ior == 1.75f);
    assert_true(m.iridescence_thickness_min == 50 && m.iridescence_thickness_max == 800);
    assert_true(m.dispersion == 0.25f && m.diffuse_transmission == 0.75f);
    assert_true(m.diffuse_transmission_color[2] == 0.25f);
    assert_int_equal(warning_count, 0);
    const fathom_material plain = read_both("'extensions':{'KHR_materials_iridescence':{}}").value;
    assert_true(plain.iridescence == 0 && plain.iridescence_ior == 1.3f && plain.sheen_color[0] == 0);
    assert_true(plain.iridescence_thickness_max == 400 && plain.diffuse_transmission_color[0] == 1);
}

UNIT_TEST(extensions_that_are_not_read_are_told) {
    read_material("'extensions':{'EXT_no_such_thing':{},'KHR_materials_unknown':{'dispersion':1}}");
    assert_int_equal(warning_count, 2);
}

/* Names stay, a material is made once, and one that is not named is the format's default: white rough metal.
 */
UNIT_TEST(materials_keep_names_and_have_a_default) {
    fathom_scene *scene =
        read_triangle(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':1},{'"
                            "attributes':{'POSITION':0},"
                            "'material':1},{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}}]}],"
                            "'materials':[{'name':'unused'},{'name':'gold'}]"));
    assert_int_equal(scene->materials.count, 3);
    assert_int_equal(find_material(scene, "gold"), scene->meshes.items[0].material);
    assert_int_equal(scene->meshes.items[0].material, scene->meshes.items[1].material);
    assert_int_equal(scene->meshes.items[2].material, scene->meshes.items[3].material);
    const fathom_material *m = &scene->materials.items[scene->meshes.items[2].material].classic;
    assert_near(m->k_d[0], 0, 0);
    assert_near(m->k_s[0], 1, 0x1p-24);
    assert_near(m->shininess, 1, 0);
}

int main(void) { return unit_main(open_folder, remove_folder); }
