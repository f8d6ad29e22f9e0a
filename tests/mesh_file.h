/* For the tests of OBJ, MTL and PLY: files in a folder of their own, scenes read from them, warnings kept. */
#pragma once

#include "owned.h"
#include "read/read.h"
#include "unit_folder.h"

static inline const char *mesh_write(const char *name, const void *bytes, size_t size) {
    const char *path = in_folder(name);
    unit_write_file(path, bytes, size);
    return path;
}

typedef fathom_status (*mesh_reader)(fathom_scene *scene, fathom_id group, const char *path,
                                     const read_mesh_options *options);

/* NULL after a failure, whose message the context has. */
static inline fathom_scene *mesh_try(mesh_reader reader, const char *path, read_mesh_options options,
                                     fathom_status *status) {
    fathom_scene *scene = new_scene(context);
    forget_warnings();
    *status = reader(scene, FATHOM_ROOT, path, &options);
    return *status == FATHOM_OK ? scene : NULL;
}

/* Reads what is well formed. */
static inline fathom_scene *mesh_read(mesh_reader reader, const char *path, read_mesh_options options) {
    fathom_status status;
    fathom_scene *scene = mesh_try(reader, path, options, &status);
    assert_ok(context, status);
    return scene;
}

static inline const fathom_mesh *mesh_at(const fathom_scene *scene, size_t i) {
    assert_true(i < scene->meshes.count);
    return &scene->meshes.items[i];
}

/* Vertex i, origin included. */
static inline vec3_f64 mesh_point(const fathom_mesh *mesh, uint32_t i) {
    return add_f64(load_f64(mesh->origin), widen(load_f32(mesh_vertex(mesh, i))));
}

static inline void mesh_expect_point(const fathom_mesh *mesh, uint32_t i, double x, double y, double z) {
    vec3_f64 p = mesh_point(mesh, i);
    if (p.x != x || p.y != y || p.z != z) fail_msg("vertex %u is (%.17g, %.17g, %.17g)", i, p.x, p.y, p.z);
}

static inline void mesh_expect_indices(const uint32_t *found, const uint32_t *expected, size_t count) {
    assert_non_null(found);
    for (size_t i = 0; i < count; ++i) {
        if (found[i] != expected[i]) fail_msg("index %zu is %u, expected %u", i, found[i], expected[i]);
    }
}

/* The same numbers and indices, bit for bit. */
static inline void mesh_expect_equal(const fathom_mesh *a, const fathom_mesh *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->normal_count, b->normal_count);
    assert_int_equal(a->material, b->material);
    assert_memory_equal(a->origin, b->origin, sizeof a->origin);
    for (uint32_t i = 0; i < a->vertex_count; ++i) {
        const char *p = (const char *)a->positions + i * a->position_stride;
        assert_memory_equal(p, (const char *)b->positions + i * b->position_stride, 12);
    }
    size_t bytes = 12 * (size_t)a->triangle_count;
    assert_memory_equal(a->indices, b->indices, bytes);
    assert_true(!a->normal_indices == !b->normal_indices);
    if (a->normal_indices) assert_memory_equal(a->normal_indices, b->normal_indices, bytes);
    for (uint32_t i = 0; i < a->normal_count; ++i) {
        const char *n = (const char *)a->normals + i * a->normal_stride;
        assert_memory_equal(n, (const char *)b->normals + i * b->normal_stride, 12);
    }
}
