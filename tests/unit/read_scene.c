/* Files of any format as whole scenes: told apart by the extension, named, completed, checked. */
#include "mesh_file.h"

#include "read/read.h"

#include <sys/stat.h>
#include <unistd.h>

static void expect_error(const char *name, const char *text, const char *message) {
    fathom_scene *scene = (fathom_scene *)(void *)folder;
    const char *path = text ? put_text(name, text) : in_folder(name);
    assert_fails(context, fathom_scene_read(context, path, &scene), FATHOM_BAD_INPUT, message);
    assert_null(scene);
}

UNIT_TEST(by_extension) {
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
UNIT_TEST(bare_model) {
    const char *path = put_text("thing.v2.obj", PYRAMID);
    fathom_scene *scene = scene_of_file(context, path);
    assert_string_equal(scene->name, "thing.v2");
    assert_true(scene->lights.count > 0);
    for (uint32_t i = 0; i < 4; ++i) {
        const fathom_camera *c = &scene->camera;
        vec3_f64 p = sub_f64(mesh_point(mesh_at(scene, 0), i), load_f64(c->origin));
        double depth = -dot_f64(p, load_f64(c->z));
        assert_true(depth > 0);
        assert_true(fabs(dot_f64(p, load_f64(c->y))) * c->d <= depth * 0.5 * c->h);
    }
}

/* By as many of the last parts of its name as lead to one; of Windows, too. */
UNIT_TEST(images_of_another_computer_are_found) {
    assert_int_equal(mkdir(in_folder("Maps"), 0700), 0);
    const char *wall = unit_text("%s", in_folder("Maps/Wall.png"));
    const char *base = unit_text("%s", in_folder("a.mtl"));
    unit_write_file(wall, "x", 1);
    fathom_scene *scene = new_scene(context);
    scene->top = base;
    static const char *const found[] = {"Maps/Wall.png", "maps\\wall.PNG",
                                        "C:\\my models\\house\\MAPS\\wall.png",
                                        "/home/joe/house/Maps/Wall.png"};
    static const char *const none[] = {"Wall.png", "C:\\house\\wall.png", "", "/", "..\\Maps\\roof.png"};
    for (size_t i = 0; i < sizeof found / sizeof *found; ++i) {
        char *path;
        assert_ok(context, read_image_beside(scene, base, found[i], &path));
        assert_non_null(path);
        assert_string_equal(path, wall);
        free(path);
    }
    for (size_t i = 0; i < sizeof none / sizeof *none; ++i) {
        char *path;
        assert_ok(context, read_image_beside(scene, base, none[i], &path));
        assert_null(path);
    }
    scene->top = NULL;
    assert_int_equal(unlink(wall) | rmdir(in_folder("Maps")), 0);
}

/* What is asked of a file that cannot give it is said. */
UNIT_TEST(what_a_file_lacks_is_not_passed_over) {
    fathom_scene *scene;
    const char *model = put_text("thing.v2.obj", PYRAMID);
    const char *file =
        put_text("a.json", "{\"camera\":{\"eye\":[0,0,5],\"target\":[0,0,0]},\"objects\":[{\"type\":"
                           "\"sphere\",\"center\":[0,0,0],\"radius\":1}]}");
    fathom_read_options options = default_read_options();
    options.camera = "front";
    const char *const both[] = {model, file};
    for (int i = 0; i < 2; ++i) {
        assert_fails(context, fathom_scene_read_with(context, both[i], &options, &scene), FATHOM_BAD_USAGE,
                     "has no cameras to choose \"front\" from");
        assert_null(scene);
    }
    options.camera = NULL, options.up = FATHOM_UP_Z;
    forget_warnings();
    assert_ok(context, fathom_scene_read_with(context, file, &options, &scene));
    expect_warning("a.json: has its own camera");
    fathom_scene_destroy(scene);
    options.choose_elevation = true;
    forget_warnings();
    assert_ok(context, fathom_scene_read_with(context, file, &options, &scene));
    expect_warning("so --azimuth and --elevation have no effect");
    fathom_scene_destroy(scene);
    options.elevation = 1.6;
    assert_fails(context, fathom_scene_read_with(context, file, &options, &scene), FATHOM_BAD_USAGE,
                 "elevation: is 1.6; expected radians");
    options.choose_elevation = false, options.choose_azimuth = true, options.azimuth = INFINITY;
    assert_fails(context, fathom_scene_read_with(context, file, &options, &scene), FATHOM_BAD_USAGE,
                 "azimuth: is inf; expected radians");
    options.choose_azimuth = false;
    forget_warnings();
    assert_ok(context, fathom_scene_read_with(context, model, &options, &scene));
    assert_string_equal(warned, "");
    assert_near(scene->camera.y[1] > scene->camera.y[2], 0, 0);
    fathom_scene_destroy(scene);
    options.up = (fathom_up)2;
    assert_fails(context, fathom_scene_read_with(context, model, &options, &scene), FATHOM_BAD_USAGE, "up: ");
    options.up = FATHOM_UP_Y, options.width = 5;
    assert_fails(context, fathom_scene_read_with(context, model, &options, &scene), FATHOM_BAD_USAGE,
                 "width, height: expected both or none, found 5 and 0");
}

/* A size that is asked for shapes the automatic camera's view, not the settings. */
UNIT_TEST(the_camera_fits_the_size_asked_for) {
    const char *path = put_text("thing.v2.obj", PYRAMID);
    double away[2];
    for (int i = 0; i < 2; ++i) {
        const fathom_read_options options = {
            .size = sizeof options, .width = i ? 100 : 900, .height = i ? 900 : 100};
        fathom_scene *scene;
        assert_ok(context, fathom_scene_read_with(context, path, &options, &scene));
        away[i] = length_f64(load_f64(scene->camera.origin));
        assert_int_equal(scene->settings.width, 1280);
        fathom_scene_destroy(scene);
    }
    assert_true(away[1] > 4 * away[0]);
}

static uint32_t spp_of(const char *path) {
    fathom_settings settings;
    fathom_scene *scene = scene_of_file(context, path);
    fathom_scene_settings(scene, &settings);
    return settings.spp;
}

UNIT_TEST(scene_files_may_say_how_many_samples) {
    static const char
        bare[] = "{\"objects\":[{\"type\":\"mesh\",\"file\":\"thing.v2.obj\"}]}",
        four[] = "{\"image\":{\"spp\":4},\"objects\":[{\"type\":\"mesh\",\"file\":\"thing.v2.obj\"}]}";
    assert_int_equal(spp_of(put_text("thing.v2.obj", PYRAMID)), 1024);
    assert_int_equal(spp_of(put_text("a.json", bare)), 1024);
    assert_int_equal(spp_of(put_text("a.json", four)), 4);
}

/* The image follows w over h of a scene file's camera where the file does not say its size; where it does and
 * the two differ, the image is stretched, as asked for, and that is said. */
UNIT_TEST(scene_files_shape_their_image) {
    const struct {
        const char *image, *warning;
        uint32_t width, height;
    } cases[] = {{"", NULL, 1280, 640},
                 {"\"width\":300", NULL, 300, 150},
                 {"\"height\":300", NULL, 600, 300},
                 {"\"width\":301,\"height\":151", NULL, 301, 151},
                 {"\"width\":300,\"height\":300", "the image is stretched horizontally by 0.5", 300, 300}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *json = unit_text(
            "{\"image\":{%s},\"camera\":{\"eye\":[0,0,5],\"target\":[0,0,0],\"d\":1,\"w\":2,\"h\":1},"
            "\"objects\":[{\"type\":\"sphere\",\"center\":[0,0,0],\"radius\":1}]}",
            cases[i].image);
        forget_warnings();
        fathom_scene *scene = scene_of_file(context, put_text("a.json", json));
        assert_int_equal(scene->settings.width, cases[i].width);
        assert_int_equal(scene->settings.height, cases[i].height);
        assert_near(scene->camera.w, 2, 0);
        if (cases[i].warning ? !strstr(warned, cases[i].warning) : warned[0] != '\0')
            fail_msg("%s: \"%s\"", cases[i].image, warned);
    }
}

/* Any format's mesh may be asked for by name; scenes are no meshes. */
UNIT_TEST(meshes) {
    fathom_status status;
    const read_mesh_options options = {.material = FATHOM_NONE};
    fathom_scene *scene = mesh_read(read_mesh, put_text("a.OBJ", PYRAMID), options);
    assert_int_equal(mesh_at(scene, 0)->triangle_count, 4);
    assert_null(mesh_try(read_mesh, mesh_write("a.json", "{}", 2), options, &status));
    assert_fails(context, status, FATHOM_BAD_INPUT,
                 "the extension .json is not known; expected .obj, .ply, .gltf or .glb");
}

int main(void) { return unit_main(open_folder, remove_folder); }
