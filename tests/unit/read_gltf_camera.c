/* Cameras of glTF files: which one is taken, and what shape the image gets. */
#include "gltf_file.h"

#define CAMERAS                                                                                              \
    "'cameras':[{'name':'plan','type':'orthographic','orthographic':{'xmag':1,'ymag':1,'zfar':9,'znear':1}}" \
    ","                                                                                                      \
    "{'name':'lens','type':'perspective','perspective':{'yfov':1,'aspectRatio':2,'znear':0.1}},"             \
    "{'type':'perspective','perspective':{'yfov':0.5,'znear':0.1}},"                                         \
    "{'name':'tall','type':'perspective','perspective':{'yfov':0.5,'aspectRatio':0.5625,'znear':0.1}}]"

/* Five nodes with cameras, in the order of the hierarchy: 0 "above" (plan), 1 "left" (lens), 2 "right" (lens
 * once more), 3 without a name (the third camera), 4 "left" again (tall). */
#define NODES                                                                                                \
    "'nodes':[{'children':[1,3]},{'name':'above','camera':0,'children':[2]},{'name':'left','camera':1},"     \
    "{'name':'right','camera':1,'translation':[2,0,0],'children':[4,5]},{'camera':2,'translation':[1,0,0]}," \
    "{'name':'left','camera':3},{'mesh':0}],'scenes':[{'nodes':[0,6]}]"
#define FILE_OF_CAMERAS WITH_DATA(TRIANGLE_MESH "," CAMERAS "," NODES)

static fathom_status read_asked(const char *camera, uint32_t width, uint32_t height, fathom_scene **out) {
    const fathom_read_options options = {
        .size = sizeof options, .camera = camera, .width = width, .height = height};
    forget_warnings();
    const fathom_status status = fathom_scene_read_with(context, file_path, &options, out);
    if (status == FATHOM_OK) own_scene(*out);
    return status;
}

UNIT_TEST(a_name_or_a_number_chooses) {
    const struct {
        const char *asked;
        uint32_t taken;
        double x, fovy;
    } cases[] = {{"1", 1, 0, 1},   {"right", 2, 2, 1},  {"2", 2, 2, 1},
                 {"3", 3, 3, 0.5}, {"tall", 4, 2, 0.5}, {"04", 4, 2, 0.5}};
    write_triangle(FILE_OF_CAMERAS);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene;
        assert_ok(context, read_asked(cases[i].asked, 0, 0, &scene));
        assert_int_equal(warning_count, 0);
        assert_int_equal(scene->camera_taken, cases[i].taken);
        assert_near(scene->camera.origin[0], cases[i].x, 0);
        assert_near(scene->camera.h, 2 * tan(cases[i].fovy / 2), 4 * 0x1p-53);
        assert_near(scene->camera.w, 0, 0); /* pixels are square */
    }
}

UNIT_TEST(a_wrong_choice_lists_what_there_is) {
    static const char list[] = "0 \"above\" (orthographic), 1 \"left\", 2 \"right\", 3, 4 \"left\"";
    const struct {
        const char *asked, *message;
    } cases[] = {{"up", "there is no camera \"up\"; expected one of "},
                 {"5", "there is no camera \"5\""},
                 {"", "there is no camera \"\""},
                 {"-1", "there is no camera \"-1\""},
                 {"left", "2 cameras are called \"left\"; expected the number of one of "},
                 {"lens", "2 cameras are called \"lens\""}};
    write_triangle(FILE_OF_CAMERAS);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene;
        assert_fails(context, read_asked(cases[i].asked, 0, 0, &scene), FATHOM_BAD_USAGE, cases[i].message);
        assert_null(scene);
        assert_non_null(strstr(fathom_context_message(context), list));
    }
}

/* Long lists end, and numbers go on. */
UNIT_TEST(many_cameras_are_listed_in_part) {
    char json[8192];
    int used =
        snprintf(json, sizeof json, "{" ASSET "," DATA "," TRIANGLE_MESH "," CAMERAS ",'nodes':[{'mesh':0}");
    for (int i = 0; i < 30; ++i)
        used += snprintf(json + used, sizeof json - (size_t)used, ",{'name':'n%d','camera':1}", i);
    snprintf(json + used, sizeof json - (size_t)used, "]}");
    write_triangle(json);
    fathom_scene *scene;
    assert_fails(context, read_asked("30", 0, 0, &scene), FATHOM_BAD_USAGE,
                 "19 \"n19\" and 10 more, which fathom info lists");
    assert_ok(context, read_asked("29", 0, 0, &scene));
    assert_int_equal(scene->camera_taken, 29);
}

UNIT_TEST(one_of_several_is_taken_and_said) {
    fathom_scene *scene;
    write_triangle(FILE_OF_CAMERAS);
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_int_equal(scene->camera_taken, 1);
    assert_int_equal(warning_count, 1);
    expect_warning("holds 5 cameras; 1 \"left\" is taken");
    /* An orthographic one alone is taken. */
    write_triangle(WITH_DATA(TRIANGLE_MESH "," CAMERAS ",'nodes':[{'mesh':0,'camera':0}]"));
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_int_equal(scene->camera_taken, 0);
    assert_true(scene->camera.orthographic && scene->camera.h == 2 && scene->camera_aspect == 1);
    assert_true(scene->camera.near_clip == 1 && scene->camera.far_clip == 9);
    assert_int_equal(warning_count, 0);
    /* However small it is; the product of both sides is not a number above 0. */
    write_triangle(WITH_DATA(TRIANGLE_MESH ",'cameras':[{'type':'orthographic','orthographic':{'xmag':1e-300,"
                                           "'ymag':1e-300}}],'nodes':[{'mesh':0,'camera':0}]"));
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_true(scene->camera.h == 2e-300 && scene->camera_aspect == 1);
    /* One and no more: nothing to say. */
    write_triangle(WITH_DATA(TRIANGLE_MESH "," CAMERAS ",'nodes':[{'mesh':0,'camera':1}]"));
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_int_equal(warning_count, 0);
}

/* A camera that is not taken does no harm, whatever it says. Taken, a view that is none is one of 45 degrees.
 */
UNIT_TEST(only_the_taken_camera_is_read) {
    fathom_scene *scene;
    write_triangle(WITH_DATA(TRIANGLE_MESH ",'cameras':[{'type':'perspective','perspective':{'yfov':1}},"
                                           "{'type':'perspective','perspective':{'yfov':4}}],"
                                           "'nodes':[{'mesh':0,'camera':0},{'name':'bad','camera':1}]"));
    assert_ok(context, read_asked("0", 0, 0, &scene));
    assert_int_equal(warning_count, 0);
    assert_ok(context, read_asked("bad", 0, 0, &scene));
    assert_int_equal(warning_count, 1);
    expect_warning("cameras[1].perspective.yfov: expected radians between 0 and pi");
    assert_near(scene->camera.h, 2 * tan(0.39269908169872414), 1e-15);
}

UNIT_TEST(planes_that_show_nothing_clip_nothing) {
    fathom_scene *scene;
    write_triangle(WITH_DATA(TRIANGLE_MESH ",'cameras':[{'type':'perspective','perspective':{'yfov':1,"
                                           "'znear':2,'zfar':1}}],'nodes':[{'mesh':0,'camera':0}]"));
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_int_equal(warning_count, 1);
    expect_warning("cameras[0].perspective.zfar: expected 0 <= znear < zfar");
    assert_true(scene->camera.near_clip == 0 && scene->camera.far_clip == 0);
}

UNIT_TEST(the_image_follows_the_camera) {
    const struct {
        const char *asked;
        uint32_t width, height;
    } cases[] = {{"right", 1280, 640}, {"3", 1280, 720}, {"tall", 720, 1280}};
    write_triangle(FILE_OF_CAMERAS);
    for (size_t i = 0; i < 3; ++i) {
        fathom_scene *scene;
        assert_ok(context, read_asked(cases[i].asked, 0, 0, &scene));
        assert_int_equal(scene->settings.width, cases[i].width);
        assert_int_equal(scene->settings.height, cases[i].height);
    }
    /* Extreme shapes: the shorter side is a pixel at least. */
    write_triangle(WITH_DATA(TRIANGLE_MESH ",'cameras':[{'type':'perspective','perspective':{'yfov':1,"
                                           "'aspectRatio':1e300}}],'nodes':[{'mesh':0,'camera':0}]"));
    fathom_scene *scene;
    assert_ok(context, read_asked(NULL, 0, 0, &scene));
    assert_int_equal(scene->settings.width, 1280);
    assert_int_equal(scene->settings.height, 1);
}

/* A given size changes no angle; what it cuts off is said, unless it is less than half a pixel. */
UNIT_TEST(a_given_size_keeps_the_vertical_field_of_view) {
    const struct {
        uint32_t width, height;
        const char *warning;
    } cases[] = {{1000, 1000, "the left and right 25 % of the camera's view are not seen"},
                 {641, 321, NULL},
                 {101, 51, NULL},
                 {3000, 1000, NULL},
                 {2000, 1000, NULL},
                 {1998, 1000, "1998x999 shows all of it"}};
    write_triangle(FILE_OF_CAMERAS);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene;
        assert_ok(context, read_asked("right", cases[i].width, cases[i].height, &scene));
        assert_near(scene->camera.h, 2 * tan(0.5), 4 * 0x1p-53);
        assert_near(scene->camera.w, 0, 0);
        if (!!warning_count != !!cases[i].warning || (warning_count && !strstr(warned, cases[i].warning)))
            fail_msg("%ux%u: \"%s\"", cases[i].width, cases[i].height, warning_count ? warned : "");
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
