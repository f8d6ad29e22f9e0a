/* Hand-made glTF files for the tests of its reader. JSON is written with ' for ". */
#pragma once

#include "owned.h"
#include "read/read.h"
#include "unit_folder.h"

static char file_path[256]; /* of the last file written */

static inline void write_bytes(const char *name, const void *bytes, size_t size) {
    snprintf(file_path, sizeof file_path, "%s", in_folder(name));
    unit_write_file(file_path, bytes, size);
}

/* A GLB in memory; returns its size. `out` has room for all of it. */
static inline size_t make_glb(const char *json, const void *binary, size_t binary_size, unsigned char *out) {
    size_t length = strlen(json), padded = (length + 3) / 4 * 4, chunk = (binary_size + 3) / 4 * 4;
    size_t size = 12 + 8 + padded + (binary ? 8 + chunk : 0);
    const uint32_t head[5] = {0x46546C67, 2, (uint32_t)size, (uint32_t)padded, 0x4E4F534A};
    memcpy(out, head, sizeof head);
    for (size_t i = 0; i < padded; ++i) {
        char c = i < length ? json[i] : ' ';
        out[20 + i] = (unsigned char)(c == '\'' ? '"' : c);
    }
    if (binary) {
        const uint32_t second[2] = {(uint32_t)chunk, 0x004E4942};
        memcpy(out + 20 + padded, second, sizeof second);
        memset(out + 28 + padded, 0, chunk);
        memcpy(out + 28 + padded, binary, binary_size);
    }
    return size;
}

static inline void write_glb(const char *json, const void *binary, size_t binary_size) {
    unsigned char *glb = malloc(strlen(json) + binary_size + 64);
    size_t size = make_glb(json, binary, binary_size, glb);
    write_bytes("test.glb", glb, size);
    free(glb);
}

static inline void write_gltf(const char *json) {
    char *text = strdup(json);
    for (char *c = text; *c; ++c) {
        if (*c == '\'') *c = '"';
    }
    write_bytes("test.gltf", text, strlen(text));
    free(text);
}

/* `out` has room for 4 characters for each 3 bytes begun, and the end. */
static inline void encode_base64(const unsigned char *bytes, size_t size, char *out) {
    static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < size ? bytes[i + k] : 0);
        for (size_t k = 0; k < 4; ++k) *out++ = i + k <= size ? alphabet[bits >> (18 - 6 * k) & 63] : '=';
    }
    *out = '\0';
}

/* The bytes that most tests share, and accessors for them: 0 positions, 1 to 3 indices of 4, 2 and 1 bytes,
 * 4 normals, 5 uvs. */
typedef struct triangle_data {
    float positions[3][3];
    uint32_t indices[3];
    uint16_t short_indices[4];
    uint8_t byte_indices[4];
    float normals[3][3];
    float uvs[3][2];
} triangle_data;

static const triangle_data triangle = {.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}},
                                       .indices = {0, 1, 2},
                                       .short_indices = {2, 0, 1},
                                       .byte_indices = {1, 2, 0},
                                       .normals = {{0, 0, 1}, {0, 0, 1}, {0, 1, 0}},
                                       .uvs = {{0, 0}, {1, 0}, {0, 1}}};

#define ASSET "'asset':{'version':'2.0'}"
#define VIEWS                                                                                                \
    "'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':12},"              \
    "{'buffer':0,'byteOffset':48,'byteLength':6},{'buffer':0,'byteOffset':56,'byteLength':3},"               \
    "{'buffer':0,'byteOffset':60,'byteLength':36},{'buffer':0,'byteOffset':96,'byteLength':24}]"
#define ACCESSORS                                                                                            \
    "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3},"                            \
    "{'bufferView':1,'componentType':5125,'type':'SCALAR','count':3},"                                       \
    "{'bufferView':2,'componentType':5123,'type':'SCALAR','count':3},"                                       \
    "{'bufferView':3,'componentType':5121,'type':'SCALAR','count':3},"                                       \
    "{'bufferView':4,'componentType':5126,'type':'VEC3','count':3},"                                         \
    "{'bufferView':5,'componentType':5126,'type':'VEC2','count':3}]"
#define DATA "'buffers':[{'byteLength':120}]," VIEWS "," ACCESSORS
#define TRIANGLE_MESH "'meshes':[{'name':'tri','primitives':[{'attributes':{'POSITION':0},'indices':1}]}]"
/* A whole file from its tail, and one that shows one mesh in one node. */
#define WITH_DATA(tail) "{" ASSET "," DATA "," tail "}"
#define SHOWN(meshes) WITH_DATA(meshes ",'nodes':[{'mesh':0}],'scenes':[{'nodes':[0]}],'scene':0")

static inline void write_triangle(const char *json) { write_glb(json, &triangle, sizeof triangle); }

/* Reads file_path into a scene of its own. */
static inline fathom_scene *read_with(const read_mesh_options *options) {
    fathom_scene *scene = new_scene(context);
    forget_warnings();
    assert_ok(context, read_gltf(scene, FATHOM_ROOT, file_path, options));
    return scene;
}

static inline fathom_scene *read_file(void) {
    const read_mesh_options options = {.material = FATHOM_NONE, .surroundings = true};
    return read_with(&options);
}

static inline fathom_scene *read_triangle(const char *json) {
    write_triangle(json);
    return read_file();
}

/* Corner c of triangle t of mesh m. */
static inline vec3_f64 corner(const fathom_scene *scene, size_t m, uint32_t t, int c) {
    const fathom_mesh *mesh = &scene->meshes.items[m];
    return widen(load_f32(mesh_vertex(mesh, mesh->indices[t * 3 + (uint32_t)c])));
}

#define assert_vec(v, ex, ey, ez, tolerance)                                                                 \
    do {                                                                                                     \
        vec3_f64 vec_v = (v);                                                                                \
        assert_near(vec_v.x, (ex), (tolerance));                                                             \
        assert_near(vec_v.y, (ey), (tolerance));                                                             \
        assert_near(vec_v.z, (ez), (tolerance));                                                             \
    } while (0)
