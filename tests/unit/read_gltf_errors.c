/* glTF files that are wrong: one message that says where, and never a crash. */
#include "gltf_file.h"

static const read_mesh_options plain = {.material = FATHOM_NONE, .surroundings = true};

/* Reads file_path and expects a message that holds the path and `text`. */
static void assert_rejected(const char *text) {
    fathom_scene *scene = new_scene(context);
    assert_fails(context, read_gltf(scene, FATHOM_ROOT, file_path, &plain), FATHOM_BAD_INPUT, text);
    assert_non_null(strstr(fathom_context_message(context), file_path));
}

UNIT_TEST(broken_containers_are_refused) {
    unsigned char glb[4096];
    size_t size = make_glb("{" ASSET "}", &triangle, sizeof triangle, glb);
    uint32_t json_size;
    memcpy(&json_size, glb + 12, 4);
    const struct {
        size_t at;
        uint32_t word;
        const char *text;
    } cases[] = {{4, 1, "at byte 4: the file is glTF 1.0, which is not read"},
                 {8, (uint32_t)size + 1, "at byte 8: "},
                 {8, 15, "at byte 8: "},
                 {12, 0x7fffffff, "at byte 12: "},
                 {16, 0x4E4942, "at byte 16: "},
                 {20 + json_size, 0xffffffff, "only"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        unsigned char changed[4096];
        memcpy(changed, glb, size);
        memcpy(changed + cases[i].at, &cases[i].word, 4);
        write_bytes("test.glb", changed, size);
        assert_rejected(cases[i].text);
    }
    write_bytes("test.glb", "[]", 2);
    assert_rejected("at byte 0: expected the magic number");
    write_bytes("test.glb", "{}", 2);
    assert_rejected("asset.version: is missing");
    write_bytes("test.glb", "glTF", 4);
    assert_rejected("at byte 4: ");
    write_bytes("test.gltf", "{\n\"asset\": {,}\n}", 16);
    assert_rejected("test.gltf:2:");
    write_bytes("test.gltf", "[]", 2);
    assert_rejected("expected a glTF object");
}

typedef struct bad_file {
    const char *json, *text;
} bad_file;

static void assert_all_rejected(const bad_file *files, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        write_triangle(files[i].json);
        assert_rejected(files[i].text);
    }
}

UNIT_TEST(broken_documents_are_refused) {
    const bad_file files[] = {
        {"{}", "asset.version: is missing"},
        {"{'asset':{'version':'1.0'}}",
         "asset.version: the file is glTF 1.0, which is not read; expected glTF 2.0"},
        {"{'asset':{'version':0.8}}",
         "asset.version: the file is glTF 1.0, which is not read; expected glTF 2.0"},
        {"{'asset':{'version':2}}", "asset.version: is a number; expected a string"},
        {"{'asset':{'version':'2.1','minVersion':'2.1'}}", "asset.minVersion: "},
        {"{'asset':[]}", "asset: is an array; expected an object"},
        {"{" ASSET ",'extensionsRequired':['KHR_texture_video']}",
         "extensionsRequired[0]: the file cannot be read without the extension "
         "\"KHR_texture_video\""},
        {"{" ASSET ",'extensionsRequired':[1]}", "extensionsRequired[0]: "},
        {"{" ASSET ",'meshes':{}}", "meshes: is an object; expected an array"},
        {"{" ASSET ",'meshes':[1]}", "meshes[0]: is a number; expected an object"},
        {"{" ASSET ",'extensions':{'KHR_lights_punctual':{'lights':3}}}",
         "extensions.KHR_lights_punctual.lights: is a number; expected an array"},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
}

#define MESH(primitive) SHOWN("'meshes':[{'primitives':[{" primitive "}]}]")
#define ONE_VIEW(view, accessor)                                                                             \
    "{" ASSET ",'buffers':[{'byteLength':120}],'bufferViews':[{" view "}],'accessors':[{" accessor           \
    "}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}"
#define VEC3(count) "'componentType':5126,'type':'VEC3','count':" #count

UNIT_TEST(broken_meshes_are_refused) {
    const bad_file files[] = {
        {MESH("'attributes':{'POSITION':17}"),
         "meshes[0].primitives[0].attributes.POSITION: is 17; expected an index into accessors, which has 6"},
        {MESH("'attributes':{'POSITION':-2}"), "attributes.POSITION: is -2"},
        {MESH("'attributes':{'POSITION':0.5}"), "attributes.POSITION: is 0.5; expected an integer"},
        {MESH("'attributes':{'POSITION':5}"),
         "meshes[0].primitives[0].attributes.POSITION: is accessors[5] of 2 × float; expected 3 × float"},
        {MESH("'attributes':{'POSITION':0,'NORMAL':1}"),
         "attributes.NORMAL: is accessors[1] of 1 × unsigned int"},
        {MESH("'attributes':{'POSITION':0},'indices':0"),
         "primitives[0].indices: is accessors[0] of 3 × float"},
        {MESH("'attributes':{'POSITION':0},'mode':9"), "primitives[0].mode: is 9"},
        {MESH("'attributes':{'POSITION':0},'material':2"), "primitives[0].material: is 2"},
        {MESH("'attributes':7"), "primitives[0].attributes: is a number; expected an object"},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
}

UNIT_TEST(broken_accessors_are_refused) {
    const bad_file files[] = {
        {ONE_VIEW("'buffer':0,'byteLength':121", "'bufferView':0," VEC3(3)), "bufferViews[0]: spans bytes"},
        {ONE_VIEW("'buffer':0,'byteOffset':9007199254740993,'byteLength':36", "'bufferView':0," VEC3(3)),
         "bufferViews[0]: spans bytes"},
        {ONE_VIEW("'buffer':0,'byteLength':35", "'bufferView':0," VEC3(3)), "accessors[0]: needs 36 bytes"},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'bufferView':0,'byteOffset':88," VEC3(3)),
         "accessors[0]: needs 36 bytes"},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'bufferView':0," VEC3(4294967294)), "accessors[0]: needs "},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'bufferView':0," VEC3(9007199254740993)),
         "accessors[0].count: is "},
        {ONE_VIEW("'buffer':0,'byteLength':120,'byteStride':8", "'bufferView':0," VEC3(3)),
         "bufferViews[0].byteStride: is 8"},
        {ONE_VIEW("'buffer':1,'byteLength':120", "'bufferView':0," VEC3(3)), "bufferViews[0].buffer: is 1"},
        {ONE_VIEW("'byteLength':120", "'bufferView':0," VEC3(3)), "bufferViews[0].buffer: is missing"},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'bufferView':3," VEC3(3)), "accessors[0].bufferView: is 3"},
        {ONE_VIEW("'buffer':0,'byteLength':120",
                  "'bufferView':0,'componentType':5124,'type':'VEC3','count':3"),
         "accessors[0].componentType: is 5124"},
        {ONE_VIEW("'buffer':0,'byteLength':120",
                  "'bufferView':0,'componentType':5126,'type':'MAT3','count':3"),
         "accessors[0].type: is \"MAT3\""},
        {ONE_VIEW(
             "'buffer':0,'byteLength':120",
             "'sparse':{'count':2,'indices':{'bufferView':0,'componentType':5121},'values':{'bufferView':0}"
             "}," VEC3(3)),
         "accessors[0].sparse.indices: entry 1 is 0"},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'sparse':{'count':4}," VEC3(3)),
         "accessors[0].sparse.count: is 4"},
        {ONE_VIEW("'buffer':0,'byteLength':120", "'sparse':{'count':1}," VEC3(3)),
         "accessors[0].sparse: is incomplete"},
        {"{" ASSET ",'buffers':[{'byteLength':120,'uri':'data:;base64,AA!A'}]," VIEWS "," ACCESSORS
         "," TRIANGLE_MESH "}",
         "buffers[0].uri: is not base64 from its character 15 on"},
        {"{" ASSET ",'buffers':[{'byteLength':120,'uri':'http://a/b'}]," VIEWS "," ACCESSORS "," TRIANGLE_MESH
         "}",
         "buffers[0].uri: is \"http://a/b\""},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
}

/* A few bytes may not ask for any amount of memory: elements that are zero, and nothing else, by the million;
 * one array unrolled again and again. The same in proportion to the file is fine. */
UNIT_TEST(memory_out_of_proportion_is_refused) {
    const bad_file files[] = {
        {"{" ASSET ",'accessors':[{" VEC3(1000000) "}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}"
                                                   "]}]}",
         "meshes[0].primitives[0].attributes.POSITION: raises what the file needs to 12000000 bytes"},
        {"{" ASSET ",'accessors':[{" VEC3(
             30000) "},{'componentType':5125,'type':'SCALAR','count':1000000}],"
                    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
         "raises what the file needs to"},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
    write_triangle("{" ASSET ",'accessors':[{" VEC3(3000) "}],'meshes':[{'primitives':[{'attributes':{"
                                                          "'POSITION':0}}]}]}");
    fathom_scene *scene = new_scene(context);
    assert_ok(context, read_gltf(scene, FATHOM_ROOT, file_path, &plain));
}

/* What making normals takes meanwhile counts, and is given back: the second file makes them three times. */
UNIT_TEST(normals_out_of_proportion_are_refused) {
    const read_mesh_options smooth = {.material = FATHOM_NONE, .smooth = true};
    write_triangle("{" ASSET ",'accessors':[{" VEC3(3000) "}],'meshes':[{'primitives':[{'attributes':{"
                                                          "'POSITION':0}}]}]}");
    fathom_scene *scene = new_scene(context);
    assert_fails(context, read_gltf(scene, FATHOM_ROOT, file_path, &smooth), FATHOM_BAD_INPUT,
                 "meshes[0].primitives[0]: raises what the file needs to 156000 bytes of memory");
#define PART "{'attributes':{'POSITION':0}}"
    write_triangle("{" ASSET ",'accessors':[{" VEC3(999) "}],'meshes':[{'primitives':[" PART "," PART "," PART
                                                         "]}]}");
#undef PART
    scene = new_scene(context);
    assert_ok(context, read_gltf(scene, FATHOM_ROOT, file_path, &smooth));
}

/* What a message quotes cannot steer the terminal that shows it. */
UNIT_TEST(control_characters_are_not_printed) {
    write_triangle("{'asset':{'version':'\\u001b[2J\\n'}}");
    assert_rejected("asset.version: is \"?[2J?\"");
}

UNIT_TEST(wrong_values_name_their_place) {
    triangle_data data = triangle;
    data.positions[2][1] = NAN;
    write_glb(SHOWN(TRIANGLE_MESH), &data, sizeof data);
    assert_rejected("meshes[0].primitives[0].attributes.POSITION: entry[2]: expected finite numbers");
    data = triangle;
    data.indices[1] = 3;
    write_glb(SHOWN(TRIANGLE_MESH), &data, sizeof data);
    assert_rejected(
        "meshes[0].primitives[0].indices: entry[1]: 3, of triangle 0, is out of range; there are 3");
}

#define NODES(nodes) WITH_DATA(TRIANGLE_MESH ",'nodes':[" nodes "]")

UNIT_TEST(broken_nodes_are_refused) {
    const bad_file files[] = {
        {NODES("{'children':[1]},{'children':[2]},{'children':[1]}"),
         "nodes[2].children: leads back to nodes[1]"},
        {NODES("{'children':[1]},{'children':[0]},{'children':[0]}"), "leads back to nodes[0]"},
        {NODES("{},{'children':[2]},{'children':[1]}"), "nodes[1].children: leads back to nodes[1]"},
        {NODES("{'children':[0]}"), "nodes[0].children: leads back to nodes[0]"},
        {NODES("{'children':[7]}"), "nodes[0].children[0]: is 7; expected an index into nodes"},
        {NODES("{'mesh':1}"), "nodes[0].mesh: is 1; expected an index into meshes, which has 1"},
        {NODES("{'mesh':0,'matrix':[1,0,0]}"), "nodes[0].matrix: has 3 entries; expected 16"},
        {NODES("{'mesh':0,'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}"),
         "nodes[0].matrix: has the last row 1 0 0 1"},
        {NODES("{'translation':[0,'x',0]}"), "nodes[0].translation[1]: is a string; expected a number"},
        {NODES("{'scale':[1e308,1,1],'children':[1]},{'scale':[1e308,1,1],'mesh':0}"), "beyond the range"},
        {NODES("{}],'scenes':[{}],'scene':[1"), "scene: is an array; expected an integer"},
        {NODES("{'camera':0}"), "nodes[0].camera: is 0; expected an index into cameras"},
        {NODES("{'camera':0}],'cameras':[{'type':'fisheye'}"), "cameras[0].type: is \"fisheye\""},
        {NODES("{'extensions':{'KHR_lights_punctual':{'light':0}}}"),
         "nodes[0].extensions.KHR_lights_punctual.light: is 0; expected an index into lights"},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
}

#define LIGHT(light)                                                                                         \
    "{" ASSET ",'extensions':{'KHR_lights_punctual':{'lights':[{" light                                      \
    "}]}},'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}]}"
#define MATERIAL(material)                                                                                   \
    SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'materials':[{" material   \
          "}]")

UNIT_TEST(broken_lights_and_materials_are_refused) {
    const bad_file files[] = {
        {LIGHT("'type':'point','color':[1,1]"), "lights[0].color: has 2 entries"},
        {MATERIAL("'pbrMetallicRoughness':{'baseColorFactor':[1,1,1]}"),
         "materials[0].pbrMetallicRoughness.baseColorFactor: has 3 entries; expected 4"},
        {MATERIAL("'pbrMetallicRoughness':{'metallicFactor':'1'}"),
         "materials[0].pbrMetallicRoughness.metallicFactor: is a string; expected a number"},
        {MATERIAL("'name':3"), "materials[0].name: is a number; expected a string"},
    };
    assert_all_rejected(files, sizeof files / sizeof *files);
}

/* ---- damaged files ---- */

#define RICH                                                                                                 \
    VIEWS "," ACCESSORS ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','intensity':4}]}},"  \
          "'materials':[{'name':'m','pbrMetallicRoughness':{'metallicFactor':0.5},'alphaMode':'BLEND'}],"    \
          "'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"                                     \
          "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':4,'TEXCOORD_0':5},'indices':1,"     \
          "'material':0},{'attributes':{'POSITION':0},'indices':2,'mode':5}]}],"                             \
          "'nodes':[{'children':[1,2,3]},{'mesh':0,'scale':[1,2,3]},{'camera':0},{'extensions':{"            \
          "'KHR_lights_punctual':{'light':0}}}],'scenes':[{'nodes':[0]}],'scene':0}"
#define RICH_GLB "{" ASSET ",'buffers':[{'byteLength':120}]," RICH
#define RICH_GLTF "{" ASSET ",'buffers':[{'byteLength':120,'uri':'data:;base64,%s'}]," RICH

/* OK or a message, and what was read can be walked over: every vertex that a triangle names is there. */
static bool read_damaged(void) {
    fathom_scene *scene = new_scene(context);
    fathom_status status = read_gltf(scene, FATHOM_ROOT, file_path, &plain);
    if (status == FATHOM_OK) {
        for (size_t m = 0; m < scene->meshes.count; ++m) {
            for (uint32_t t = 0; t < scene->meshes.items[m].triangle_count; ++t) {
                for (int c = 0; c < 3; ++c) assert_true(finite_f64(corner(scene, m, t, c)));
            }
        }
    } else {
        assert_int_equal(status, FATHOM_BAD_INPUT);
        const char *message = fathom_context_message(context);
        if (!strstr(message, file_path)) fail_msg("\"%s\" does not name the file", message);
    }
    unit_end_things(0);
    return status == FATHOM_OK;
}

UNIT_TEST(truncation_anywhere_is_an_error) {
    unsigned char glb[8192];
    size_t size = make_glb(RICH_GLB, &triangle, sizeof triangle, glb);
    for (size_t cut = 1; cut < size; ++cut) {
        write_bytes("test.glb", glb, cut);
        assert_false(read_damaged());
        /* With a header that fits, only the contents can tell. */
        if (cut < 20) continue;
        unsigned char changed[8192];
        memcpy(changed, glb, cut);
        uint32_t length = (uint32_t)cut;
        memcpy(changed + 8, &length, 4);
        write_bytes("test.glb", changed, cut);
        assert_false(read_damaged());
    }
    write_bytes("test.glb", glb, size);
    assert_true(read_damaged());
}

/* xorshift64: the same bytes on every machine. */
static uint64_t next_random(uint64_t *x) {
    *x ^= *x << 13;
    *x ^= *x >> 7;
    *x ^= *x << 17;
    return *x;
}

/* Reads the file 10^4 times, each time with one to three bytes changed. */
static void damage(const char *name, const unsigned char *bytes, size_t size) {
    unsigned char changed[8192];
    size_t good = 0;
    uint64_t random = 0x9E3779B97F4A7C15;
    for (int i = 0; i < 10000; ++i) {
        memcpy(changed, bytes, size);
        /* Digits for digits half of the time: those get past the JSON parser. */
        for (uint64_t flips = 1 + next_random(&random) % 3; flips; --flips) {
            size_t at = next_random(&random) % size;
            unsigned char byte = (unsigned char)(next_random(&random) >> 32);
            bool digit = changed[at] >= '0' && changed[at] <= '9';
            changed[at] = digit && byte & 1 ? (unsigned char)('0' + byte % 10) : byte;
        }
        write_bytes(name, changed, size);
        good += read_damaged();
    }
    /* Both happen, or the test tests nothing. */
    assert_in_range(good, 100, 9900);
}

UNIT_TEST(random_bytes_do_no_harm) {
    unsigned char glb[8192];
    damage("test.glb", glb, make_glb(RICH_GLB, &triangle, sizeof triangle, glb));
}

/* The same with the buffer in base64, which is decoded into memory of its own. */
UNIT_TEST(random_characters_do_no_harm) {
    char text[256], json[8192];
    encode_base64((const unsigned char *)&triangle, sizeof triangle, text);
    snprintf(json, sizeof json, RICH_GLTF, text);
    for (char *c = json; *c; ++c) {
        if (*c == '\'') *c = '"';
    }
    damage("test.gltf", (const unsigned char *)json, strlen(json));
}

int main(void) { return unit_main(open_folder, remove_folder); }
