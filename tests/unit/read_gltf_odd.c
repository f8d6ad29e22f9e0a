/* glTF files that are against the format, and yet clear: they are read, and each oddity is told once. */
#include "gltf_build.h"

typedef struct odd_file {
    const char *json, *told;
} odd_file;

#define TRIANGLE_NODES(nodes) WITH_DATA(TRIANGLE_MESH ",'nodes':[" nodes "]")
#define MESH(primitive) SHOWN("'meshes':[{'primitives':[{" primitive "}]}]")
#define MATERIAL(material)                                                                                   \
    SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'materials':[{" material   \
          "}]")
#define LIGHT(light)                                                                                         \
    WITH_DATA(TRIANGLE_MESH ",'extensions':{'KHR_lights_punctual':{'lights':[{" light                        \
                            "}]}},'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}]")
#define LIGHT_IN(node, light)                                                                                \
    WITH_DATA(TRIANGLE_MESH ",'extensions':{'KHR_lights_punctual':{'lights':[{" light                        \
                            "}]}},'nodes':[{'mesh':0},{" node                                                \
                            "'extensions':{'KHR_lights_punctual':{'light':0}}}]")
#define BUFFER(members)                                                                                      \
    "{" ASSET ",'buffers':[{" members "}]," VIEWS "," ACCESSORS "," TRIANGLE_MESH ",'nodes':[{'mesh':0}]}"
#define IMAGE(uri)                                                                                           \
    SHOWN("'images':[{'uri':'" uri "'}],'textures':[{'source':0}],'meshes':[{'primitives':[{'attributes':"   \
          "{'POSITION':0},'material':0}]}],'materials':[{'emissiveTexture':{'index':0}}]")

/* The one warning that reading gives. */
static fathom_scene *read_odd(const odd_file *file) {
    fathom_scene *scene = read_triangle(file->json);
    if (warning_count != 1 || !strstr(warned, file->told))
        fail_msg("%u warnings, the last: \"%s\"; expected \"%s\"", warning_count, warned, file->told);
    return scene;
}

static void assert_all_read(const odd_file *files, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        fathom_scene *scene = read_odd(&files[i]);
        assert_int_equal(scene->meshes.count, 1);
        assert_int_equal(scene->meshes.items[0].triangle_count, 1);
        assert_int_equal(scene->instances.count, 1);
    }
}

/* A view of 3 positions with these members, and a node that shows them. */
#define STRIDED(members)                                                                                     \
    "{" ASSET ",'buffers':[{'byteLength':120}],'bufferViews':[{'buffer':0,'byteLength':36," members          \
    "}],'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}],'meshes':[{'primitives'" \
    ":"                                                                                                      \
    "[{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0}]}"

UNIT_TEST(clear_slips_are_read_and_told) {
    const odd_file files[] = {
        {TRIANGLE_NODES("{'mesh':0,'name':null,'children':null,'skin':null}"),
         "null, which is against the format, is taken as nothing (3 such)"},
        {TRIANGLE_NODES("{'mesh':0,'skin':-1,'camera':-1}"), "an index of -1"},
        {TRIANGLE_NODES("{'mesh':0,'mesh':0}"), "an object has a key twice"},
        {TRIANGLE_NODES("{'mesh':0,'rotation':[0,0,0,0]}"), "nodes[0].rotation: a rotation of zeros"},
        {TRIANGLE_NODES("{'mesh':0,'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],'scale':[2,2,2]}"),
         "nodes[0].scale: a node has a matrix and parts of a transform; the matrix counts"},
        {TRIANGLE_NODES("{'mesh':0,'matrix':[1,0,0,1e-9,0,1,0,0,0,0,1,0,0,0,0,1.0000001]}"),
         "nodes[0].matrix: a matrix whose last row is off by a little"},
        {TRIANGLE_NODES("{'mesh':0}],'scenes':[{'nodes':[0,0]}"), "a scene names a node twice"},
        {TRIANGLE_NODES("{'mesh':0},{'children':[0]}],'scenes':[{'nodes':[0,1]}"),
         "scenes[0].nodes: a scene names a node that has a parent"},
        {TRIANGLE_NODES(
             "{'mesh':0},{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'_ID':3}}}}"),
         "nodes[1].extensions.EXT_mesh_gpu_instancing: instances without TRANSLATION, ROTATION and SCALE"},
        {MESH("'attributes':{'POSITION':0},'targets':[{'TEXCOORD_0':5,'_X':5},{'COLOR_0':4}]}],'weights':[1,"
              "0],'x':[{"),
         "meshes[0].primitives[0].targets[0].TEXCOORD_0: morph targets of TEXCOORD_0 are ignored (1 "
         "such)"},
        {BUFFER("'byteLength':121"), "buffers[0].byteLength: a buffer has fewer bytes than it says"},
        {BUFFER("'name':'b'"), "buffers[0].byteLength: a buffer's length is missing"},
        {STRIDED("'byteStride':0"), "bufferViews[0].byteStride: a stride of 0"},
        {MATERIAL("'emissiveTexture':{'index':-1}"),
         "materials[0].emissiveTexture.index: an index of -1, which is against the format, is taken as none"},
        {IMAGE("http://example.org/a.png"),
         "images[0].uri: \"http://example.org/a.png\": there is no such file that may be read"},
        {IMAGE("a.png','name':'wood"), "images[0].uri: \"a.png\" (named \"wood\"): there is no such file"},
        {IMAGE("C:\\\\a\\\\b.png"),
         "images[0].uri: \"C:\\a\\b.png\": there is no such file that may be read"},
        {IMAGE("data:image/png;base64,AA!A"),
         "images[0].uri: is not base64 from its character 24 on; the image is left out"},
        {IMAGE("data:image/png,AAAA"),
         "images[0].uri: is a data URI without \";base64,\"; expected base64; the image is left out"},
        {LIGHT("'type':'area'"), "a light of the type \"area\" is left out"},
        {LIGHT("'type':'point','intensity':-1"), "intensity is out of range: expected a number >= 0"},
        {LIGHT("'type':'spot','spot':{'innerConeAngle':0.5,'outerConeAngle':0.5}"),
         "innerConeAngle: expected less than outerConeAngle"},
        {LIGHT("'type':'spot','spot':{'outerConeAngle':2}"), "outerConeAngle is out of range"},
        {LIGHT("'type':'spot','spot':{'outerConeAngle':0}"),
         "outerConeAngle: expected more than 0; the light is left out"},
        {LIGHT_IN("'scale':[0,0,0],", "'type':'spot'"),
         "nodes[1]: a light is scaled to nothing, and left out"},
        {LIGHT_IN("'scale':[1,1,0],", "'type':'directional'"), "a light is scaled to nothing, and left out"},
        {MATERIAL("'pbrMetallicRoughness':{'metallicFactor':2}"),
         "metallicFactor is out of range: expected a number <= 1; the nearest is taken"},
        {MATERIAL("'alphaMode':'MASK','alphaCutoff':5000"),
         "alphaCutoff is out of range: expected a number <= 1000"},
        {MATERIAL("'alphaMode':'blend'"), "\"blend\" is none of OPAQUE, MASK and BLEND"},
        {MATERIAL("'extensions':{'KHR_materials_ior':{'ior':0.5}}"), "ior: expected 0 or a number >= 1"},
    };
    assert_all_read(files, sizeof files / sizeof *files);
}

/* The first eight by name, however many textures take them; the others are counted. */
UNIT_TEST(missing_images_are_named) {
    char meshes[1024] = "", materials[1024] = "", textures[1024] = "", images[1024] = "", json[8192];
    for (int i = 0; i < 12; ++i) {
        const char *comma = i ? "," : "";
        char part[128];
        snprintf(part, sizeof part, "%s{'attributes':{'POSITION':0},'material':%d}", comma, i);
        strcat(meshes, part);
        snprintf(part, sizeof part, "%s{'normalTexture':{'index':%d}}", comma, i);
        strcat(materials, part);
        snprintf(part, sizeof part, "%s{'source':%d}", comma, i < 10 ? i : 0);
        strcat(textures, part);
        snprintf(part, sizeof part, "%s{'uri':'%d.png'}", comma, i);
        strcat(images, part);
    }
    snprintf(json, sizeof json,
             SHOWN("'meshes':[{'primitives':[%s]}],'materials':[%s],'textures':[%s],'images':[%s]"), meshes,
             materials, textures, images);
    read_triangle(json);
    assert_int_equal(warning_count, 9);
    for (int i = 0; i < 8; ++i) {
        expect_warning(
            unit_text(": images[%d].uri: \"%d.png\": there is no such file that may be read; it is left "
                      "out (%d such)\n",
                      i, i, i ? 1 : 3));
    }
    expect_warning(": images beyond the first 8: there is no such file that may be read; it is left "
                   "out (2 such)");
}

/* Where its parent places it, once, in whatever order the scene names the two. */
UNIT_TEST(a_root_with_a_parent_stays_in_its_place) {
    static const char *const lists[] = {"0,1", "1,0", "0"};
    for (size_t i = 0; i < 3; ++i) {
        const char *json = unit_text(
            TRIANGLE_NODES("{'mesh':0},{'children':[0],'translation':[5,0,0]}],'scenes':[{'nodes':[%s]}"),
            lists[i]);
        fathom_scene *scene = read_odd(&(odd_file){json, "a scene names a node that has a parent"});
        assert_int_equal(scene->instances.count, 1);
        assert_near(scene->instances.items[0].transform[3], 5, 0);
    }
}

/* A factor above its range is the largest one there; emission has none, and is as it is given. */
UNIT_TEST(factors_out_of_range_become_the_nearest) {
    fathom_scene *scene = read_triangle(MATERIAL(
        "'pbrMetallicRoughness':{'roughnessFactor':-1,'metallicFactor':7},'emissiveFactor':[5,0,2]"));
    const fathom_material *m = &scene->materials.items[scene->meshes.items[0].material].value;
    assert_near((double)m->roughness, 0, 0);
    assert_near((double)m->metallic, 1, 0);
    assert_near((double)m->emissive[0], 5, 0);
    assert_int_equal(warning_count, 2);
}

/* What shades may be missing where it is no number; what places may not. */
UNIT_TEST(odd_normals_become_zeros) {
    triangle_data data = triangle;
    data.normals[1][2] = NAN;
    write_glb(MESH("'attributes':{'POSITION':0,'NORMAL':4},'indices':1"), &data, sizeof data);
    fathom_scene *scene = read_file();
    const fathom_mesh *m = &scene->meshes.items[0];
    const float *second = mesh_row(m->normals, m->normal_stride, 1);
    assert_near((double)second[2], 0, 0);
    assert_near((double)m->normals[2], 1, 0);
    assert_int_equal(warning_count, 1);
    expect_warning("a NaN or an infinity in NORMAL");
}

/* Assimp writes three numbers; the third has no meaning for an image. */
UNIT_TEST(texture_coordinates_lose_a_third_number) {
    triangle_data data = triangle;
    for (size_t i = 0; i < 3; ++i)
        data.normals[i][0] = (float)i, data.normals[i][1] = 2 * (float)i, data.normals[i][2] = 9;
    write_glb(MESH("'attributes':{'POSITION':0,'TEXCOORD_0':4},'indices':1"), &data, sizeof data);
    const fathom_scene *scene = read_file();
    const fathom_mesh *m = &scene->meshes.items[0];
    for (size_t i = 0; i < 3; ++i) {
        const float *uv = mesh_row(m->uvs, m->uv_stride, i);
        assert_true(uv[0] == (float)i && uv[1] == 2 * (float)i);
    }
    assert_int_equal(warning_count, 1);
    expect_warning(
        "attributes.TEXCOORD_0: texture coordinates of three numbers, which are against the format");
}

/* Colours in bytes are parts of 255, whether the file says so or not. */
UNIT_TEST(colours_in_bytes_are_normalized) {
    triangle_data data = triangle;
    const uint8_t colors[12] = {255, 0, 51, 255, 255, 0, 51, 255, 255, 0, 51, 255};
    memcpy(data.uvs, colors, sizeof colors);
    write_glb(
        "{" ASSET ",'buffers':[{'byteLength':120}]," VIEWS ",'accessors':[{'bufferView':0,"
        "'componentType':5126,'type':'VEC3','count':3},{'bufferView':5,'componentType':5121,"
        "'type':'VEC4','count':3}],'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1}}]}]}",
        &data, sizeof data);
    fathom_scene *scene = read_file();
    assert_near((double)scene->meshes.items[0].colors[2], 0.2, 1e-7);
    assert_int_equal(warning_count, 1);
    expect_warning("have to be normalized");
}

/* More entries than vertices: the first ones count. Fewer: none do. No elements at all: no triangle. */
UNIT_TEST(arrays_of_another_length_are_told) {
#define WITH(accessor, attributes)                                                                           \
    "{" ASSET ",'buffers':[{'byteLength':120}]," VIEWS ",'accessors':[{'bufferView':0,'componentType':5126," \
    "'type':'VEC3','count':3}," accessor "],'meshes':[{'primitives':[{" attributes "},{'attributes':{"       \
    "'POSITION':0}}]}]}"
    fathom_scene *scene = read_triangle(WITH("{'bufferView':4,'componentType':5126,'type':'VEC3','count':2}",
                                             "'attributes':{'POSITION':0,'NORMAL':1}"));
    assert_int_equal(warning_count, 1);
    expect_warning("NORMAL has another number of entries than POSITION; it is left out");
    assert_null(scene->meshes.items[0].normals);
    scene = read_triangle(
        WITH("{'componentType':5126,'type':'VEC3','count':4}", "'attributes':{'POSITION':0,'NORMAL':1}"));
    assert_int_equal(warning_count, 1);
    expect_warning("those beyond are left out");
    assert_int_equal(scene->meshes.items[0].normal_count, 3);
    scene = read_triangle(
        WITH("{'componentType':5123,'type':'SCALAR','count':0}", "'attributes':{'POSITION':0},'indices':1"));
    assert_int_equal(warning_count, 2);
    assert_int_equal(scene->meshes.count, 1);
}

/* The matrix counts for what moves the node, and weights are followed there as in any node. */
UNIT_TEST(animations_of_nodes_with_a_matrix_are_left_out) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), slide = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 8, 0, 0),
              weights = PUT_FLOATS(&b, "SCALAR", 2, 0, 1);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'targets':[{'POSITION':%d}]}]}],"
                "'nodes':[{'mesh':0},{'name':'fixed','mesh':0,'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,3,0,1]}],"
                "'animations':[{'samplers':[{'input':%d,'output':%d},{'input':%d,'output':%d}],'channels':["
                "{'sampler':0,'target':{'node':0,'path':'translation'}},"
                "{'sampler':0,'target':{'node':1,'path':'translation'}},"
                "{'sampler':0,'target':{'node':1,'path':'scale'}},"
                "{'sampler':1,'target':{'node':1,'path':'weights'}}]}]",
                positions, positions, times, slide, times, weights);
    fathom_scene *scene = read_at(0.5);
    assert_vec(placed_corner(scene, 0, 0, 1), 5, 0, 0, 0);
    assert_vec(placed_corner(scene, 1, 1, 1), 1.5, 3, 0, 0);
    assert_int_equal(warning_count, 1);
    expect_warning(": nodes[1] (\"fixed\"): a node has a matrix and an animation");
    expect_warning("(2 such)");
}

/* However many times the shutter poses the nodes, each oddity of a node counts once. */
UNIT_TEST(oddities_count_once_while_the_shutter_is_open) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              times = PUT_FLOATS(&b, "SCALAR", 3, 0, 1, 1),
              turns = PUT_FLOATS(&b, "VEC4", 3, 0, 0, 0, 1, 0, 0.6f, 0, 0.8f, 0, 0.6f, 0, 0.8f);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'targets':[{'POSITION':%d}]}]}],"
                "'nodes':[{'mesh':0},{'mesh':0,'weights':[1e31],'rotation':[0,0,0,0]}],'animations':[{"
                "'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{'node':0,'path':"
                "'rotation'}},{'sampler':0,'target':{'node':-1,'path':'rotation'}}]}]",
                positions, positions, times, turns);
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.shutter = 1;
    memset(warned, 0, sizeof warned);
    fathom_scene *scene = read_as(&asked);
    assert_true(scene->instances.items[0].key_count > 2);
    assert_int_equal(warning_count, 4);
    for (const char *line = warned; *line; line = strchr(line, '\n') + 1) {
        const char *end = strchr(line, '\n');
        if (strncmp(end - 8, "(1 such)", 8) != 0) fail_msg("%s", warned);
    }
}

/* It and what is below it, also while an animation moves it. */
UNIT_TEST(nodes_of_several_parents_are_shown_below_each) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), slide = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 0, 0, 8);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'scenes':[{'nodes':[0]}],'nodes':["
        "{'children':[1,2]},{'translation':[1,0,0],'children':[3,4,3]},{'translation':[0,5,0],"
        "'children':[3]},{'children':[5]},{'mesh':0},{'mesh':0,'scale':[2,2,2]}],'animations':[{"
        "'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{'node':3,'path':"
        "'translation'}}]}]",
        positions, times, slide);
    forget_warnings();
    fathom_scene *scene = read_at(0.25);
    assert_int_equal(scene->instances.count, 3);
    assert_vec(placed_corner(scene, 0, 0, 1), 3, 0, 2, 0);
    assert_vec(placed_corner(scene, 1, 0, 1), 2, 0, 0, 0);
    assert_vec(placed_corner(scene, 2, 0, 1), 2, 5, 2, 0);
    assert_int_equal(warning_count, 2);
    expect_warning("nodes[1].children: a node names a child twice; it is shown once (1 ");
    expect_warning("nodes[2].children: a node with several parents, which is against the "
                   "format, is shown below each of them (1 such)");
}

/* Twenty pairs of nodes, each below both nodes of the pair before: a million copies, too many for so small a
 * file. */
UNIT_TEST(copies_of_nodes_are_limited) {
    build b = {.size = 0};
    char nodes[2048] = "";
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    const int positions = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0);
    for (int i = 0; i < 40; ++i)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "{'children':[%d,%d]},", i / 2 * 2 + 2,
                 i / 2 * 2 + 3);
    build_write(
        &b, "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[%s{'mesh':0},{'mesh':0}]",
        positions, nodes);
    assert_fails(context, read_asked(&asked, &scene), FATHOM_BAD_INPUT, "raises what the file needs to");
}

/* A mark before the JSON and zeros behind it. */
UNIT_TEST(marks_and_zeros_around_the_json_are_skipped) {
    static const char text[] = "\xEF\xBB\xBF{\"asset\":{\"version\":\"2.0\"}}\0\0";
    write_bytes("test.gltf", text, sizeof text);
    read_file();
    unsigned char glb[256];
    write_bytes("test.glb", glb, make_glb("\xEF\xBB\xBF{" ASSET "}", NULL, 0, glb));
    read_file();
}

int main(void) { return unit_main(open_folder, remove_folder); }
