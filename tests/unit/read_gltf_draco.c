/* Meshes compressed by Draco: what is unpacked is what was packed, and broken data does no harm. */
#include "gltf_build.h"
#include "image/helper/helper.h"

#include <limits.h>
#include <signal.h>
#include <sys/resource.h>

/* Two triangles (0,0,0) (1,0,0) (0,1,0) and (0,1,0) (1,0,0) (1,1,2), with colours of bytes: the corner
 * (1,1,2) has 51, 102, 153, 255. By Draco 1.5.5, edgebreaker, positions of 11 bits. */
static const uint8_t draco[] = {
    0x44, 0x52, 0x41, 0x43, 0x4f, 0x02, 0x02, 0x01, 0x01, 0x00, 0x00, 0x00, 0x04, 0x02, 0x01, 0x02, 0x00,
    0x00, 0x01, 0x1f, 0xff, 0x01, 0x11, 0xff, 0x01, 0x11, 0x02, 0xff, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01,
    0x00, 0x09, 0x03, 0x00, 0x00, 0x02, 0x01, 0x02, 0x02, 0x04, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x00,
    0x0c, 0x03, 0x01, 0x10, 0x23, 0x01, 0x30, 0x03, 0x00, 0x28, 0x82, 0x00, 0xf8, 0x3f, 0x00, 0xfe, 0xff,
    0x7f, 0x00, 0x00, 0xe0, 0xff, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0x07, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x0b, 0x01, 0x01,
    0x01, 0x00, 0x09, 0x03, 0x01, 0x10, 0x01, 0x10, 0x13, 0x01, 0x20, 0x03, 0x00, 0x50, 0x91, 0x4c, 0x62,
    0xe6, 0xdc, 0x0c, 0x10, 0xe0, 0xbc, 0x0c, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00};

#define DRACO_MESH                                                                                           \
    "{" ASSET                                                                                                \
    ",'extensionsRequired':['KHR_draco_mesh_compression'],'buffers':[{'byteLength':%zu}],'bufferViews':[{"   \
    "'buffer':0,'byteLength':%zu}],'accessors':[{'componentType':5126,'type':'VEC3','count':%d},{'"          \
    "componentType':"                                                                                        \
    "5121,'normalized':true,'type':'VEC4','count':4},{'componentType':5125,'type':'SCALAR','count':6}],'"    \
    "meshes':[{"                                                                                             \
    "'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1},'indices':2,'extensions':{"                      \
    "'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{'POSITION':%d,'COLOR_0':1}}}}]}]}"

static void write_draco(const void *bytes, size_t size, int points, int id) {
    write_glb(unit_text(DRACO_MESH, size, size, points, id), bytes, size);
}

static bool has_draco(void) {
    char path[PATH_MAX];
    return helper_find_file("fathom/fathom-draco", path);
}

/* Reads file_path, whose mesh has the corner (1,1,2) with its colour. */
static void assert_corner(void) {
    fathom_scene *scene = read_file();
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->color_channels, 3);
    int found = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        const float *p = mesh_vertex(mesh, i);
        /* Half a step of the largest side, 2, in 2^11 - 1 steps. */
        if (fabsf(p[2] - 2) > 1 / 2047.0f) continue;
        ++found;
        const float *c = mesh_row(mesh->colors, mesh->color_stride, i);
        assert_vec(widen(load_f32(p)), 1, 1, 2, 1 / 2047.0);
        assert_vec(widen(load_f32(c)), 0.2, 0.4, 0.6, 1e-7);
    }
    assert_int_equal(found, 1);
}

UNIT_TEST(draco_unpacks_to_what_was_packed) {
    if (!has_draco()) skip();
    write_draco(draco, sizeof draco, 4, 0);
    assert_corner();
}

/* Bytes of the data: whether colours are already divided by 255; the largest side of the positions, a float.
 */
enum { NORMALIZED_AT = 44, SIDE_AT = 95 };

/* Meshes of one primitive each, of sides 2, 4, 6… and with the same accessors, which only name counts and
 * types. All but the last have the whole data. */
static void write_draco_meshes(int count, size_t last_size) {
    uint8_t bytes[16 * sizeof draco];
    char json[8192];
    int at = snprintf(
        json, sizeof json,
        "{" ASSET ",'extensionsRequired':['KHR_draco_mesh_compression'],'buffers':[{'byteLength':%zu}],"
        "'accessors':[{'componentType':5126,'type':'VEC3','count':4},{'componentType':5125,'type':"
        "'SCALAR','count':6}],'bufferViews':[",
        (size_t)count * sizeof draco);
    for (int i = 0; i < count; ++i) {
        const float side = 2 * (float)(i + 1);
        memcpy(bytes + (size_t)i * sizeof draco, draco, sizeof draco);
        memcpy(bytes + (size_t)i * sizeof draco + SIDE_AT, &side, sizeof side);
        at +=
            snprintf(json + at, sizeof json - (size_t)at, "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu}",
                     i ? "," : "", (size_t)i * sizeof draco, i + 1 < count ? sizeof draco : last_size);
    }
    at += snprintf(json + at, sizeof json - (size_t)at, "],'meshes':[");
    for (int i = 0; i < count; ++i)
        at += snprintf(json + at, sizeof json - (size_t)at,
                       "%s{'primitives':[{'attributes':{'POSITION':0},'indices':1,'extensions':{"
                       "'KHR_draco_mesh_compression':{'bufferView':%d,'attributes':{'POSITION':0}}}}]}",
                       i ? "," : "", i);
    snprintf(json + at, sizeof json - (size_t)at, "]}");
    write_glb(json, bytes, (size_t)count * sizeof draco);
}

UNIT_TEST(draco_meshes_unpack_together_to_their_own_data) {
    if (!has_draco()) skip();
    fathom_context_set_threads(context, 3);
    write_draco_meshes(8, sizeof draco);
    fathom_scene *scene = read_file();
    assert_int_equal(scene->meshes.count, 8);
    for (size_t i = 0; i < 8; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        float most = 0;
        assert_int_equal(mesh->triangle_count, 2);
        for (uint32_t v = 0; v < mesh->vertex_count; ++v) most = fmaxf(most, mesh_vertex(mesh, v)[2]);
        /* 2047 steps of side / 2047: a few roundings. */
        assert_near(most / (float)(i + 1), 2, 1e-6);
    }
}

/* Colours of bytes are divided by 255, whether the data says so, the accessor or neither. */
UNIT_TEST(draco_colours_of_bytes_are_divided_once) {
    if (!has_draco()) skip();
    for (unsigned i = 0; i < 4; ++i) {
        uint8_t bytes[sizeof draco];
        memcpy(bytes, draco, sizeof draco);
        bytes[NORMALIZED_AT] = i & 1;
        const char *json = unit_text(DRACO_MESH, sizeof bytes, sizeof bytes, 4, 0);
        if (i & 2) memset(strstr(json, "'normalized':true,"), ' ', 18);
        write_glb(json, bytes, sizeof bytes);
        assert_corner();
        assert_int_equal(warning_count, i & 2 ? 1 : 0);
    }
}

/* A packed primitive, one of the same accessors that is not packed, and both once more; then one of an
 * accessor that has no data of its own. */
UNIT_TEST(other_primitives_have_the_accessors_own_data) {
    static const uint32_t corners[6] = {0, 1, 2, 2, 1, 3};
    static const float own[12] = {0, 0, 7, 3, 0, 7, 0, 3, 7, 3, 3, 7};
    uint8_t bytes[sizeof draco + 3 + sizeof own + sizeof corners] = {0};
    char json[4096];
    if (!has_draco()) skip();
    const size_t at = (sizeof draco + 3) / 4 * 4;
    memcpy(bytes, draco, sizeof draco);
    memcpy(bytes + at, own, sizeof own);
    memcpy(bytes + at + sizeof own, corners, sizeof corners);
#define PACKED(points)                                                                                       \
    "{'attributes':{'POSITION':" points "},'indices':1,'extensions':{'KHR_draco_mesh_compression':{"         \
    "'bufferView':0,'attributes':{'POSITION':0}}}}"
#define PLAIN(points) "{'attributes':{'POSITION':" points "},'indices':1}"
    snprintf(
        json, sizeof json,
        "{" ASSET ",'extensionsRequired':['KHR_draco_mesh_compression'],'buffers':[{'byteLength':%zu}],"
        "'bufferViews':[{'buffer':0,'byteLength':%zu},{'buffer':0,'byteOffset':%zu,'byteLength':48},{"
        "'buffer':0,'byteOffset':%zu,'byteLength':24}],'accessors':[{'bufferView':1,'componentType':5126,"
        "'type':'VEC3','count':4},{'bufferView':2,'componentType':5125,'type':'SCALAR','count':6},{"
        "'componentType':5126,'type':'VEC3','count':4}],'meshes':[{'primitives':[" PACKED("0") "," PLAIN(
            "0") "," PACKED("0") "," PLAIN("0") "," PACKED("2") "," PLAIN("2") "]}]}",
        at + 72, sizeof draco, at, at + 48);
    write_glb(json, bytes, at + 72);
    fathom_scene *scene = read_file();
    static const float highest[] = {2, 7, 2, 7, 2, 0};
    assert_int_equal(scene->meshes.count, 6);
    for (size_t i = 0; i < 6; ++i) {
        float most = 0;
        for (uint32_t v = 0; v < 4; ++v) most = fmaxf(most, mesh_vertex(&scene->meshes.items[i], v)[2]);
        /* As above, half a step of Draco's positions; the others are in the file. */
        assert_near((double)most, (double)highest[i], i % 2 ? 0 : 1 / 2047.0);
    }
}

/* Every cut and many a changed byte: a mesh comes out, or one message; the process lives. */
UNIT_TEST(broken_draco_is_refused) {
    if (!has_draco()) skip();
    write_draco_meshes(3, sizeof draco / 2);
    assert_bad_input(
        "meshes[2].primitives[0].extensions.KHR_draco_mesh_compression: cannot be unpacked by Draco: ");
    for (size_t cut = 1; cut < sizeof draco - 3; cut += 16) {
        write_draco(draco, cut, 4, 0);
        assert_bad_input("KHR_draco_mesh_compression: cannot be unpacked by Draco: ");
    }
    for (size_t at = 5; at < sizeof draco; at += 9) {
        uint8_t changed[sizeof draco];
        fathom_scene *scene;
        fathom_read_options asked = default_read_options();
        memcpy(changed, draco, sizeof draco);
        changed[at] ^= 0x55;
        write_draco(changed, sizeof changed, 4, 0);
        const fathom_status status = read_asked(&asked, &scene);
        assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
    }
    write_draco(draco, sizeof draco, 5, 0);
    assert_bad_input("is accessors[0] of 5 × 3 numbers; the compressed data has 4 × 3");
    write_draco(draco, sizeof draco, 4, 7);
    assert_bad_input("attributes.POSITION: is 7; the data has no such attribute");
}

/* Writes the mesh with one piece of its JSON replaced. */
static void assert_changed_is_refused(const char *from, const char *to, const char *text) {
    const char *json = unit_text(DRACO_MESH, sizeof draco, sizeof draco, 4, 0);
    char *at = strstr(json, from);
    assert_non_null(at);
    write_glb(unit_text("%.*s%s%s", (int)(at - json), json, to, at + strlen(from)), draco, sizeof draco);
    assert_bad_input(text);
}

UNIT_TEST(draco_that_lacks_a_part_is_refused) {
    /* A mesh by Draco's sequential method, without a face or an attribute. */
    static const uint8_t empty[] = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0, 0, 0, 1, 0};
    if (!has_draco()) skip();
    assert_changed_is_refused(
        "'bufferView':0,'attributes'", "'attributes'",
        "KHR_draco_mesh_compression.bufferView: is missing; expected the compressed mesh");
    assert_changed_is_refused(
        "'indices':2,", "",
        "primitives[0].indices: is missing; expected an accessor that describes what is unpacked");
    assert_changed_is_refused(",'attributes':{'POSITION':0,'COLOR_0':1}}}}", "}}}",
                              "KHR_draco_mesh_compression.attributes: is missing; expected ");
    write_draco(empty, sizeof empty, 4, 0);
    assert_bad_input("KHR_draco_mesh_compression: unpacks to no triangles");
}

/* Reads while files can hold the data, but not what it unpacks to. */
static void assert_refused_for_size(const char *text) {
    struct rlimit given, small;
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &given), 0);
    small = given, small.rlim_cur = sizeof draco + 16;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const fathom_status status = read_asked(&asked, &scene);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &given), 0);
    assert_int_equal(status, FATHOM_BAD_INPUT);
    if (!strstr(fathom_context_message(context), text)) fail_msg("%s", fathom_context_message(context));
}

UNIT_TEST(draco_processes_that_fail_are_told) {
    if (!has_draco()) skip();
    write_draco(draco, sizeof draco, 4, 0);
    signal(SIGXFSZ, SIG_DFL); /* who starts the test may ignore it */
    assert_refused_for_size("cannot be unpacked: Draco was ended by SIGXFSZ; the data is broken");
    signal(SIGXFSZ, SIG_IGN);
    assert_refused_for_size("cannot be unpacked by Draco: what it unpacks to cannot be kept: File too");
    signal(SIGXFSZ, SIG_DFL);
}

int main(void) { return unit_main(open_folder, remove_folder); }
