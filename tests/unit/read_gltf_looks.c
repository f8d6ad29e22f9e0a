/* glTF materials whose images are lost or shared, their samplers, and features that are left out with a note.
 */
#include "gltf_build.h"

/* PPMs of one texel. */
#define TEXELS                                                                                               \
    "'images':[{'uri':'data:image/x-portable-pixmap;base64,UDYKMSAxCjI1NQoAAAA='},{'uri':'no.png'}]"
#define MATERIAL(material, textures)                                                                         \
    WITH_DATA("'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':5,'TEXCOORD_1':5},"         \
              "'material':0}]}],'nodes':[{'mesh':0}]," TEXELS "," textures ",'materials':[{" material "}]")

static fathom_material material_of(const char *json) {
    fathom_scene *scene = read_triangle(json);
    const fathom_material out = scene->materials.items[1].value;
    return out;
}

#define LOST(extension) material_of(MATERIAL("'extensions':{" extension "}", "'textures':[{'source':1}]"))
#define IMAGE(name) "'" name "':{'index':0}"

/* Factors next to an image are mostly 1, and the image says where. Without it, a layer would be everywhere.
 */
UNIT_TEST(lost_images_leave_no_layer) {
    fathom_material m = LOST("'KHR_materials_clearcoat':{'clearcoatFactor':1," IMAGE("clearcoatTexture") "}");
    assert_true(m.clearcoat == 0);
    m = LOST("'KHR_materials_sheen':{'sheenColorFactor':[1,1,1]," IMAGE("sheenColorTexture") "}");
    assert_true(m.sheen_color[0] == 0 && m.sheen_color[1] == 0 && m.sheen_color[2] == 0);
    m = LOST("'KHR_materials_anisotropy':{'anisotropyStrength':1," IMAGE("anisotropyTexture") "}");
    assert_true(m.anisotropy == 0);
    m = LOST("'KHR_materials_iridescence':{'iridescenceFactor':1," IMAGE("iridescenceTexture") "}");
    assert_true(m.iridescence == 0);
    m = LOST("'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor':1," IMAGE(
        "diffuseTransmissionTexture") "}");
    assert_true(m.diffuse_transmission == 0);
    m = LOST("'KHR_materials_transmission':{'transmissionFactor':1," IMAGE("transmissionTexture") "}");
    assert_true(m.transmission == 0);
    expect_warning("no.png");
    m = LOST("'KHR_materials_clearcoat':{'clearcoatFactor':1,'clearcoatTexture':{'index':-1}}");
    assert_true(m.clearcoat == 1); /* it has no image to lose */
}

/* The specular colour tints the 4 % that the ior reflects; with ior 0 it is all that is reflected. */
UNIT_TEST(lost_specular_colours_leave_plain_plastic) {
    fathom_material m = LOST("'KHR_materials_specular':{'specularColorFactor':[1,0.5,1]," IMAGE(
        "specularColorTexture") "," IMAGE("specularTexture") "}");
    assert_true(m.specular_color[0] == 1 && m.specular_color[1] == 0.5f && m.specular_factor == 1);
    m = LOST("'KHR_materials_ior':{'ior':0},'KHR_materials_specular':{" IMAGE("specularColorTexture") "}");
    assert_true(m.specular_color[0] == 0.04f);
    m = LOST("'KHR_materials_pbrSpecularGlossiness':{" IMAGE("specularGlossinessTexture") "}");
    assert_true(m.specular_color[2] == 0.04f && m.roughness == 1);
}

/* Images are opened by the render: if that fails, its message still has the place in the file. */
UNIT_TEST(images_know_their_place_in_the_file) {
    fathom_scene *scene = read_triangle(
        SHOWN("'images':[{'uri':'data:image/png;base64,AAAA'},{'name':'w','uri':'data:;base64,AAAB'}],"
              "'textures':[{'source':0},{'source':1}],'materials':[{'normalTexture':{'index':0},"
              "'emissiveTexture':{'index':1}}],'meshes':[{'primitives':[{'attributes':{'POSITION':0,"
              "'TEXCOORD_0':5},'material':0}]}]"));
    const fathom_map *maps = scene->materials.items[scene->meshes.items[0].material].value.maps;
    const int kinds[] = {FATHOM_MAP_NORMAL, FATHOM_MAP_EMISSIVE};
    for (int i = 0; i < 2; ++i) {
        const fathom_place *place = scene_origin_find(scene, SCENE_PART_TEXTURE, maps[kinds[i]].texture);
        assert_non_null(place);
        assert_string_equal(place->file, file_path);
        assert_string_equal(place->field, i ? "images[1]" : "images[0]");
    }
}

#define COLOR(more) "'pbrMetallicRoughness':{'baseColorTexture':{'index':0" more "}}"

/* Each direction wraps by itself; filters without mip levels take none; the same image with another sampler
 * is another texture. */
UNIT_TEST(samplers_are_followed) {
    static const struct {
        const char *sampler;
        fathom_wrap u, v;
        fathom_texture_filter filter;
        unsigned warnings;
    } cases[] = {
        {"", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR, 0},
        {"'wrapS':33071", FATHOM_WRAP_CLAMP, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR, 0},
        {"'wrapT':33648", FATHOM_WRAP_REPEAT, FATHOM_WRAP_MIRROR, FATHOM_TEXTURE_TRILINEAR, 0},
        {"'wrapS':10497,'wrapT':33071", FATHOM_WRAP_REPEAT, FATHOM_WRAP_CLAMP, FATHOM_TEXTURE_TRILINEAR, 0},
        {"'wrapS':33069", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR, 1},
        {"'magFilter':9728,'minFilter':9987", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_NEAREST,
         0},
        {"'magFilter':9729,'minFilter':9728", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_LINEAR,
         0},
        {"'minFilter':9729", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_LINEAR, 0},
        {"'minFilter':9985", FATHOM_WRAP_REPEAT, FATHOM_WRAP_REPEAT, FATHOM_TEXTURE_TRILINEAR, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene = read_triangle(
            unit_text(MATERIAL(COLOR("") ",'emissiveFactor':[1,1,1],'emissiveTexture':{'index':1}",
                               "'samplers':[{%s}],'textures':[{'source':0,'sampler':0},{'source':0}]"),
                      cases[i].sampler));
        const fathom_material *m = &scene->materials.items[1].value;
        const fathom_texture *t = &scene->textures.items[m->maps[FATHOM_MAP_COLOR].texture],
                             *other = &scene->textures.items[m->maps[FATHOM_MAP_EMISSIVE].texture];
        if (t->wrap_u != cases[i].u || t->wrap_v != cases[i].v || t->filter != cases[i].filter ||
            warning_count != cases[i].warnings)
            fail_msg("{%s}: %d, %d, %d, %u warnings", cases[i].sampler, (int)t->wrap_u, (int)t->wrap_v,
                     (int)t->filter, warning_count);
        assert_int_equal(other->wrap_u, FATHOM_WRAP_REPEAT);
        assert_int_equal(other->filter, FATHOM_TEXTURE_TRILINEAR);
    }
}

/* The extension's own set of texture coordinates overrides the texture's; what is not given changes nothing.
 */
UNIT_TEST(transforms_choose_their_set) {
    static const char textures[] = "'textures':[{'source':0}]";
    char json[4096];
    static const struct {
        const char *more;
        uint32_t set;
        float transform[6];
    } cases[] = {
        {",'texCoord':1", 1, {1, 0, 0, 0, 1, 0}},
        {",'texCoord':1,'extensions':{'KHR_texture_transform':{'texCoord':0}}", 0, {1, 0, 0, 0, 1, 0}},
        {",'extensions':{'KHR_texture_transform':{'texCoord':1,'offset':[0.25,0.5]}}",
         1,
         {1, 0, 0.25f, 0, 1, 0.5f}},
        {",'texCoord':1,'extensions':{'KHR_texture_transform':{'scale':[2,-3]}}", 1, {2, 0, 0, 0, -3, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        snprintf(json, sizeof json, MATERIAL(COLOR("%s"), "%s"), textures, cases[i].more);
        const fathom_map map = material_of(json).maps[FATHOM_MAP_COLOR];
        assert_int_equal(map.uv_set, cases[i].set);
        for (int k = 0; k < 6; ++k) assert_true(map.transform[k] == cases[i].transform[k]);
    }
    snprintf(json, sizeof json, MATERIAL(COLOR(",'texCoord':2"), "%s"), textures);
    assert_int_equal(material_of(json).maps[FATHOM_MAP_COLOR].texture, FATHOM_NONE);
    expect_warning("beyond the second");
}

/* An unlit surface sends its colour, through its image, where its alpha lets it. */
UNIT_TEST(unlit_images_are_masked) {
    const fathom_material m = material_of(
        MATERIAL("'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,1,0.75],"
                 "'baseColorTexture':{'index':0,'texCoord':1}},'emissiveFactor':[1,1,1],'extensions':{"
                 "'KHR_materials_unlit':{}}",
                 "'textures':[{'source':0}]"));
    assert_true(m.emissive[0] == 0.5f && m.emissive[1] == 0.25f && m.emissive[2] == 1);
    assert_true(m.opacity == 0.75f && m.opacity_cutoff == 0.5f && m.base_color[2] == 0);
    assert_int_equal(m.maps[FATHOM_MAP_COLOR].texture, FATHOM_NONE);
    assert_true(m.maps[FATHOM_MAP_EMISSIVE].uv_set == 1 && m.maps[FATHOM_MAP_OPACITY].uv_set == 1);
    assert_int_equal(m.maps[FATHOM_MAP_OPACITY].channel, 3);
}

/* The colours of the file multiply the material that an object of a scene gives it, as those of PLY do. */
UNIT_TEST(colours_stay_with_another_material) {
    build b = {.size = 0};
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float red\nproperty float green\nproperty float blue\nelement face 1\nproperty list uchar "
        "int vertex_indices\nend_header\n0 0 0 1 0 0.5\n1 0 0 0.25 1 0\n0 1 0 0 0 1\n3 0 1 2\n";
    static const char json[] =
        "{\"materials\":{\"grey\":{\"kd\":[0.5,0.5,0.5]}},\"objects\":[{\"type\":\"mesh\",\"file\":"
        "\"test.glb\",\"material\":\"grey\"},{\"type\":\"mesh\",\"file\":\"test.ply\",\"material\":"
        "\"grey\"}]}";
    const int points = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              colors = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0.5f, 0.5f, 0.25f, 1, 0, 0.5f, 0, 0, 1, 0.5f);
    build_write(&b,
                "'materials':[{}],'meshes':[{'primitives':[{'material':0,'attributes':{'POSITION':%d,"
                "'COLOR_0':%d}},{'mode':1,'attributes':{'POSITION':%d,'COLOR_0':%d}}]}],'nodes':[{'mesh':0}]",
                points, colors, points, colors);
    write_bytes("test.ply", ply, strlen(ply));
    write_bytes("test.json", json, strlen(json));
    fathom_scene *scene = scene_of_file(context, file_path);
    assert_int_equal(scene->meshes.count, 3);
    const fathom_mesh *from_ply = &scene->meshes.items[2];
    for (size_t m = 0; m < 2; ++m) {
        const fathom_mesh *mesh = &scene->meshes.items[m];
        assert_int_equal(mesh->material, from_ply->material);
        assert_int_equal(mesh->color_channels, 3);
        for (uint32_t i = 0; i < 3 && m == 0; ++i)
            assert_memory_equal(mesh_row(mesh->colors, mesh->color_stride, i),
                                mesh_row(from_ply->colors, from_ply->color_stride, i), 3 * sizeof(float));
        assert_non_null(mesh->colors);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
