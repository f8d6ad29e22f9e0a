/* glTF geometry: what meshes hold must be what the file says, and be in the file where it can be. */
#include "gltf_file.h"

/* Whether an address lies in a mapping of this file: the system's own list of mappings says. */
static bool is_mapped_from(const void *address, const char *path) {
    FILE *maps = fopen("/proc/self/maps", "r");
    assert_non_null(maps);
    char line[512];
    bool found = false;
    while (fgets(line, sizeof line, maps)) {
        unsigned long long from, to;
        if (sscanf(line, "%llx-%llx", &from, &to) != 2 || !strstr(line, path)) continue;
        found = found || ((uintptr_t)address >= from && (uintptr_t)address < to);
    }
    fclose(maps);
    return found;
}

static void assert_is_triangle(const fathom_scene *scene, size_t mesh, const int order[3]) {
    assert_int_equal(scene->meshes.items[mesh].triangle_count, 1);
    for (int c = 0; c < 3; ++c) {
        const float *p = triangle.positions[order[c]];
        assert_vec(corner(scene, mesh, 0, c), p[0], p[1], p[2], 0);
    }
}

UNIT_TEST(arrays_stay_in_the_file) {
    fathom_scene *scene = read_triangle(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0,'"
                                              "NORMAL':4,'TEXCOORD_0':5},'indices':1}]}]"));
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_true(is_mapped_from(mesh->positions, file_path));
    assert_true(is_mapped_from(mesh->normals, file_path));
    assert_true(is_mapped_from(mesh->uvs, file_path));
    assert_true(is_mapped_from(mesh->indices, file_path));
    assert_is_triangle(scene, 0, (const int[3]){0, 1, 2});
    assert_memory_equal(mesh->normals, triangle.normals, sizeof triangle.normals);
    assert_memory_equal(mesh->uvs, triangle.uvs, sizeof triangle.uvs);
    assert_int_equal(warning_count, 0);
}

UNIT_TEST(files_are_closed_after_reading) {
    fathom_scene *scene = read_triangle(SHOWN(TRIANGLE_MESH));
    const void *positions = scene->meshes.items[0].positions;
    unit_end_things(0);
    assert_false(is_mapped_from(positions, file_path));
}

UNIT_TEST(indices_of_every_width_are_read) {
    const int orders[3][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
    for (int i = 0; i < 3; ++i) {
        fathom_scene *scene = read_triangle(unit_text(
            SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':%d}]}]"), i + 1));
        assert_is_triangle(scene, 0, orders[i]);
    }
    fathom_scene *scene = read_triangle(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"));
    assert_is_triangle(scene, 0, orders[0]);
}

UNIT_TEST(interleaved_and_misaligned_arrays_are_read) {
    unsigned char bytes[160] = {0};
    for (int i = 0; i < 3; ++i) {
        memcpy(bytes + 24 * i, triangle.positions[i], 12);
        memcpy(bytes + 24 * i + 12, triangle.normals[i], 12);
        memcpy(bytes + 82 + 12 * i, triangle.positions[i], 12);
    }
    write_glb(
        "{" ASSET
        ",'buffers':[{'byteLength':118}],'bufferViews':[{'buffer':0,'byteLength':72,'byteStride':24},"
        "{'buffer':0,'byteOffset':82,'byteLength':36}],'accessors':["
        "{'bufferView':0,'componentType':5126,'type':'VEC3','count':3},"
        "{'bufferView':0,'byteOffset':12,'componentType':5126,'type':'VEC3','count':3},"
        "{'bufferView':1,'componentType':5126,'type':'VEC3','count':3}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1}},{'attributes':{'POSITION':2}}]}]}",
        bytes, 118);
    fathom_scene *scene = read_file();
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_int_equal(mesh->position_stride, 24);
    assert_ptr_equal((const char *)mesh->positions + 12, mesh->normals);
    assert_true(is_mapped_from(mesh->positions, file_path));
    assert_is_triangle(scene, 0, (const int[3]){0, 1, 2});
    assert_int_equal((uintptr_t)scene->meshes.items[1].positions % 4, 0);
    assert_is_triangle(scene, 1, (const int[3]){0, 1, 2});
}

/* KHR_mesh_quantization: f = max(c / (2^(bits-1) - 1), -1) when normalized, else f = c. */
UNIT_TEST(quantized_arrays_are_scaled) {
    const struct {
        int16_t shorts[3][4];
        int8_t bytes[3][4];
        uint16_t uvs[3][2];
    } data = {{{-32768, 0, 0}, {32767, 0, 0}, {0, 16384, 0}},
              {{-128, 0, 0}, {127, 0, 0}, {0, 64, 0}},
              {{0, 0}, {65535, 0}, {0, 32768}}};
    write_glb("{" ASSET
              ",'extensionsRequired':['KHR_mesh_quantization'],'buffers':[{'byteLength':48}],'bufferViews':["
              "{'buffer':0,'byteLength':24,'byteStride':8},{'buffer':0,'byteOffset':24,'byteLength':12,'"
              "byteStride':4},"
              "{'buffer':0,'byteOffset':36,'byteLength':12}],'accessors':["
              "{'bufferView':0,'componentType':5122,'normalized':true,'type':'VEC3','count':3},"
              "{'bufferView':1,'componentType':5120,'type':'VEC3','count':3},"
              "{'bufferView':1,'componentType':5120,'normalized':true,'type':'VEC3','count':3},"
              "{'bufferView':2,'componentType':5123,'normalized':true,'type':'VEC2','count':3}],"
              "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':2,'TEXCOORD_0':3}},"
              "{'attributes':{'POSITION':1}}]}]}",
              &data, sizeof data);
    fathom_scene *scene = read_file();
    const float half = 16384 / 32767.0f;
    assert_vec(corner(scene, 0, 0, 0), -1, 0, 0, 0);
    assert_vec(corner(scene, 0, 0, 1), 1, 0, 0, 0);
    assert_vec(corner(scene, 0, 0, 2), 0, (double)half, 0, 0);
    assert_vec(corner(scene, 1, 0, 0), -128, 0, 0, 0);
    assert_vec(corner(scene, 1, 0, 2), 0, 64, 0, 0);
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_near(mesh->normals[0], -1, 0);
    assert_near(mesh->normals[7], 64 / 127.0f, 0);
    assert_near(mesh->uvs[2], 1, 0);
    assert_near(mesh->uvs[5], 32768 / 65535.0f, 0);
}

/* Every triangle of a flat strip or fan faces the way the first one does, and together they cover the whole.
 */
UNIT_TEST(strips_and_fans_keep_their_winding) {
    const struct {
        float strip[6][3];
        float fan[5][3];
    } data = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}, {1, 2, 0}},
              {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5f, 2, 0}, {0, 1, 0}}};
    const struct {
        int accessor, mode;
        uint32_t triangles;
        double area;
    } cases[] = {{0, 5, 4, 2}, {1, 6, 3, 1.5}};
    for (int i = 0; i < 2; ++i) {
        const char *json = unit_text(
            "{" ASSET ",'buffers':[{'byteLength':132}],'bufferViews':[{'buffer':0,'byteLength':132}],"
            "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':6},"
            "{'bufferView':0,'byteOffset':72,'componentType':5126,'type':'VEC3','count':5}],"
            "'meshes':[{'primitives':[{'attributes':{'POSITION':%d},'mode':%d}]}]}",
            cases[i].accessor, cases[i].mode);
        write_glb(json, &data, sizeof data);
        fathom_scene *scene = read_file();
        assert_int_equal(scene->meshes.items[0].triangle_count, cases[i].triangles);
        double area = 0;
        for (uint32_t t = 0; t < cases[i].triangles; ++t) {
            vec3_f64 a = corner(scene, 0, t, 0), b = corner(scene, 0, t, 1), c = corner(scene, 0, t, 2);
            double twice = cross_f64(sub_f64(b, a), sub_f64(c, a)).z;
            assert_true(twice > 0);
            area += twice / 2;
        }
        assert_near(area, cases[i].area, 0); /* sums of multiples of 1/4 */
    }
}

/* Vertex 1 of the triangle is replaced, over the file's values and over zeros. */
UNIT_TEST(sparse_accessors_replace_elements) {
    struct {
        triangle_data base;
        uint8_t which[4];
        float value[3];
        uint16_t replaced_index[2];
    } data = {triangle, {1, 0, 0, 0}, {7, 8, 9}, {1, 0}};
    write_glb("{" ASSET ",'buffers':[{'byteLength':140}],'bufferViews':[{'buffer':0,'byteLength':120},"
              "{'buffer':0,'byteOffset':120,'byteLength':1},{'buffer':0,'byteOffset':124,'byteLength':12},"
              "{'buffer':0,'byteOffset':136,'byteLength':2}],'accessors':["
              "{'bufferView':0,'componentType':5126,'type':'VEC3','count':3,'sparse':{'count':1,"
              "'indices':{'bufferView':1,'componentType':5121},'values':{'bufferView':2}}},"
              "{'componentType':5126,'type':'VEC3','count':3,'sparse':{'count':1,"
              "'indices':{'bufferView':1,'componentType':5121},'values':{'bufferView':2}}},"
              "{'componentType':5123,'type':'SCALAR','count':3,'sparse':{'count':1,"
              "'indices':{'bufferView':1,'componentType':5121},'values':{'bufferView':3}}}],"
              "'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':1},'indices':"
              "2}]}]}",
              &data, sizeof data);
    fathom_scene *scene = read_file();
    assert_vec(corner(scene, 0, 0, 0), 0, 0, 0, 0);
    assert_vec(corner(scene, 0, 0, 1), 7, 8, 9, 0);
    assert_vec(corner(scene, 0, 0, 2), 0, 1, 0.5, 0);
    assert_vec(corner(scene, 1, 0, 0), 0, 0, 0, 0);
    assert_vec(corner(scene, 1, 0, 1), 7, 8, 9, 0);
}

/* A large shape key, of which few vertices differ from zero. */
UNIT_TEST(many_sparse_elements_need_no_view) {
    enum { COUNT = 1100000, BYTES = 300000 };
    unsigned char *bytes = unit_memory(BYTES);
    memcpy(bytes, &(uint32_t[1]){COUNT - 2}, 4);
    memcpy(bytes + 4, (float[3]){7, 8, 9}, 12);
    write_glb("{" ASSET ",'buffers':[{'byteLength':300000}],'bufferViews':[{'buffer':0,'byteLength':4},"
              "{'buffer':0,'byteOffset':4,'byteLength':12}],'accessors':["
              "{'componentType':5126,'type':'VEC3','count':1100000,'sparse':{'count':1,"
              "'indices':{'bufferView':0,'componentType':5125},'values':{'bufferView':1}}}],"
              "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5}]}]}",
              bytes, BYTES);
    fathom_scene *scene = read_file();
    assert_int_equal(scene->meshes.items[0].vertex_count, COUNT);
}

/* Content decides which of the two forms a file has, not its name. */
UNIT_TEST(text_and_binary_files_may_swap_their_names) {
    const char *json = SHOWN(TRIANGLE_MESH);
    unsigned char glb[4096];
    write_bytes("test.gltf", glb, make_glb(json, &triangle, sizeof triangle, glb));
    assert_is_triangle(read_file(), 0, (const int[3]){0, 1, 2});
    char base64[256], text[4096];
    encode_base64((const unsigned char *)&triangle, sizeof triangle, base64);
    snprintf(text, sizeof text,
             "\xef\xbb\xbf\n {" ASSET ",'buffers':[{'byteLength':120,'uri':'data:;base64,%s'}]," VIEWS
             "," ACCESSORS "," TRIANGLE_MESH "}",
             base64);
    for (char *c = text; *c; ++c) *c = *c == '\'' ? '"' : *c;
    write_bytes("test.glb", text, strlen(text));
    assert_is_triangle(read_file(), 0, (const int[3]){0, 1, 2});
}

/* Every number of bytes at the end: 0, 1 or 2 over a multiple of three. */
UNIT_TEST(base64_buffers_are_decoded) {
    for (size_t extra = 0; extra < 3; ++extra) {
        unsigned char bytes[128] = {0};
        memcpy(bytes, &triangle, sizeof triangle);
        char text[256];
        encode_base64(bytes, sizeof triangle + extra, text);
        write_gltf(unit_text(
            "{" ASSET ",'buffers':[{'byteLength':%zu,'uri':'data:application/octet-stream;base64,%s'}]," VIEWS
            "," ACCESSORS "," TRIANGLE_MESH "}",
            sizeof triangle + extra, text));
        fathom_scene *scene = read_file();
        assert_is_triangle(scene, 0, (const int[3]){0, 1, 2});
    }
}

/* As MIME and URIs allow. */
UNIT_TEST(base64_may_have_line_breaks_and_percent_codes) {
    unsigned char bytes[121] = {0};
    memcpy(bytes, &triangle, sizeof triangle);
    char text[256], json[4096], broken[1024] = "", *to = broken;
    encode_base64(bytes, sizeof bytes, text);
    assert_string_equal(text + strlen(text) - 2, "==");
    for (size_t i = 0; text[i]; ++i) {
        if (i % 20 == 7) to += sprintf(to, i % 40 == 7 ? "\\r\\n " : "%%0A");
        to += sprintf(to, text[i] == '=' || text[i] == 'A' ? "%%%02x" : "%c", text[i]);
    }
    snprintf(json, sizeof json,
             "{" ASSET ",'buffers':[{'byteLength':120,'uri':'data:;base64,%s\\n'}]," VIEWS "," ACCESSORS
             "," TRIANGLE_MESH "}",
             broken);
    write_gltf(json);
    assert_is_triangle(read_file(), 0, (const int[3]){0, 1, 2});
}

UNIT_TEST(external_buffers_are_read) {
    write_bytes("a mesh.bin", &triangle, sizeof triangle);
    char binary[128];
    strcpy(binary, file_path);
    write_gltf("{" ASSET ",'buffers':[{'byteLength':120,'uri':'a%20mesh.bin'}]," VIEWS "," ACCESSORS
               "," TRIANGLE_MESH "}");
    fathom_scene *scene = read_file();
    assert_is_triangle(scene, 0, (const int[3]){0, 1, 2});
    assert_true(is_mapped_from(scene->meshes.items[0].positions, binary));
    assert_int_equal(unlink(binary), 0);
    scene = new_scene(context);
    const read_mesh_options options = {.material = FATHOM_NONE};
    assert_fails(context, read_gltf(scene, FATHOM_ROOT, file_path, &options), FATHOM_BAD_INPUT,
                 "buffers[0].uri: ");
}

UNIT_TEST(shared_accessors_are_converted_once) {
    fathom_scene *scene = read_triangle(SHOWN(
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':2},{'attributes':{'POSITION':0},"
        "'indices':2}]}]"));
    assert_int_equal(scene->meshes.count, 2);
    assert_ptr_equal(scene->meshes.items[0].indices, scene->meshes.items[1].indices);
    assert_ptr_equal(scene->meshes.items[0].positions, scene->meshes.items[1].positions);
}

UNIT_TEST(options_are_applied) {
    write_triangle(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':4},'indices':1}]},"
                         "{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]"));
    read_mesh_options options = {.material = 0, .flags = FATHOM_CASTS_NO_SHADOW, .flat = true};
    fathom_scene *scene = read_with(&options);
    assert_null(scene->meshes.items[0].normals);
    assert_int_equal(scene->meshes.items[0].material, 0);
    assert_int_equal(scene->meshes.items[0].flags, FATHOM_CASTS_NO_SHADOW);
    assert_int_equal(scene->materials.count, 1);
}

/* A mesh without normals is flat by the standard; smooth ones are made when asked for, but never over the
 * file's own. One triangle's are all its geometric normal. */
UNIT_TEST(missing_normals_are_made_smooth) {
    write_triangle(WITH_DATA("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1},"
                             "{'attributes':{'POSITION':0,'NORMAL':4},'indices':1}]}]"));
    fathom_scene *scene = read_file();
    assert_null(scene->meshes.items[0].normals);
    const read_mesh_options options = {.material = FATHOM_NONE, .smooth = true};
    scene = read_with(&options);
    vec3_f64 a = corner(scene, 0, 0, 0), b = corner(scene, 0, 0, 1), c = corner(scene, 0, 0, 2);
    vec3_f64 n = normalize_f64(cross_f64(sub_f64(b, a), sub_f64(c, a)));
    for (size_t i = 0; i < 3; ++i) {
        /* A normal of unit length in float, a few roundings of 2^-24. */
        assert_vec(widen(load_f32(scene->meshes.items[0].normals + 3 * i)), n.x, n.y, n.z, 4 * 0x1p-24);
    }
    assert_memory_equal(scene->meshes.items[1].normals, triangle.normals, sizeof triangle.normals);
}

int main(void) { return unit_main(open_folder, remove_folder); }
