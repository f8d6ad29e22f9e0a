/* A triangle with a material that goes through a file. */
#pragma once

#include "materials.h"
#include "scene/scene.h"
#include "written.h"

static const char *const formats[] = {"a.glb", "a.json"};
enum { GLB, JSON, FORMATS };

static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, uvs[6] = {0, 0, 1, 0, 0, 1};
static const uint32_t corners[3] = {0, 1, 2};

static inline fathom_mesh triangle(fathom_id material) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = 3, mesh.indices = corners, mesh.triangle_count = 1;
    mesh.uvs = uvs, mesh.uv_count = 3, mesh.material = material;
    return mesh;
}

static inline fathom_scene *wearing(const fathom_material *m, const fathom_texture *texture) {
    fathom_scene *scene = new_scene(context);
    fathom_id image;
    if (texture) assert_ok(context, fathom_scene_add_texture(scene, texture, &image));
    const fathom_id id = new_material(scene, "two words", m);
    const fathom_mesh mesh = triangle(id);
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    return scene;
}

/* Writes the scene and reads the file. */
static inline fathom_scene *through(const fathom_scene *scene, int format) {
    return written(scene, formats[format]);
}

static inline const fathom_material *worn(const fathom_scene *scene) {
    const fathom_id id = find_material(scene, "two words");
    assert_int_not_equal(id, FATHOM_NONE);
    return &scene->materials.items[id].value;
}
