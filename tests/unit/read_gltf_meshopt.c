/* Compressed buffer views: what is unpacked is what was packed, by both names of the extension, and broken
 * data is refused. */
#include "gltf_build.h"

#if __has_include(<meshoptimizer.h>)
#include <meshoptimizer.h>

enum { VERTICES = 40 };

/* A grid, packed with the mode ATTRIBUTES, and its triangles with TRIANGLES. */
static void write_meshopt(size_t cut, const char *filter, int count) {
    float vertices[VERTICES][3];
    uint32_t indices[(VERTICES - 2) * 3];
    build b = {.size = 0};
    for (int i = 0; i < VERTICES; ++i)
        vertices[i][0] = (float)(i / 2), vertices[i][1] = (float)(i % 2), vertices[i][2] = 0;
    for (uint32_t i = 0; i < VERTICES - 2; ++i)
        indices[i * 3] = i, indices[i * 3 + 1] = i + 1 + i % 2, indices[i * 3 + 2] = i + 2 - i % 2;
    const size_t first =
                     meshopt_encodeVertexBuffer(b.bytes, 4096, vertices, VERTICES, sizeof *vertices) - cut,
                 second = meshopt_encodeIndexBuffer(b.bytes + 4096, 4096, indices, (VERTICES - 2) * 3);
    const char *json = unit_text(
        "{" ASSET
        ",'extensionsRequired':['EXT_meshopt_compression'],'buffers':[{'byteLength':8192},{'byteLength':"
        "900000}],'bufferViews':[{'buffer':1,'byteLength':480,'byteStride':12,'extensions':{"
        "'EXT_meshopt_compression':{'buffer':0,'byteLength':%zu,'byteStride':12,'count':%d,'mode':'"
        "ATTRIBUTES'"
        "%s}}},{'buffer':1,'byteLength':456,'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteOffset':"
        "4096,"
        "'byteLength':%zu,'byteStride':4,'count':114,'mode':'TRIANGLES'}}}],'accessors':[{'bufferView':0,"
        "'componentType':5126,'type':'VEC3','count':40},{'bufferView':1,'componentType':5125,'type':'SCALAR',"
        "'count':114}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
        first, count, filter, second);
    write_glb(json, b.bytes, 8192);
}

UNIT_TEST(meshopt_unpacks_to_what_was_packed) {
    write_meshopt(0, "", VERTICES);
    fathom_scene *scene = read_file();
    assert_int_equal(scene->meshes.items[0].triangle_count, VERTICES - 2);
    double area = 0;
    for (uint32_t t = 0; t < VERTICES - 2; ++t) {
        const vec3_f64 a = corner(scene, 0, t, 0);
        area += cross_f64(sub_f64(corner(scene, 0, t, 1), a), sub_f64(corner(scene, 0, t, 2), a)).z / 2;
    }
    assert_near(fabs(area), VERTICES / 2 - 1, 0);
}

/* Adds 4 elements, packed with a filter, as a view of the fallback buffer 1 and its accessor. */
static void put_filtered(build *b, const char *filter, const void *elements, size_t stride,
                         const char *accessor) {
    const size_t size =
        meshopt_encodeVertexBuffer(b->bytes + b->size, sizeof b->bytes - b->size, elements, 4, stride);
    const char *comma = b->count ? "," : "";
    snprintf(
        b->views + strlen(b->views), 512,
        "%s{'buffer':1,'byteLength':%zu,'byteStride':%zu,'extensions':{'EXT_meshopt_compression':{'buffer':0,"
        "'byteOffset':%zu,'byteLength':%zu,'byteStride':%zu,'count':4,'mode':'ATTRIBUTES','filter':'%s'}}}",
        comma, 4 * stride, stride, b->size, size, stride, filter);
    snprintf(b->accessors + strlen(b->accessors), 256, "%s{'bufferView':%d,'count':4,%s}", comma, b->count++,
             accessor);
    b->size += (size + 3) / 4 * 4;
}

/* A number of the filter EXPONENTIAL: a mantissa of 24 bits, an exponent of 8. */
#define EXPONENTIAL(mantissa, exponent) ((uint32_t)(exponent) << 24 | ((uint32_t)(mantissa)&0xffffff))

/* Numbers by the extension's equations. Octahedral: x and y, as fractions of the third. Quaternions: three
 * components as fractions of 1/sqrt(2) of the fourth number, without its last two bits, which name the
 * component that is missing. */
UNIT_TEST(meshopt_filters_follow_the_equations_of_the_extension) {
    build b = {.size = 0};
    const uint32_t points[4][3] = {{EXPONENTIAL(0, 0), EXPONENTIAL(0, 5), EXPONENTIAL(0, -9)},
                                   {EXPONENTIAL(3, -1), 0, 0},
                                   {0, EXPONENTIAL(-5, 2), 0},
                                   {EXPONENTIAL(1, 0), EXPONENTIAL(1, 0), EXPONENTIAL(-8388607, -20)}};
    const int8_t normals[4][4] = {{127, 0, 127, 0}, {0, -127, 127, 0}, {0, 0, 127, 0}, {127, 127, 127, 0}};
    const int16_t turns[4][4] = {
        {0, 0, 0, 32767},             /* (x, y, z) = 0, w is missing: none */
        {0, 0, 32767, 32767},         /* z = w = 1/sqrt(2): a quarter turn about z */
        {23170, 23170, 23170, 32764}, /* y = z = w = 1/2, x is missing: x to y to z to x */
        {0, 0, 0, 32766},             /* z is missing: half a turn about z */
    };
    static const double places[4][3] = {{1.5, 0, 0}, {0, 1.5, 0}, {0, 1.5, 0}, {-1.5, 0, 0}};
    static const float expected[4][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    put_filtered(&b, "EXPONENTIAL", points, sizeof *points, "'componentType':5126,'type':'VEC3'");
    put_filtered(&b, "OCTAHEDRAL", normals, sizeof *normals,
                 "'componentType':5120,'normalized':true,'type':'VEC3'");
    put_filtered(&b, "QUATERNION", turns, sizeof *turns,
                 "'componentType':5122,'normalized':true,'type':'VEC4'");
    const char *json = unit_text(
        "{" ASSET ",'buffers':[{'byteLength':%zu},{'byteLength':900}],'bufferViews':[%s],'accessors':[%s],"
        "'meshes':[{'primitives':[{'mode':5,'attributes':{'POSITION':0,'NORMAL':1}}]}],'nodes':[{'mesh':0,"
        "'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'ROTATION':2}}}}],'scenes':[{'nodes':[0]}]}",
        b.size, b.views, b.accessors);
    write_glb(json, b.bytes, b.size);
    fathom_scene *scene = read_file();
    const fathom_mesh *mesh = &scene->meshes.items[0];
    assert_vec(corner(scene, 0, 0, 1), 1.5, 0, 0, 0);
    assert_vec(corner(scene, 0, 0, 2), 0, -20, 0, 0);
    assert_vec(corner(scene, 0, 1, 1), 1, 1, -8388607 * 0x1p-20, 0);
    for (uint32_t i = 0; i < 4; ++i) {
        assert_memory_equal(mesh_row(mesh->normals, mesh->normal_stride, i), expected[i], sizeof expected[i]);
        affine_f64 map;
        affine_load(&map, scene->instances.items[i].transform);
        /* Components in steps of 1/32767 turn by at most two steps. */
        assert_vec(affine_point(&map, vec_f64(1.5, 0, 0)), places[i][0], places[i][1], places[i][2],
                   1.5 * 4 / 32767);
    }
}

UNIT_TEST(broken_meshopt_is_refused) {
    write_meshopt(1, "", VERTICES);
    assert_bad_input(
        "bufferViews[0].extensions.EXT_meshopt_compression: cannot be unpacked: the data is broken");
    write_meshopt(0, ",'filter':'OCTAHEDRAL'", VERTICES);
    assert_bad_input("byteStride: is 12, which does not go with the mode and the filter");
    write_meshopt(0, ",'filter':'BOXES'", VERTICES);
    assert_bad_input("filter: is \"BOXES\"; expected one that EXT_meshopt_compression has");
    write_meshopt(0, ",'filter':'QUATERNION'", VERTICES);
    assert_bad_input("byteStride: is 12, which does not go with the mode and the filter");
    write_meshopt(0, "", 16);
    assert_bad_input("EXT_meshopt_compression: cannot be unpacked");
}

/* ---- version 1 of ATTRIBUTES, which is not the library's ---- */

/* Differences of bytes, zigzag-coded and stored as they are, from an element of zeros. */
static size_t pack_plain(const unsigned char *elements, size_t count, size_t stride, unsigned char *out) {
    size_t size = 0;
    out[size++] = 0xa1;
    for (size_t k = 0; k < stride / 4; ++k) out[size++] = 0xff;
    for (size_t k = 0; k < stride; ++k)
        for (size_t i = 0; i < count; ++i) {
            const unsigned d = (elements[i * stride + k] - (i ? elements[(i - 1) * stride + k] : 0u)) & 255;
            out[size++] = (unsigned char)(d & 128 ? ~(d << 1) : d << 1);
        }
    const size_t tail = stride + stride / 4;
    memset(out + size, 0, tail < 24 ? 24 : tail);
    return size + (tail < 24 ? 24 : tail);
}

/* One triangle of three points and colours, by views of this extension. `b` has the streams. */
typedef struct colored {
    const char *name;
    build b;
    size_t points, colors; /* sizes; the colours begin at byte 128 */
} colored;

static void make_colored(colored *c, const char *name) {
    static const float points[3][3] = {{0, 0, 0}, {1.5f, 0, -7}, {0, 3, 0}};
    /* Of 8 bits, y, co, cg and alpha: red, green, blue. */
    static const int8_t colors[3][4] = {{64, 127, -64, -1}, {127, 0, 127, -1}, {64, -127, -64, -1}};
    *c = (colored){.name = name};
    c->points = pack_plain((const unsigned char *)points, 3, 12, c->b.bytes);
    c->colors = pack_plain((const unsigned char *)colors, 3, 4, c->b.bytes + 128);
}

static void write_colored(const colored *c) {
    const char *json = unit_text(
        "{" ASSET ",'extensionsRequired':['%s'],'extensionsUsed':['%s'],'buffers':[{'byteLength':512},{"
        "'byteLength':48,'extensions':{'%s':{'fallback':true}}}],'bufferViews':[{'buffer':1,'byteLength':"
        "36,'byteStride':12,'extensions':{'%s':{'buffer':0,'byteLength':%zu,'byteStride':12,'count':3,"
        "'mode':'ATTRIBUTES'}}},{'buffer':1,'byteOffset':36,'byteLength':12,'byteStride':4,'extensions':{"
        "'%s':{'buffer':0,'byteOffset':128,'byteLength':%zu,'byteStride':4,'count':3,'mode':"
        "'ATTRIBUTES','filter':'COLOR'}}}],'accessors':[{'bufferView':0,'componentType':5126,'type':"
        "'VEC3','count':3},{'bufferView':1,'componentType':5121,'normalized':true,'type':'VEC4','count':"
        "3}],'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1}}]}]}",
        c->name, c->name, c->name, c->name, c->points, c->name, c->colors);
    write_glb(json, c->b.bytes, 512);
}

UNIT_TEST(both_names_have_version_1_and_colours) {
    static const char *const names[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};
    for (size_t n = 0; n < 2; ++n) {
        colored c;
        make_colored(&c, names[n]);
        write_colored(&c);
        fathom_scene *scene = read_file();
        const fathom_mesh *mesh = &scene->meshes.items[0];
        assert_int_equal(warning_count, 0);
        assert_vec(corner(scene, 0, 0, 1), 1.5, 0, -7, 0);
        assert_vec(corner(scene, 0, 0, 2), 0, 3, 0, 0);
        for (uint32_t i = 0; i < 3; ++i) {
            const float *color = mesh_row(mesh->colors, mesh->color_stride, i);
            /* Red is y + co - cg = 255; green is y + cg = 254; blue is y - co - cg = 255. Others are 0 or 1.
             */
            for (uint32_t k = 0; k < 3; ++k) assert_near((double)color[k], k == i, 1 / 255.0 + 1e-7);
        }
    }
}

UNIT_TEST(broken_version_1_is_refused_with_its_view) {
    colored c;
    make_colored(&c, "KHR_meshopt_compression");
    --c.points;
    write_colored(&c);
    assert_bad_input("bufferViews[0].extensions.KHR_meshopt_compression: cannot be unpacked: the data ends "
                     "too early");
    c.points += 2;
    write_colored(&c);
    assert_bad_input(
        "bufferViews[0].extensions.KHR_meshopt_compression: cannot be unpacked: the data has more "
        "bytes than its elements need");
    make_colored(&c, "KHR_meshopt_compression");
    c.b.bytes[128 + 1 + 1 + 9] = 0; /* the first alpha */
    write_colored(&c);
    assert_bad_input("bufferViews[1].extensions.KHR_meshopt_compression: cannot be unpacked: the alpha of a "
                     "colour is 0 or 1");
}

/* Two triangles of a square. TRIANGLES: three new corners; then the edge from the first to the third and a
 * new corner. INDICES: the difference to the index before, four times it, or minus four times it minus 2. */
UNIT_TEST(indices_follow_the_specification) {
    static const unsigned char triangles[19] = {0xe1, 0xf0, 0x00}, indices[11] = {0xd1, 0, 4, 4, 6, 8, 4};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 2; ++i) {
        unsigned char bytes[68] = {0};
        float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
        memcpy(bytes, points, 48);
        memcpy(bytes + 48, i ? indices : triangles, i ? sizeof indices : sizeof triangles);
        const char *json = unit_text(
            "{" ASSET ",'buffers':[{'byteLength':68},{'byteLength':12}],'bufferViews':[{'buffer':0,"
            "'byteLength':48},{'buffer':1,'byteLength':12,'extensions':{'KHR_meshopt_compression':{'buffer':"
            "0,'byteOffset':48,'byteLength':%d,'byteStride':2,'count':6,'mode':'%s'}}}],'accessors':[{"
            "'bufferView':0,'componentType':5126,'type':'VEC3','count':4},{'bufferView':1,'componentType':"
            "5123,'type':'SCALAR','count':6}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},"
            "'indices':1}]}]}",
            i ? 11 : 19, i ? "INDICES" : "TRIANGLES");
        write_glb(json, bytes, sizeof bytes);
        fathom_scene *scene = read_file();
        assert_int_equal(scene->meshes.items[0].triangle_count, 2);
        assert_memory_equal(scene->meshes.items[0].indices, corners, sizeof corners);
    }
}

/* meshoptimizer 0.22 decodes a draft of version 1 whose first byte is 0xae; the answer must not depend on it.
 */
UNIT_TEST(versions_that_the_extension_does_not_have_are_refused) {
    for (unsigned first = 0; first < 256; ++first) {
        colored c;
        if (first == 0xa0 || first == 0xa1) continue;
        make_colored(&c, "KHR_meshopt_compression");
        c.b.bytes[0] = (unsigned char)first;
        write_colored(&c);
        assert_bad_input("cannot be unpacked: the data begins with neither 0xa0 nor 0xa1");
    }
}

#endif

int main(void) { return unit_main(open_folder, remove_folder); }
