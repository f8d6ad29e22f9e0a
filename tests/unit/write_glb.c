/* Materials in glTF: what it has no words for is replaced by what looks the same, or told. */
#include "wearing.h"

static fathom_material metal(void) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    return m;
}

/* The material after a .glb; *scene, if given, keeps it. */
static fathom_material after(const fathom_material *m, const fathom_texture *texture) {
    forget_warnings();
    fathom_scene *back = through(wearing(m, texture), GLB);
    const fathom_material got = *worn(back);
    return got;
}

/* ---- images ---- */

/* glTF has one image for both: metalness in blue, roughness in green. */
UNIT_TEST(metalness_and_roughness_share_an_image_or_are_left_out) {
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6, .color_space = FATHOM_COLOR_LINEAR};
    enum { SHARED, OTHER_PLACE, OTHER_SET, OTHER_METAL, OTHER_ROUGH, INVERTED_METAL, INVERTED_ROUGH, CASES };
    for (int k = 0; k < CASES; ++k) {
        fathom_material m = metal();
        fathom_map *a = &m.maps[FATHOM_MAP_METALLIC], *b = &m.maps[FATHOM_MAP_ROUGHNESS];
        m.metallic = 0.25f, m.roughness = 0.75f;
        *a = (fathom_map){.texture = 0, .transform = {2, 0, 0.5f, 0, 3, 0}, .channel = 2};
        *b = *a, b->channel = 1;
        if (k == OTHER_PLACE) b->transform[0] = 1;
        if (k == OTHER_SET) b->uv_set = 1;
        if (k == OTHER_METAL) a->channel = 0;
        if (k == OTHER_ROUGH) b->channel = 0;
        a->inverted = k == INVERTED_METAL, b->inverted = k == INVERTED_ROUGH;
        const fathom_material got = after(&m, &texture);
        assert_true(got.metallic == 0.25f && got.roughness == 0.75f);
        const fathom_map *maps[] = {&got.maps[FATHOM_MAP_METALLIC], &got.maps[FATHOM_MAP_ROUGHNESS]};
        for (int i = 0; i < 2; ++i) {
            if (k == SHARED) {
                assert_int_not_equal(maps[i]->texture, FATHOM_NONE);
                assert_int_equal(maps[i]->channel, 2 - i);
                for (int e = 0; e < 6; ++e) assert_true(maps[i]->transform[e] == a->transform[e]);
            } else {
                assert_int_equal(maps[i]->texture, FATHOM_NONE);
            }
        }
        const char *text =
            strstr(warned, "an image that glTF has no place for, by its parameter or its channel, is left "
                           "out (2 such)");
        assert_int_equal(text != NULL, k != SHARED);
    }
}

UNIT_TEST(images_in_other_channels_are_left_out) {
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6, .color_space = FATHOM_COLOR_LINEAR};
    for (int k = 0; k < 3; ++k) {
        fathom_material m = metal();
        m.clearcoat = 0.5f;
        fathom_map *map = &m.maps[FATHOM_MAP_CLEARCOAT];
        *map = (fathom_map){
            .texture = 0, .transform = {1, 0, 0, 0, 1, 0}, .channel = k == 1, .inverted = k == 2};
        const fathom_material got = after(&m, &texture);
        assert_true(got.clearcoat == 0.5f);
        assert_int_equal(got.maps[FATHOM_MAP_CLEARCOAT].texture != FATHOM_NONE, k == 0);
        assert_int_equal(strstr(warned, "is left out (1 such)") != NULL, k != 0);
    }
}

/* An image in either model comes back for some parameter, or is told. Metal has no shininess. */
UNIT_TEST(no_image_is_left_out_silently) {
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = "\x89PNG\r\n", .byte_count = 6, .color_space = FATHOM_COLOR_LINEAR};
    for (int k = 0; k < 2 * FATHOM_MAPS; ++k) {
        fathom_material m = metal();
        if (k == 2 * FATHOM_MAP_SHININESS) continue;
        if (k % 2) m.model = FATHOM_MODEL_CLASSIC;
        m.maps[k / 2] = (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
        const fathom_material got = after(&m, &texture);
        bool kept = strstr(warned, "is left out (1 such)") != NULL;
        for (int i = 0; i < FATHOM_MAPS; ++i) kept |= got.maps[i].texture != FATHOM_NONE;
        if (!kept) fail_msg("image %d of model %d is not told: \"%s\"", k / 2, k % 2, warned);
    }
}

/* ---- emission ---- */

/* A surface that only emits is unlit in glTF, which has no strength for it. Layers above the emission stay.
 */
UNIT_TEST(surfaces_that_only_emit_keep_their_layers) {
    for (int k = 0; k < 5; ++k) {
        fathom_material m = metal();
        m.specular_factor = 0;
        for (int c = 0; c < 3; ++c) m.base_color[c] = 0, m.emissive[c] = 0.25f * (float)(c + 1);
        if (k == 1) m.clearcoat = 0.5f;
        if (k == 2) m.sheen_color[1] = 0.5f;
        if (k == 3) m.diffuse_transmission = 0.5f;
        if (k == 4) m.emissive_strength = 3;
        const fathom_material got = after(&m, NULL);
        assert_true(got.specular_factor == 0 && got.metallic == 0 && got.transmission == 0);
        assert_true(got.clearcoat == m.clearcoat && got.sheen_color[1] == m.sheen_color[1]);
        assert_true(got.diffuse_transmission == m.diffuse_transmission);
        for (int c = 0; c < 3; ++c) {
            assert_true(got.base_color[c] == 0);
            assert_true(got.emissive[c] * got.emissive_strength == m.emissive[c] * m.emissive_strength);
        }
    }
}

/* glTF's factor is at most 1, and the rest is its strength. */
UNIT_TEST(emission_above_one_keeps_every_bit) {
    static const float most[] = {1, 1.0000001f, 2, 3.7f, 1e20f};
    for (size_t i = 0; i < sizeof most / sizeof *most; ++i) {
        fathom_material m = metal();
        m.emissive[0] = most[i], m.emissive[1] = 0.3f * most[i], m.emissive_strength = 0.7f;
        const fathom_material got = after(&m, NULL);
        assert_true(got.emissive[0] <= 1);
        for (int c = 0; c < 3; ++c)
            assert_true(got.emissive[c] * got.emissive_strength == m.emissive[c] * m.emissive_strength);
    }
}

/* Their product is beyond float, and "inf" is no JSON. */
UNIT_TEST(the_largest_emission_reads_back) {
    fathom_material m = metal();
    m.emissive[0] = 1e10f, m.emissive_strength = 1e30f;
    assert_true(after(&m, NULL).emissive_strength == 1e30f);
    expect_warning("an emission above 1e30 becomes 1e30");
}

/* ---- the classic model ---- */

static fathom_material classic(float d, float r, float t) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = d, m.k_r[c] = r, m.k_t[c] = t;
    return m;
}

#define assert_grey(rgb, expected)                                                                           \
    do {                                                                                                     \
        for (int grey_c = 0; grey_c < 3; ++grey_c)                                                           \
            assert_near((rgb)[grey_c], expected, 4e-7 * fabs(expected));                                     \
    } while (0)

#define APPROXIMATE "a material of the model classic becomes its nearest metallicRoughness one"

/* Each number by hand from the equations of write_glb_classic.c; rounded once to a float, and perhaps twice
 * on the way. */
UNIT_TEST(classic_materials_become_their_nearest) {
    fathom_material m = classic(0.4f, 0, 0), got = after(&m, NULL);
    assert_grey(got.base_color, 0.4);
    assert_true(got.specular_factor == 0 && got.metallic == 0 && got.roughness == 1 && got.opacity == 1);
    assert_null(strstr(warned, APPROXIMATE));

    m.lit_from_behind = true, got = after(&m, NULL); /* half of the light passes a base of twice the colour */
    assert_grey(got.base_color, 0.8);
    assert_grey(got.diffuse_transmission_color, 0.8);
    assert_true(got.diffuse_transmission == 0.5f && got.specular_factor == 0);
    assert_null(strstr(warned, APPROXIMATE));
    m = classic(0.6f, 0, 0), m.lit_from_behind = true,
    got = after(&m, NULL); /* there is none brighter than 1 */
    assert_true(got.diffuse_transmission == 0);
    assert_non_null(strstr(warned, APPROXIMATE));

    m = classic(0, 0.8f, 0), got = after(&m, NULL); /* a mirror */
    assert_true(got.metallic == 1 && got.roughness == 0);
    assert_grey(got.base_color, 0.8);
    assert_non_null(strstr(warned, APPROXIMATE));

    /* N(6) = 8 * 10 / (8 (2^-3 + 6)) = 80 / 49; r^4 = 2 / 8. A lobe alone is a metal. */
    m = classic(0, 0, 0), m.specular = FATHOM_SPECULAR_BLINN, m.shininess = 6;
    for (int c = 0; c < 3; ++c) m.k_s[c] = 0.4f;
    got = after(&m, NULL);
    assert_true(got.metallic == 1);
    assert_grey(got.base_color, 0.4 * 49 / 80);
    assert_near(got.roughness, sqrt(0.5), 1e-7);
    m.specular = FATHOM_SPECULAR_PHONG,
    m.shininess = 1.5f; /* as wide as Blinn's of four times the exponent */
    got = after(&m, NULL);
    assert_grey(got.base_color, 0.4 * 49 / 80);

    /* With a Lambert part the lobe is a dielectric's: F0 = 0.245 is 6.125 times that of ior 1.5, and the base
     * is what shows through. */
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.302f;
    got = after(&m, NULL);
    assert_true(got.metallic == 0 && got.ior == 1.5f && got.specular_factor == 1);
    assert_grey(got.specular_color, 0.245 / 0.04);
    assert_grey(got.base_color, 0.302 / 0.755);
    m.ior = 1, got = after(&m, NULL); /* no dielectric has a highlight without an ior */
    assert_true(got.ior == 1.5f);
    assert_grey(got.specular_color, 0.245 / 0.04);

    /* A mirror of all light leaves nothing to divide by. */
    m = classic(0.25f, 1, 0), got = after(&m, NULL);
    assert_grey(got.base_color, 0.25);
    assert_grey(got.specular_color, 25.0);
}

UNIT_TEST(classic_glass_becomes_transmission) {
    fathom_material m = classic(0, 1, 1), got;
    m.fresnel = true, got = after(&m, NULL);
    assert_true(got.transmission == 1 && got.ior == 1.5f && got.specular_factor == 1 && got.roughness == 0);
    assert_true(got.thickness == 1); /* light is bent, as in the classic model */
    assert_grey(got.specular_color, 1.0);
    assert_grey(got.base_color, 1.0);
    m.ior = 0.8f, got = after(&m, NULL); /* seen from the other side */
    assert_near(got.ior, 1.25, 1e-6);
    assert_grey(got.specular_color, 1.0);
    m = classic(0.2f, 0, 0.6f), got = after(&m, NULL);
    assert_true(got.ior == 1.5f && got.specular_factor == 0);
    assert_near(got.transmission, 0.75, 1e-7);
    assert_grey(got.base_color, 0.8);
}

/* Light that goes straight on is coverage. */
UNIT_TEST(classic_transmission_without_refraction_becomes_coverage) {
    fathom_material m = classic(0.25f, 0, 0.5f), got;
    m.ior = 1, got = after(&m, NULL);
    assert_true(got.opacity == 0.5f && got.transmission == 0 && got.thickness == 0);
    assert_grey(got.base_color, 0.5);
    m = classic(0.25f, 0, 1), m.ior = 1, got = after(&m, NULL);
    assert_true(got.opacity == 0);
    assert_grey(got.base_color, 0.25);
}

/* ---- extensions ---- */

/* The JSON of a .glb of this scene, which is destroyed; until the next call. */
static const char *json_of(fathom_scene *scene) {
    static char bytes[8192];
    assert_ok(context, fathom_scene_write(scene, in_folder("a.glb")));
    FILE *file = fopen(in_folder("a.glb"), "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes - 1, file);
    fclose(file);
    assert_true(size > 20 && size < sizeof bytes - 1);
    uint32_t length;
    memcpy(&length, bytes + 12, sizeof length);
    bytes[20 + length] = '\0';
    return bytes + 20;
}

/* Each is listed once. The first is that of the scene's default material, which is Lambert's. An image that
 * only an extension names makes the extension required. */
UNIT_TEST(extensions_are_listed_if_they_are_used_or_required) {
    fathom_material m = metal();
    m.clearcoat = 1;
    const char *json = json_of(wearing(&m, NULL));
    assert_non_null(
        strstr(json, "\"extensionsUsed\":[\"KHR_materials_specular\",\"KHR_materials_clearcoat\"]"));
    assert_null(strstr(json, "extensionsRequired"));
    static const struct {
        const char *bytes;
        size_t size;
        const char *name;
    } images[] = {{"RIFF\4\0\0\0WEBPVP8 ", 16, "EXT_texture_webp"},
                  {"\0\0\0\x1c"
                   "ftypavif\0\0\0\0",
                   16, "EXT_texture_avif"},
                  {"\xabKTX 20\xbb\r\n\x1a\n\0\0\0\0", 16, "KHR_texture_basisu"}};
    for (size_t i = 0; i < 3; ++i) {
        char text[128];
        const fathom_texture texture = {
            .size = sizeof texture, .bytes = images[i].bytes, .byte_count = images[i].size};
        m = metal(), m.maps[FATHOM_MAP_COLOR] = (fathom_map){.texture = 0, .transform = {1, 0, 0, 0, 1, 0}};
        json = json_of(wearing(&m, &texture));
        snprintf(text, sizeof text, "\"extensionsUsed\":[\"KHR_materials_specular\",\"%s\"]", images[i].name);
        assert_non_null(strstr(json, text));
        snprintf(text, sizeof text, "\"extensionsRequired\":[\"%s\"]", images[i].name);
        assert_non_null(strstr(json, text));
        snprintf(text, sizeof text, "\"extensions\":{\"%s\":{\"source\":0}}", images[i].name);
        assert_non_null(strstr(json, text));
        const fathom_material got = after(&m, &texture);
        assert_int_not_equal(got.maps[FATHOM_MAP_COLOR].texture, FATHOM_NONE);
    }
}

/* ---- nodes ---- */

/* The next matrix of the JSON at *json, which moves behind it. */
static affine_f64 next_matrix(const char **json) {
    affine_f64 out;
    *json = strstr(*json, "\"matrix\":[");
    assert_non_null(*json);
    *json += strlen("\"matrix\":[");
    for (int i = 0; i < 16; ++i, ++*json) {
        const double number = strtod(*json, (char **)(uintptr_t)json);
        if (i % 4 < 3) out.m[i % 4][i / 4] = number;
    }
    return out;
}

/* A rotation of two columns rounds them by less than 4 units, and there are 24; both factors have such
 * errors, so 2^-44 is enough. */
UNIT_TEST(nodes_do_not_shear) {
    static const double maps[][12] = {{1, 0.5, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3},
                                      {-2, 0, 1, 0, 0.25, 1, 0, 0, 0, 0.25, 0.5, 0},
                                      {1, 0.5, 0.5, 0, 0.5, 1, 0.5, 0, 0.5, 0.5, 1, 0},
                                      {3000, 1, 0, 0, 0, 1, 0.5, 0, 0, 0, 0.001, 0}};
    for (size_t k = 0; k < sizeof maps / sizeof *maps; ++k) {
        const fathom_material m = metal();
        fathom_scene *scene = wearing(&m, NULL);
        const fathom_mesh mesh = triangle(0);
        fathom_instance instance = default_instance();
        memcpy(instance.transform, maps[k], sizeof maps[k]);
        assert_ok(context, fathom_scene_add_group(scene, NULL, &instance.group));
        assert_ok(context, fathom_scene_add_mesh(scene, instance.group, &mesh, NULL));
        assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
        const char *json = json_of(scene);
        const affine_f64 outer = next_matrix(&json), inner = next_matrix(&json),
                         both = affine_compose(&outer, &inner);
        assert_null(strstr(json, "matrix"));
        for (int i = 0; i < 3; ++i) {
            const vec3_f64 x = {outer.m[0][i], outer.m[1][i], outer.m[2][i]};
            const vec3_f64 y = {outer.m[0][(i + 1) % 3], outer.m[1][(i + 1) % 3], outer.m[2][(i + 1) % 3]};
            assert_near(dot_f64(x, y) / (length_f64(x) * length_f64(y)), 0, 0x1p-44);
            for (int j = 0; j < 3; ++j) {
                const double unit = i == j;
                assert_near(dot_f64(load_f64(inner.m[i]), load_f64(inner.m[j])), unit, 0x1p-44);
                assert_near(both.m[i][j], maps[k][4 * i + j], 0x1p-44 * fabs(maps[k][0]));
            }
            assert_near(both.m[i][3], maps[k][4 * i + 3], 0);
        }
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
