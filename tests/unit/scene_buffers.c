/* What the arrays of meshes take, and what of mapped files is let go. */
#include "base/memory.h"
#include "scene/scene.h"
#include "unit_scene.h"

#include <fathom/read.h>
#include <unistd.h>

#define VERTICES 5u
#define ROW 8u /* floats: position, normal, uv */

static uint64_t bytes_of(unsigned which) {
    uint64_t bytes;
    assert_ok(context, scene_buffer_bytes(scene, which, &bytes));
    return bytes;
}

static const uint32_t indices[6] = {0, 1, 2, 2, 3, 4};
static float rows[VERTICES * ROW];
static float apart[VERTICES * ROW];

static fathom_mesh mesh_of(const float *positions, const float *normals, const float *uvs,
                           size_t strides[3]) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = VERTICES, mesh.position_stride = strides[0];
    mesh.normals = normals, mesh.normal_count = VERTICES, mesh.normal_stride = strides[1];
    mesh.uvs = uvs, mesh.uv_count = VERTICES, mesh.uv_stride = strides[2];
    mesh.indices = indices, mesh.triangle_count = 2;
    return mesh;
}

static void add(const fathom_mesh *mesh) {
    assert_ok(context, fathom_scene_add_mesh_shared(scene, FATHOM_ROOT, mesh, NULL));
}

UNIT_TEST(arrays_apart_are_summed) {
    size_t strides[3] = {12, 12, 8};
    fathom_mesh mesh = mesh_of(apart, apart + 3 * VERTICES, apart + 6 * VERTICES, strides);
    add(&mesh);
    assert_int_equal(bytes_of(SCENE_TRACED), VERTICES * 12 + sizeof indices);
    assert_int_equal(bytes_of(SCENE_SHADED), VERTICES * 12);
    assert_int_equal(bytes_of(SCENE_UNREAD), VERTICES * 8);
    assert_int_equal(bytes_of(SCENE_BUFFERS), VERTICES * 32 + sizeof indices);
    add(&mesh); /* over the same arrays */
    assert_int_equal(bytes_of(SCENE_BUFFERS), VERTICES * 32 + sizeof indices);
}

UNIT_TEST(rows_are_counted_once) {
    size_t strides[3] = {32, 32, 32};
    fathom_mesh mesh = mesh_of(rows, rows + 3, rows + 6, strides);
    add(&mesh);
    assert_int_equal(bytes_of(SCENE_BUFFERS), sizeof rows + sizeof indices);
    /* From the first position to the last, what lies between included. */
    assert_int_equal(bytes_of(SCENE_TRACED), sizeof rows - 20 + sizeof indices);
}

/* ---- mapped files ---- */

/* Linux keeps up to 64 pages a thread out of the sums it tells; 32 threads' worth. */
#define UNSURE ((size_t)8 << 20)

static double sum_of(const float *values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += (double)values[i] * (double)(i % 7);
    return sum;
}

static const file_map *the_map(void) {
    for (size_t i = 0; i < scene->blobs.count; ++i) {
        if (scene->blobs.items[i].map.size) return &scene->blobs.items[i].map;
    }
    fail_msg("the scene has no mapped file");
    return NULL;
}

static void check_file(const char *extension) {
    const char *path = unit_text("/tmp/fathom-buffers-%ld.%s", (long)getpid(), extension);
    fathom_generate_options options = default_generate_options();
    options.triangles = 2000000;
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    assert_ok(context, fathom_scene_write(scene, path));
    scene = scene_of_file(context, path);
    remove(path);
    const fathom_mesh *mesh = &scene->meshes.items[0];
    size_t floats = (mesh->vertex_count - 1) * mesh->position_stride / 4;
    double positions = sum_of(mesh->positions, floats);
    double normals = sum_of(mesh->normals, (mesh->normal_count - 1) * mesh->normal_stride / 4);
    const file_map *map = the_map();
    size_t before = memory_resident(), expected = map->size;
    assert_ok(context, scene_rest_files(scene, scene->meshes.items, scene->meshes.count));
    size_t after = memory_resident();
    /* All of the file, which reading looked at, but what is traced, where that lies in it. */
    const unsigned char *traced = (const unsigned char *)mesh->indices;
    if (traced >= map->bytes && traced < map->bytes + map->size)
        expected -= (size_t)mesh->triangle_count * 12;
    expected -= mesh->vertex_count * mesh->position_stride;
    assert_true(expected > UNSURE);
    assert_true(before - after + UNSURE > expected);
    assert_true(before - after < expected + UNSURE);
    assert_true(sum_of(mesh->positions, floats) == positions);
    assert_true(sum_of(mesh->normals, (mesh->normal_count - 1) * mesh->normal_stride / 4) == normals);
}

UNIT_TEST(glb_keeps_what_is_traced) { check_file("glb"); }

UNIT_TEST(ply_keeps_what_is_traced) { check_file("ply"); }

/* Memory that is no file's would come back as zeros. */
UNIT_TEST(other_memory_stays) {
    fathom_generate_options options = default_generate_options();
    options.triangles = 200000;
    assert_ok(context, fathom_scene_generate(scene, FATHOM_ROOT, &options));
    const fathom_mesh *mesh = &scene->meshes.items[0];
    double before = sum_of(mesh->normals, 3 * (size_t)mesh->normal_count);
    assert_ok(context, scene_rest_files(scene, scene->meshes.items, scene->meshes.count));
    assert_true(sum_of(mesh->normals, 3 * (size_t)mesh->normal_count) == before && before != 0);
}

int main(void) { return unit_main_each(open_scene, NULL); }
