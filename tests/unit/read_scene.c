/* Files of any format as whole scenes: told apart by the extension, named, completed, checked. */
#include "mesh_file.h"

static void expect_error(const char *name, const char *text, const char *message) {
    fathom_scene *scene = (fathom_scene *)(void *)mesh_folder;
    const char *path = text ? mesh_write(name, text, strlen(text)) : mesh_path(name);
    assert_fails(context, fathom_scene_read(context, path, &scene), FATHOM_BAD_INPUT, message);
    assert_null(scene);
}

static void by_extension(void **state) {
    (void)state;
    expect_error("a", "x", "the name has no extension; expected .json, .obj, .ply, .gltf or .glb");
    expect_error("a.stl", "x", "a.stl: the extension .stl is not known");
    expect_error("a.obj", NULL, "a.obj: No such file or directory");
    expect_error("a.PLY", "x", "a.PLY:1: expected \"ply\"");
    expect_error("a.glb", "x", "a.glb");
    expect_error("a.json", "x", "a.json");
}

#define PYRAMID "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

/* A bare model becomes a scene that can be rendered: with a name, a camera that has all of it in view,
 * lights. */
static void bare_model(void **state) {
    (void)state;
    fathom_scene *scene;
    const char *path = mesh_write("thing.v2.obj", PYRAMID, strlen(PYRAMID));
    assert_ok(context, fathom_scene_read(context, path, &scene));
    assert_string_equal(scene->name, "thing.v2");
    assert_true(scene->lights.count > 0);
    for (uint32_t i = 0; i < 4; ++i) {
        const fathom_camera *c = &scene->camera;
        vec3_f64 p = sub_f64(mesh_point(mesh_at(scene, 0), i), load_f64(c->origin));
        double depth = -dot_f64(p, load_f64(c->z));
        assert_true(depth > 0);
        assert_true(fabs(dot_f64(p, load_f64(c->y))) * c->d <= depth * 0.5 * c->h);
    }
    fathom_scene_destroy(scene);
}

/* Any format's mesh may be asked for by name; scenes are no meshes. */
static void meshes(void **state) {
    (void)state;
    fathom_status status;
    const read_mesh_options options = {.material = FATHOM_NONE};
    fathom_scene *scene =
        mesh_try(read_mesh, mesh_write("a.OBJ", PYRAMID, strlen(PYRAMID)), options, &status);
    assert_ok(context, status);
    assert_int_equal(mesh_at(scene, 0)->triangle_count, 4);
    fathom_scene_destroy(scene);
    assert_null(mesh_try(read_mesh, mesh_write("a.json", "{}", 2), options, &status));
    assert_fails(context, status, FATHOM_BAD_INPUT,
                 "the extension .json is not known; expected .obj, .ply, .gltf or .glb");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_extension),
        cmocka_unit_test(bare_model),
        cmocka_unit_test(meshes),
    };
    return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
