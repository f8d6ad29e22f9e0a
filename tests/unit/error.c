/* Every error names its place: file, line or byte, and field. */
#include "defaults.h"
#include "unit_folder.h"

#include <fathom/read.h>
#include <fathom/scene.h>

#define GOOD_OBJ "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"

/* Reads a file that is wrong and returns the error. */
static const fathom_error *error_of(const char *path) {
    fathom_scene *scene = NULL;
    assert_int_equal(fathom_scene_read(context, path, &scene), FATHOM_BAD_INPUT);
    assert_null(scene);
    const fathom_error *error = fathom_context_error(context);
    assert_int_equal(error->status, FATHOM_BAD_INPUT);
    return error;
}

static const fathom_error *error_in(const char *path, const char *text) {
    unit_write_file(path, text, strlen(text));
    const fathom_error *error = error_of(path);
    return error;
}

static void assert_place(const fathom_place *place, const char *file, size_t line, const char *field) {
    assert_string_equal(place->file, file);
    assert_int_equal(place->line, line);
    assert_string_equal(place->field, field);
}

static void assert_message(const char *format, ...) {
    char expected[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(expected, sizeof expected, format, args);
    va_end(args);
    assert_string_equal(fathom_context_message(context), expected);
}

UNIT_TEST(no_error_before_a_call_fails) {
    fathom_context *fresh;
    assert_int_equal(fathom_context_create(&fresh), FATHOM_OK);
    const fathom_context *contexts[] = {fresh, NULL};
    for (int i = 0; i < 2; ++i) {
        const fathom_error *error = fathom_context_error(contexts[i]);
        assert_int_equal(error->status, FATHOM_OK);
        assert_string_equal(error->text, "");
        assert_place(error->place, "", 0, "");
        assert_null(error->place->within);
        assert_string_equal(fathom_context_message(contexts[i]), "");
    }
    fathom_context_destroy(fresh);
}

UNIT_TEST(argument_errors_name_the_field) {
    fathom_scene *scene;
    fathom_sphere sphere = default_sphere();
    assert_ok(context, fathom_scene_create(context, &scene));
    sphere.radius = -1;
    assert_int_equal(fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL), FATHOM_BAD_INPUT);
    const fathom_error *error = fathom_context_error(context);
    assert_place(error->place, "", 0, "radius");
    assert_string_equal(error->text, "expected a number > 0, found -1");
    assert_message("radius: %s", error->text);

    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1};
    const uint32_t indices[3] = {0, 1, 5};
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = 3, mesh.indices = indices, mesh.triangle_count = 1;
    assert_int_equal(fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL), FATHOM_BAD_INPUT);
    assert_place(fathom_context_error(context)->place, "", 0, "indices[2]");

    assert_int_equal(fathom_scene_add_sphere(scene, FATHOM_ROOT, NULL, NULL), FATHOM_BAD_USAGE);
    assert_int_equal(fathom_context_error(context)->status, FATHOM_BAD_USAGE);
    assert_place(fathom_context_error(context)->place, "", 0, "sphere");
    fathom_scene_destroy(scene);
}

UNIT_TEST(json_errors_name_line_and_field) {
    const char *path = in_folder("a.json");
    const fathom_error *error =
        error_in(path, "{\"objects\": [\n{\"type\": \"sphere\", \"center\": [0, 0, 0],\n\"radius\": -1}]}");
    assert_place(error->place, path, 3, "objects[0].radius");
    assert_false(error->place->has_byte);
    assert_null(error->place->within);
    assert_message("%s:3: objects[0].radius: %s", path, error->text);
}

UNIT_TEST(json_syntax_errors_name_line_and_column) {
    const char *path = in_folder("a.json");
    const fathom_error *error = error_in(path, "{\n  \"objects\": [}");
    assert_place(error->place, path, 2, "");
    assert_int_equal(error->place->column, 15);
    assert_message("%s:2:15: %s", path, error->text);
}

/* The scene finds it, not the reader; the document has the field under the same name. */
UNIT_TEST(fields_of_calls_join_the_path_in_json) {
    const char *path = in_folder("a.json");
    const fathom_error *error =
        error_in(path, "{\"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1}],\n"
                       "\"lights\": [{\"type\": \"directional\",\n\"direction\": [0, 0, 0]}]}");
    assert_place(error->place, path, 3, "lights[0].direction");
}

UNIT_TEST(obj_errors_name_line_and_statement) {
    const char *path = in_folder("a.obj");
    const fathom_error *error = error_in(path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    assert_place(error->place, path, 4, "f");
    assert_message("%s:4: f: %s", path, error->text);
    assert_place(error_in(path, "v 0 0 0\nv 1 none 0\n" GOOD_OBJ)->place, path, 2, "v");
}

UNIT_TEST(ply_text_errors_name_line_and_property) {
    const char *path = in_folder("a.ply");
#define HEADER(FORMAT)                                                                                       \
    "ply\nformat " FORMAT " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"   \
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    const fathom_error *error = error_in(path, HEADER("ascii") "0 0 0\n1 0 0\n0 none 0\n3 0 1 2\n");
    assert_place(error->place, path, 12, "y");
    assert_place(error_in(path, HEADER("ascii") "0 0 0\n1 0 0\n0 1 no\n3 0 1 2\n")->place, path, 12, "z");
    assert_place(error_in(path, "ply\nformat ascii 2.0\n")->place, path, 2, "format");
    assert_place(error_in(path, "ply\nformat ascii 1.0\nelement vertex many\n")->place, path, 3,
                 "element vertex");
}

UNIT_TEST(ply_byte_errors_name_byte_and_element) {
    const char *path = in_folder("a.ply");
    char bytes[512];
    const size_t header = strlen(HEADER("binary_little_endian"));
    const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memcpy(bytes, HEADER("binary_little_endian"), header);
    memcpy(bytes + header, vertices, sizeof vertices);
    memcpy(bytes + header + sizeof vertices, "\3\0\0\0\0\1\0\0\0\7\0\0\0", 13);
    unit_write_file(path, bytes, header + sizeof vertices + 13);
    const fathom_error *error = error_of(path);
    assert_place(error->place, path, 0, "face");
    assert_true(error->place->has_byte);
    assert_int_equal(error->place->byte, header + sizeof vertices + 9); /* where the index stands */
    assert_message("%s: at byte %zu: face: %s", path, header + sizeof vertices + 9, error->text);
}

#define GLTF "{\"asset\": {\"version\": \"2.0\"},\n\"meshes\": [\n{\"primitives\": 3}]}"

UNIT_TEST(gltf_errors_name_line_and_field) {
    const char *path = in_folder("a.gltf");
    const fathom_error *error = error_in(path, GLTF);
    assert_place(error->place, path, 3, "meshes[0].primitives");
    assert_message("%s:3: meshes[0].primitives: %s", path, error->text);
    error = error_in(path, "{\"asset\":\n {\"version\" 2}}");
    assert_place(error->place, path, 2, "");
    assert_true(error->place->column > 0);
}

UNIT_TEST(glb_errors_name_byte_and_field) {
    const char *path = in_folder("a.glb");
    const uint32_t size = sizeof GLTF - 1, head[5] = {0x46546C67, 2, 20 + size, size, 0x4E4F534A};
    char bytes[512];
    memcpy(bytes, head, 20);
    memcpy(bytes + 20, GLTF, size);
    unit_write_file(path, bytes, 20 + size);
    const fathom_error *error = error_of(path);
    const size_t byte = 20 + (size_t)(strchr(GLTF, '3') - GLTF);
    assert_place(error->place, path, 0, "meshes[0].primitives");
    assert_true(error->place->has_byte);
    assert_int_equal(error->place->byte, byte);
    assert_message("%s: at byte %zu: meshes[0].primitives: %s", path, byte, error->text);

    error = error_in(path, "glTF\1");
    assert_place(error->place, path, 0, "");
    assert_true(error->place->has_byte);
    assert_int_equal(error->place->byte, 5);
    assert_message("%s: at byte 5: %s", path, error->text);
}

/* The error is in the mesh; `within` is the object that names it. */
UNIT_TEST(errors_of_named_files_tell_who_names_them) {
    const char *scene = in_folder("a.json"), *mesh = in_folder("bad.obj");
    unit_write_file(mesh, "v 0 0 0\nf 1 1 2\n", 16);
    const fathom_error *error =
        error_in(scene, "{\"objects\": [\n{\"type\": \"mesh\",\n\"file\": \"bad.obj\"}]}");
    assert_place(error->place, mesh, 2, "f");
    assert_non_null(error->place->within);
    assert_place(error->place->within, scene, 3, "objects[0].file");
    assert_null(error->place->within->within);
    assert_message("%s:3: objects[0].file: %s:2: f: %s", scene, mesh, error->text);
}

UNIT_TEST(missing_files_are_named) {
    const char *path = in_folder("none.obj");
    fathom_scene *scene;
    assert_int_equal(fathom_scene_read(context, path, &scene), FATHOM_BAD_INPUT);
    assert_place(fathom_context_error(context)->place, path, 0, "");
    assert_string_equal(fathom_context_error(context)->text, "No such file or directory");
}

/* A terminal must not obey the name of a file; whoever opens the file needs its bytes. */
UNIT_TEST(only_the_file_may_hold_control_characters) {
    const char *path = in_folder("a\033[2J.json");
    const fathom_error *error = error_in(path, "{\"\\u001b[2J\": 1}");
    assert_string_equal(error->place->file, path);
    assert_null(strchr(error->place->field, '\033'));
    assert_null(strchr(error->text, '\033'));
    assert_null(strchr(fathom_context_message(context), '\033'));
}

UNIT_TEST(success_keeps_the_last_error) {
    const char *bad = in_folder("a.json"), *good = in_folder("a.obj");
    error_in(bad, "{");
    unit_write_file(good, GOOD_OBJ, strlen(GOOD_OBJ));
    fathom_scene *scene;
    assert_ok(context, fathom_scene_read(context, good, &scene));
    fathom_scene_destroy(scene);
    assert_string_equal(fathom_context_error(context)->place->file, bad);
}

int main(void) { return unit_main(open_folder, remove_folder); }
