/* The public calls used wrongly: NULL for each pointer of each of them, calls in the wrong order, values that
 * no enumerator stands for. All end with a status, or do nothing; include/fathom/base.h has the rules. */
#include "render.h"

#include <unistd.h>

/* One call that may be given NULL nowhere else than where it is given here. */
#define refuses(call) assert_int_equal((call), FATHOM_BAD_USAGE)

/* The same, with a message that begins with the argument's name. */
#define names(argument, call)                                                                                \
    assert_fails(s.context, call, FATHOM_BAD_USAGE, argument ": expected an address")

static stage one_sphere(void) {
    stage s = stage_open(32, 32);
    stage_sphere(&s, 0, 0, -5, 1, 0);
    return s;
}

UNIT_TEST(null_for_contexts) {
    refuses(fathom_context_create(NULL));
    fathom_context_destroy(NULL);
    assert_string_equal(fathom_context_message(NULL), "");
    assert_int_equal(fathom_context_error(NULL)->status, FATHOM_OK);
    fathom_context_on_warning(NULL, NULL, NULL);
    fathom_context_set_threads(NULL, 3);
    fathom_context_allow_outside(NULL, true);
    fathom_context_copy_files(NULL, true);
    fathom_guard_files(); /* takes nothing */
    assert_true(fathom_context_threads(NULL) >= 1);
    assert_non_null(fathom_version());
    assert_non_null(fathom_commit());
    refuses(fathom_build_info(NULL));
    stage s = one_sphere();
    refuses(fathom_context_fail(NULL, &(fathom_error){FATHOM_BAD_INPUT, NULL, NULL}));
    names("error", fathom_context_fail(s.context, NULL));
    assert_int_equal(fathom_context_fail(s.context, &(fathom_error){FATHOM_BAD_INPUT, NULL, NULL}),
                     FATHOM_BAD_INPUT);
    assert_string_equal(fathom_context_message(s.context), "");
    refuses(fathom_context_fail_within(NULL, &(fathom_place){.file = NULL}));
    names("place", fathom_context_fail_within(s.context, NULL));
}

UNIT_TEST(null_for_files) {
    stage s = one_sphere();
    const char *none = NULL;
    refuses(fathom_file_check(NULL, "a"));
    names("path", fathom_file_check(s.context, NULL));
    refuses(fathom_file_write(NULL, "a", "b", 1));
    names("path", fathom_file_write(s.context, NULL, "b", 1));
    names("bytes", fathom_file_write(s.context, "a", NULL, 1));
    refuses(fathom_file_protect(NULL, &none, 1));
    names("paths", fathom_file_protect(s.context, NULL, 1));
    names("paths[0]", fathom_file_protect(s.context, &none, 1));
    assert_ok(s.context, fathom_file_protect(s.context, NULL, 0));
    fathom_file_remove_left_over(NULL);
    fathom_file_abandon_also(NULL);
    fathom_file_abandon_no_more(NULL);
    fathom_file_abandon_all(); /* takes nothing */
}

UNIT_TEST(null_for_images) {
    stage s = one_sphere();
    fathom_film *film = stage_render(&s);
    fathom_write_options options = default_write_options();
    fathom_image_difference difference = {.size = sizeof difference};
    fathom_flip flip = {.size = sizeof flip};
    const fathom_image *image = NULL;
    char text[64];
    uint32_t width = 7, height = 7;
    refuses(fathom_write_check(NULL, "a.exr", &options));
    names("path", fathom_write_check(s.context, NULL, &options));
    names("options", fathom_write_check(s.context, "a.exr", NULL));
    refuses(fathom_write_check_size(NULL, "a.exr", 1, 1));
    names("path", fathom_write_check_size(s.context, NULL, 1, 1));
    assert_false(fathom_write_is_srgb(NULL));
    assert_false(fathom_write_needs_helper(NULL, &options));
    assert_false(fathom_write_needs_helper("a.exr", NULL));
    fathom_film *second;
    refuses(fathom_film_reweight(NULL, film, &second));
    names("film", fathom_film_reweight(s.context, NULL, &second));
    names("out", fathom_film_reweight(s.context, film, NULL));
    refuses(fathom_film_rescue(NULL, film, "a.exr", text, sizeof text));
    names("film", fathom_film_rescue(s.context, NULL, "a.exr", text, sizeof text));
    names("path", fathom_film_rescue(s.context, film, NULL, text, sizeof text));
    names("saved", fathom_film_rescue(s.context, film, "a.exr", NULL, 0));
    refuses(fathom_image_libraries(NULL, text, sizeof text));
    names("out", fathom_image_libraries(s.context, NULL, 0));
    refuses(fathom_image_read(NULL, "a.exr", &image));
    names("path", fathom_image_read(s.context, NULL, &image));
    names("out", fathom_image_read(s.context, "a.exr", NULL));
    fathom_image_destroy(NULL);
    fathom_image_size(NULL, &width, &height);
    assert_int_equal(width + height, 0);
    assert_null(fathom_image_channel_name(NULL, 0));
    assert_null(fathom_image_channel(NULL, "R", NULL));
    assert_null(fathom_image_channel_id(NULL, "R", NULL));
    refuses(fathom_image_compare(NULL, image, image, 0, &difference));
    names("a", fathom_image_compare(s.context, NULL, image, 0, &difference));
    refuses(fathom_image_flip(NULL, image, image, 67, &flip));
    names("a", fathom_image_flip(s.context, NULL, image, 67, &flip));
}

UNIT_TEST(null_for_surveys) {
    stage s = one_sphere();
    fathom_light light;
    const fathom_survey *survey;
    assert_string_equal(fathom_scene_name(NULL), "");
    assert_int_equal(fathom_scene_lights(NULL), 0);
    refuses(fathom_scene_light(NULL, 0, &light));
    names("out", fathom_scene_light(s.scene, 0, NULL));
    assert_fails(s.context, fathom_scene_light(s.scene, 0, &light), FATHOM_BAD_USAGE, "lights[0]");
    refuses(fathom_scene_survey(NULL, &survey));
    names("out", fathom_scene_survey(s.scene, NULL));
    fathom_survey_destroy(NULL);
}

UNIT_TEST(null_for_settings) {
    stage s = one_sphere();
    char text[32];
    assert_non_null(fathom_settings_parameters(NULL));
    assert_non_null(fathom_material_parameters(FATHOM_MODEL_CLASSIC, NULL));
    refuses(fathom_settings_check(NULL, &s.settings));
    names("settings", fathom_settings_check(s.context, NULL));
    refuses(fathom_settings_set_text(NULL, &s.settings, "spp", "1"));
    names("settings", fathom_settings_set_text(s.context, NULL, "spp", "1"));
    names("name", fathom_settings_set_text(s.context, &s.settings, NULL, "1"));
    names("value", fathom_settings_set_text(s.context, &s.settings, "spp", NULL));
    refuses(fathom_settings_get_text(NULL, &s.settings, "spp", text, sizeof text));
    names("settings", fathom_settings_get_text(s.context, NULL, "spp", text, sizeof text));
    names("value", fathom_settings_get_text(s.context, &s.settings, "spp", NULL, 0));
}

UNIT_TEST(null_for_defaults) {
    fathom_settings settings = {.size = sizeof settings, .width = 7}, expected;
    fathom_settings_default(NULL);
    refuses(fathom_settings_set_integrator(NULL, FATHOM_INTEGRATOR_PATH));
    refuses(fathom_settings_set_loss(NULL, FATHOM_LOSS_8BIT, 0));
    fathom_settings_default(&expected);
    fathom_scene_settings(NULL, &settings);
    assert_int_equal(settings.width, expected.width);
    assert_int_equal(settings.tile_size, expected.tile_size);
    fathom_scene_settings(NULL, NULL);
    fathom_write_options_default(NULL);
    fathom_generate_options_default(NULL);
    fathom_material_default(NULL);
    fathom_light_default(NULL);
    fathom_sphere_default(NULL);
    fathom_quad_default(NULL);
    fathom_plane_default(NULL);
    fathom_mesh_default(NULL);
    fathom_instance_default(NULL);
    fathom_camera_default(NULL);
}

/* What helps to fill a struct leaves it as it was. */
UNIT_TEST(null_for_helpers) {
    const double a[3] = {1, 2, 3}, b[3] = {0, 1, 0};
    fathom_camera camera, camera_before;
    fathom_quad quad, quad_before;
    memset(&camera, 7, sizeof camera), memset(&quad, 7, sizeof quad);
    camera_before = camera, quad_before = quad;
    fathom_camera_look_at(NULL, a, b, 1, &camera);
    fathom_camera_look_at(a, NULL, b, 1, &camera);
    fathom_camera_look_at(a, b, NULL, 1, &camera);
    fathom_camera_look_at(a, b, b, 1, NULL);
    fathom_quad_from_axes(NULL, a, b, &quad);
    fathom_quad_from_axes(a, NULL, b, &quad);
    fathom_quad_from_axes(a, b, NULL, &quad);
    fathom_quad_from_axes(a, b, b, NULL);
    assert_memory_equal(&camera, &camera_before, sizeof camera);
    assert_memory_equal(&quad, &quad_before, sizeof quad);
}

UNIT_TEST(null_for_scenes) {
    stage s = stage_open(32, 32);
    fathom_scene *scene = s.scene;
    names("out", fathom_scene_create(s.context, NULL));
    refuses(fathom_scene_create(NULL, NULL));
    refuses(fathom_scene_create(NULL, &scene));
    assert_null(scene);
    fathom_scene_destroy(NULL);
    refuses(fathom_scene_set_name(NULL, "a"));
    names("name", fathom_scene_set_name(s.scene, NULL));
    refuses(fathom_scene_name_object(NULL, 0, "a"));
    names("name", fathom_scene_name_object(s.scene, 0, NULL));
    refuses(fathom_scene_set_light_group(NULL, FATHOM_SOURCE_BACKGROUND, 0, "a"));
    names("name", fathom_scene_set_light_group(s.scene, FATHOM_SOURCE_BACKGROUND, 0, NULL));
    refuses(fathom_scene_complete(NULL));
    refuses(fathom_scene_check(NULL));
    refuses(fathom_scene_check_files(NULL));
    refuses(fathom_scene_write(NULL, "a.ply"));
    names("path", fathom_scene_write(s.scene, NULL));
    refuses(fathom_scene_set_settings(NULL, &s.settings));
    names("settings", fathom_scene_set_settings(s.scene, NULL));
    fathom_scene_settings(s.scene, NULL);
    fathom_framing framing = {.size = sizeof framing};
    refuses(fathom_scene_framing(s.scene, NULL));
    assert_ok(s.context, fathom_scene_framing(NULL, &framing));
    assert_false(framing.made);
    assert_false(fathom_scene_framed_times(NULL, (double[2]){0}));
    assert_false(fathom_scene_framed_times(s.scene, NULL));
    fathom_framing_unite(NULL, &framing);
    fathom_framing_unite(&framing, NULL);

    fathom_generate_options options = default_generate_options();
    refuses(fathom_scene_generate(NULL, FATHOM_ROOT, &options));
    names("options", fathom_scene_generate(s.scene, FATHOM_ROOT, NULL));

    fathom_camera camera = default_camera();
    const float rgb[3] = {0, 0, 0};
    refuses(fathom_scene_set_camera(NULL, &camera));
    names("camera", fathom_scene_set_camera(s.scene, NULL));
    refuses(fathom_scene_set_background(NULL, rgb));
    names("background", fathom_scene_set_background(s.scene, NULL));
    refuses(fathom_scene_set_ambient(NULL, rgb));
    names("ambient", fathom_scene_set_ambient(s.scene, NULL));
}

UNIT_TEST(null_for_what_is_added) {
    stage s = stage_open(32, 32);
    fathom_id id = 77;
    fathom_material material = default_material();
    fathom_light light = default_light();
    fathom_sphere sphere = default_sphere();
    fathom_quad quad = default_quad();
    fathom_plane plane = default_plane();
    fathom_mesh mesh = default_mesh();
    fathom_instance instance = default_instance();
    refuses(fathom_scene_add_material(NULL, "a", &material, &id));
    names("material", fathom_scene_add_material(s.scene, "a", NULL, &id));
    refuses(fathom_scene_add_light(NULL, &light, &id));
    names("light", fathom_scene_add_light(s.scene, NULL, &id));
    refuses(fathom_scene_add_sphere(NULL, FATHOM_ROOT, &sphere, &id));
    names("sphere", fathom_scene_add_sphere(s.scene, FATHOM_ROOT, NULL, &id));
    refuses(fathom_scene_add_quad(NULL, FATHOM_ROOT, &quad, &id));
    names("quad", fathom_scene_add_quad(s.scene, FATHOM_ROOT, NULL, &id));
    refuses(fathom_scene_add_plane(NULL, FATHOM_ROOT, &plane, &id));
    names("plane", fathom_scene_add_plane(s.scene, FATHOM_ROOT, NULL, &id));
    refuses(fathom_scene_add_mesh(NULL, FATHOM_ROOT, &mesh, &id));
    names("mesh", fathom_scene_add_mesh(s.scene, FATHOM_ROOT, NULL, &id));
    refuses(fathom_scene_add_mesh_shared(NULL, FATHOM_ROOT, &mesh, &id));
    names("mesh", fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, NULL, &id));
    refuses(fathom_scene_add_group(NULL, "a", &id));
    refuses(fathom_scene_add_instance(NULL, &instance, &id));
    names("instance", fathom_scene_add_instance(s.scene, NULL, &id));
    assert_int_equal(id, 77);
    /* The id is not always wanted, and not all have a name. */
    assert_ok(s.context, fathom_scene_add_group(s.scene, NULL, NULL));
    instance.group = 1;
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    assert_ok(s.context, fathom_scene_add_material(s.scene, NULL, &material, NULL));
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    assert_ok(s.context, fathom_scene_add_plane(s.scene, FATHOM_ROOT, &plane, NULL));
}

/* Arrays that are NULL though their counts say otherwise, and the other way round. */
UNIT_TEST(null_in_meshes) {
    stage s = stage_open(32, 32);
    static const float positions[16] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    fathom_mesh whole = default_mesh();
    whole.positions = positions, whole.vertex_count = 3, whole.indices = indices, whole.triangle_count = 1;
    fathom_mesh mesh = whole;
    mesh.positions = NULL;
    assert_fails(s.context, fathom_scene_add_mesh(s.scene, 0, &mesh, NULL), FATHOM_BAD_INPUT, "positions");
    mesh = whole, mesh.indices = NULL;
    assert_fails(s.context, fathom_scene_add_mesh(s.scene, 0, &mesh, NULL), FATHOM_BAD_INPUT, "indices");
    /* Without the arrays, what else is said of them does not count. */
    mesh = whole, mesh.normal_count = mesh.uv_count = 9, mesh.normal_indices = mesh.uv_indices = indices;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, 0, &mesh, NULL));
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, 0, &mesh, NULL));
    stage_render(&s);
}

/* A cloud of points has positions and colours alone, and a radius that is a number. */
UNIT_TEST(clouds_with_more_than_points) {
    stage s = stage_open(32, 32);
    static const float rows[16] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    static const double time = 0;
    fathom_mesh whole = default_mesh(), m;
    whole.positions = rows, whole.vertex_count = 3, whole.point_radius = 1;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, 0, &whole, NULL));
    const float radii[] = {-1, NAN, INFINITY};
    for (int i = 0; i < 3; ++i) {
        m = whole, m.point_radius = radii[i];
        assert_fails(s.context, fathom_scene_add_mesh(s.scene, 0, &m, NULL), FATHOM_BAD_INPUT,
                     "point_radius: expected");
    }
    for (int i = 0; i < 6; ++i) {
        static const char *const names[] = {"indices", "indices", "normals", "uvs", "uvs", "key_count"};
        m = whole;
        if (i == 0) m.triangle_count = 1;
        if (i == 1) m.indices = indices;
        if (i == 2) m.normals = rows, m.normal_count = 3;
        if (i == 3) m.uvs = rows, m.uv_count = 3;
        if (i == 4) m.uvs_1 = rows;
        if (i == 5) m.key_count = 1, m.key_times = &time, m.key_positions = rows;
        assert_fails(s.context, fathom_scene_add_mesh(s.scene, 0, &m, NULL), FATHOM_BAD_INPUT, names[i]);
        assert_non_null(strstr(fathom_context_message(s.context), "cloud of points"));
    }
}

UNIT_TEST(null_for_reading) {
    stage s = stage_open(32, 32);
    fathom_scene *scene = s.scene;
    refuses(fathom_scene_read(NULL, "a.json", &scene));
    assert_null(scene);
    scene = s.scene;
    names("path", fathom_scene_read(s.context, NULL, &scene));
    assert_null(scene);
    names("out", fathom_scene_read(s.context, "a.json", NULL));
    refuses(fathom_scene_read_to_render(NULL, "a.json", &scene));
    names("path", fathom_scene_read_to_render(s.context, NULL, &scene));
    names("out", fathom_scene_read_to_render(s.context, "a.json", NULL));
    fathom_read_options options = default_read_options();
    fathom_read_options_default(NULL);
    refuses(fathom_scene_read_with(NULL, "a.json", &options, &scene));
    names("path", fathom_scene_read_with(s.context, NULL, &options, &scene));
    names("options", fathom_scene_read_with(s.context, "a.json", NULL, &scene));
    names("out", fathom_scene_read_with(s.context, "a.json", &options, NULL));
}

UNIT_TEST(null_for_renders) {
    stage s = one_sphere();
    fathom_film *film = NULL;
    fathom_stats stats = {.size = sizeof stats};
    refuses(fathom_render(NULL, s.scene, &s.settings, NULL, NULL, &stats, &film));
    names("scene", fathom_render(s.context, NULL, &s.settings, NULL, NULL, &stats, &film));
    names("settings", fathom_render(s.context, s.scene, NULL, NULL, NULL, &stats, &film));
    names("out", fathom_render(s.context, s.scene, &s.settings, NULL, NULL, &stats, NULL));
    assert_null(film);
    fathom_checkpoint_default(NULL);
    fathom_checkpoint saving = default_checkpoint(), nowhere;
    nowhere = saving, saving.path = "a.checkpoint";
    fathom_session_options_default(NULL);
    fathom_session_options options = default_session_options();
    options.checkpoint = &saving;
    refuses(fathom_session_run(NULL, s.scene, &s.settings, &options, &stats, &film));
    names("scene", fathom_session_run(s.context, NULL, &s.settings, &options, &stats, &film));
    names("settings", fathom_session_run(s.context, s.scene, NULL, &options, &stats, &film));
    names("out", fathom_session_run(s.context, s.scene, &s.settings, &options, &stats, NULL));
    options.checkpoint = &nowhere;
    names("checkpoint: path", fathom_session_run(s.context, s.scene, &s.settings, &options, NULL, &film));
    options.checkpoint = NULL, options.output_count = 1;
    names("outputs", fathom_session_run(s.context, s.scene, &s.settings, &options, NULL, &film));
    const char *part_path = "a.part";
    refuses(fathom_parts_merge(NULL, &part_path, 1, &stats, &film));
    names("paths", fathom_parts_merge(s.context, NULL, 1, &stats, &film));
    assert_fails(s.context, fathom_parts_merge(s.context, &part_path, 0, &stats, &film), FATHOM_BAD_USAGE,
                 "paths: expected one part or more");
    names("out", fathom_parts_merge(s.context, &part_path, 1, &stats, NULL));
    fathom_part_default(NULL);
    fathom_ranks_default(NULL);
    refuses(fathom_mpi_open(NULL, NULL));
    names("ranks", fathom_mpi_open(s.context, NULL));
    fathom_mpi_close(true);
    const fathom_ranks alone = {.size = sizeof alone, .count = 1};
    fathom_scene *read;
    char *folder;
    refuses(fathom_ranks_read(NULL, &alone, "a", NULL, NULL, &read, &folder));
    names("ranks", fathom_ranks_read(s.context, NULL, "a", NULL, NULL, &read, &folder));
    names("folder", fathom_ranks_read(s.context, &alone, "a", NULL, NULL, &read, NULL));
    fathom_ranks_remove(NULL);
    refuses(fathom_checkpoint_check(NULL, &saving));
    names("checkpoint", fathom_checkpoint_check(s.context, NULL));
    names("checkpoint: path", fathom_checkpoint_check(s.context, &nowhere));
    assert_int_not_equal(access("a.checkpoint", F_OK), 0);
    const char *const files[] = {"a.exr"};
    fathom_write_options write = default_write_options();
    bool done;
    refuses(fathom_finished_keep(NULL, NULL, "a", &write, files, 1));
    names("film", fathom_finished_keep(s.context, NULL, "a", &write, files, 1));
    refuses(fathom_finished_find(NULL, s.scene, &s.settings, "a", &write, files, 1, &done));
    names("scene", fathom_finished_find(s.context, NULL, &s.settings, "a", &write, files, 1, &done));
    names("settings", fathom_finished_find(s.context, s.scene, NULL, "a", &write, files, 1, &done));
    names("path", fathom_finished_find(s.context, s.scene, &s.settings, NULL, &write, files, 1, &done));
    names("files", fathom_finished_find(s.context, s.scene, &s.settings, "a", &write, NULL, 1, &done));
    names("write", fathom_finished_find(s.context, s.scene, &s.settings, "a", NULL, files, 1, &done));
    names("finished", fathom_finished_find(s.context, s.scene, &s.settings, "a", &write, files, 1, NULL));
    fathom_film_destroy(NULL);
    fathom_image_prefetch();
}

UNIT_TEST(null_for_sessions) {
    stage s = one_sphere();
    fathom_session *session = NULL;
    fathom_progress progress;
    fathom_film *film;
    refuses(fathom_session_start(NULL, s.scene, &s.settings, NULL, &session));
    names("scene", fathom_session_start(s.context, NULL, &s.settings, NULL, &session));
    names("settings", fathom_session_start(s.context, s.scene, NULL, NULL, &session));
    names("out", fathom_session_start(s.context, s.scene, &s.settings, NULL, NULL));
    assert_null(session);
    fathom_session_progress(NULL, &progress);
    fathom_session_stop(NULL);
    assert_true(fathom_session_wait(NULL, -1));
    names("session", fathom_session_snapshot(s.context, NULL, &film));
    refuses(fathom_session_finish(NULL, NULL, &film));
    assert_ok(s.context, fathom_session_start(s.context, s.scene, &s.settings, NULL, &session));
    fathom_session_progress(session, NULL);
    names("out", fathom_session_snapshot(s.context, session, NULL));
    assert_ok(s.context, fathom_session_finish(session, NULL, NULL));
}

UNIT_TEST(null_for_films) {
    stage s = one_sphere();
    fathom_film *film = stage_render(&s);
    uint32_t width = 7, height = 7;
    fathom_film_size(NULL, &width, &height);
    assert_int_equal(width + height, 0);
    fathom_film_size(film, NULL, &height);
    fathom_film_size(film, &width, NULL);
    assert_int_equal(width + height, 64);
    fathom_brightness brightness = {.size = sizeof brightness, .pixels = 7};
    fathom_film_brightness(NULL, 0, &brightness);
    assert_int_equal(brightness.pixels, 0);
    refuses(fathom_film_brightness(film, 0, NULL));
    float stops = 7;
    assert_false(fathom_film_exposure(NULL, &stops));
    assert_false(fathom_film_exposure(film, NULL));
    assert_false(fathom_film_exposure(film, &stops));
    assert_true(stops == 7);
    assert_null(fathom_film_channel(NULL, "R"));
    assert_null(fathom_film_channel(film, NULL));
    assert_null(fathom_film_channel_id(NULL, "id.object"));
    assert_null(fathom_film_channel_id(film, NULL));
    const fathom_left_out *left_out = (const fathom_left_out *)(const void *)&s;
    assert_int_equal(fathom_film_left_out(NULL, &left_out), 0);
    assert_null(left_out);
    assert_int_equal(fathom_film_left_out(film, NULL), fathom_film_left_out(film, &left_out));
    fathom_write_options options = default_write_options();
    refuses(fathom_film_write(NULL, film, "a.exr", &options));
    names("film", fathom_film_write(s.context, NULL, "a.exr", &options));
    names("path", fathom_film_write(s.context, film, NULL, &options));
    names("options", fathom_film_write(s.context, film, "a.exr", NULL));
    refuses(fathom_film_write_plain(NULL, film, "a.exr"));
    names("film", fathom_film_write_plain(s.context, NULL, "a.exr"));
    names("path", fathom_film_write_plain(s.context, film, NULL));
}

UNIT_TEST(null_for_tracers) {
    stage s = one_sphere();
    fathom_tracer *tracer = NULL;
    const fathom_ray ray = {.direction = {0, 0, -1}, .t_max = 100};
    fathom_hit hit;
    bool any;
    refuses(fathom_tracer_create(NULL, s.scene, "embree", &tracer));
    names("scene", fathom_tracer_create(s.context, NULL, "embree", &tracer));
    names("out", fathom_tracer_create(s.context, s.scene, "embree", NULL));
    assert_null(tracer);
    assert_int_equal(fathom_tracer_check(NULL, "embree"), FATHOM_OK);
    assert_ok(s.context, fathom_tracer_check(s.context, NULL));
    fathom_tracer_destroy(NULL);
    refuses(fathom_tracer_closest(NULL, &ray, 1, &hit));
    refuses(fathom_tracer_any(NULL, &ray, 1, &any));
    assert_ok(s.context, fathom_tracer_create(s.context, s.scene, "reference", &tracer));
    names("rays", fathom_tracer_closest(tracer, NULL, 1, &hit));
    names("hits", fathom_tracer_closest(tracer, &ray, 1, NULL));
    names("rays", fathom_tracer_any(tracer, NULL, 1, &any));
    names("hits", fathom_tracer_any(tracer, &ray, 1, NULL));
    assert_ok(s.context, fathom_tracer_closest(tracer, NULL, 0, NULL));
    assert_ok(s.context, fathom_tracer_any(tracer, NULL, 0, NULL));
    assert_ok(s.context, fathom_tracer_closest(tracer, &ray, 1, &hit));
    assert_int_equal(hit.object, 0);
    fathom_tracer_destroy(tracer);
}

/* No call is forgotten here: each that the headers declare is in this file's text. */
UNIT_TEST(every_call_is_here) {
    static const char *const headers[] = {"base.h",  "file.h",    "image.h",  "parameter.h",
                                          "part.h",  "ranks.h",   "read.h",   "render.h",
                                          "scene.h", "session.h", "survey.h", "trace.h"};
    FILE *f = fopen(SOURCE_DIR "/tests/unit/misuse.c", "r");
    assert_non_null(f);
    static char text[1 << 16], header[1 << 16], path[512];
    text[fread(text, 1, sizeof text - 1, f)] = '\0';
    fclose(f);
    unsigned calls = 0;
    for (size_t i = 0; i < sizeof headers / sizeof *headers; ++i) {
        snprintf(path, sizeof path, SOURCE_DIR "/include/fathom/%s", headers[i]);
        f = fopen(path, "r");
        assert_non_null(f);
        header[fread(header, 1, sizeof header - 1, f)] = '\0';
        fclose(f);
        for (const char *at = header; (at = strstr(at, "\nFATHOM_API ")); ++calls) {
            const char *open = strchr(at, '('), *name = open;
            while (name[-1] == '_' || (name[-1] >= 'a' && name[-1] <= 'z')) --name;
            /* fathom_x_sized() is what fathom_x() calls. */
            int length = (int)(open - name);
            if (length > 6 && strncmp(open - 6, "_sized", 6) == 0) length -= 6;
            const char *call = unit_text("%.*s(", length, name);
            if (!strstr(text, call)) fail_msg("%s) is given NULL nowhere", call);
            at = open;
        }
    }
    assert_true(calls >= 50);
}

UNIT_TEST(unfinished_scenes) {
    stage s = stage_open(32, 32);
    fathom_film *film;
    fathom_tracer *tracer;
    const char *nothing = "the scene holds no geometry";
    assert_fails(s.context, fathom_scene_check(s.scene), FATHOM_BAD_INPUT, nothing);
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, nothing);
    assert_null(film);
    assert_fails(s.context, fathom_tracer_create(s.context, s.scene, "embree", &tracer), FATHOM_BAD_INPUT,
                 nothing);
    assert_null(tracer);
    assert_fails(s.context, fathom_scene_write(s.scene, "a.ply"), FATHOM_BAD_USAGE, "no shape to write");
    /* What is named before it is there. */
    fathom_instance instance = default_instance();
    assert_fails(s.context, fathom_scene_add_instance(s.scene, &instance, NULL), FATHOM_BAD_INPUT, "group");
    instance.group = 1;
    assert_fails(s.context, fathom_scene_add_instance(s.scene, &instance, NULL), FATHOM_BAD_INPUT, "group");
    fathom_sphere sphere = default_sphere();
    sphere.material = 1;
    assert_fails(s.context, fathom_scene_add_sphere(s.scene, 0, &sphere, NULL), FATHOM_BAD_INPUT,
                 "material 1");
    sphere.material = 0;
    assert_fails(s.context, fathom_scene_add_sphere(s.scene, 1, &sphere, NULL), FATHOM_BAD_INPUT, "group 1");
    /* Completing early and often is good; the scene can still be changed. */
    assert_ok(s.context, fathom_scene_complete(s.scene));
    stage_sphere(&s, 0, 0, -5, 1, 0);
    assert_ok(s.context, fathom_scene_complete(s.scene));
    assert_ok(s.context, fathom_scene_complete(s.scene));
    stage_render(&s);
    stage_sphere(&s, 1, 0, -5, 1, 0);
    stage_render(&s);
}

UNIT_TEST(destroying_in_any_order) {
    for (int order = 0; order < 6; ++order) {
        stage s = one_sphere();
        fathom_film *film = stage_render(&s);
        unit_thing_count = 0; /* this test ends them itself */
        fathom_tracer *tracer;
        assert_ok(s.context, fathom_tracer_create(s.context, s.scene, "embree", &tracer));
        for (int i = 0; i < 3; ++i) {
            int which = order < 3 ? (order + i) % 3 : (order + 3 - i) % 3;
            if (which == 0) fathom_context_destroy(s.context);
            if (which == 1) fathom_scene_destroy(s.scene);
            if (which == 2) fathom_tracer_destroy(tracer);
        }
        /* A film needs none of them. */
        assert_non_null(fathom_film_channel(film, "R"));
        fathom_film_destroy(film);
    }
}

/* A film may be used as long as wanted, by another context too, after a write that failed as well. */
UNIT_TEST(films_outlive) {
    stage s = one_sphere();
    fathom_film *film = stage_render(&s);
    unit_thing_count = 0; /* this test ends them itself */
    fathom_scene_destroy(s.scene);
    fathom_context_destroy(s.context);
    fathom_context *other;
    assert_int_equal(fathom_context_create(&other), FATHOM_OK);
    fathom_write_options options = default_write_options();
    assert_fails(other, fathom_film_write(other, film, "a.unknown", &options), FATHOM_BAD_USAGE, "unknown");
    assert_int_not_equal(access("a.unknown", F_OK), 0);
    assert_non_null(fathom_film_channel(film, "G"));
    fathom_film_destroy(film);
    fathom_context_destroy(other);
}

UNIT_TEST(values_of_no_enumerator) {
    stage s = one_sphere();
    fathom_settings settings = s.settings;
    fathom_film *film;
    settings.pattern = (fathom_pattern)3;
    assert_fails(s.context, fathom_render(s.context, s.scene, &settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_USAGE, "pattern");
    refuses(fathom_settings_set_loss(&settings, (fathom_loss)3, 0));
    refuses(fathom_settings_set_integrator(&settings, (fathom_integrator)3));
    settings = s.settings, settings.aovs = FATHOM_AOVS + 1u;
    assert_fails(s.context, fathom_scene_set_settings(s.scene, &settings), FATHOM_BAD_USAGE, "aovs");
    fathom_tracer *tracer;
    assert_fails(s.context, fathom_tracer_create(s.context, s.scene, "cuda", &tracer), FATHOM_BAD_USAGE,
                 "tracer");
    fathom_material material = default_material();
    material.specular = (fathom_specular)3;
    assert_fails(s.context, fathom_scene_add_material(s.scene, NULL, &material, NULL), FATHOM_BAD_USAGE,
                 "specular");
    fathom_light light = default_light();
    light.type = (fathom_light_type)4;
    assert_fails(s.context, fathom_scene_add_light(s.scene, &light, NULL), FATHOM_BAD_USAGE, "type");
    fathom_generate_options options = default_generate_options();
    options.kind = (fathom_generator)4;
    assert_fails(s.context, fathom_scene_generate(s.scene, 0, &options), FATHOM_BAD_USAGE, "kind");
    const fathom_part part = {.size = sizeof part,
                              .path = "misuse.part",
                              .index = 1,
                              .count = 2,
                              .split = (fathom_split)(FATHOM_SPLIT_TILES + 1)};
    fathom_session_options session = default_session_options();
    session.part = &part;
    assert_fails(s.context, fathom_session_run(s.context, s.scene, &s.settings, &session, NULL, &film),
                 FATHOM_BAD_USAGE, "split");
}

/* What failed leaves a context and a scene as good as they were. */
UNIT_TEST(work_goes_on_after_failures) {
    stage s = one_sphere();
    fathom_film *before = stage_render(&s), *film;
    fathom_settings bad = s.settings;
    bad.spp = 0;
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(fathom_render(s.context, s.scene, &bad, NULL, NULL, NULL, &film), FATHOM_BAD_INPUT);
        names("mesh", fathom_scene_add_mesh(s.scene, 0, NULL, NULL));
    }
    fathom_film *after = stage_render(&s);
    for (const char *const *c = (const char *const[]){"R", "G", "B", NULL}; *c; ++c) {
        assert_memory_equal(fathom_film_channel(before, *c), fathom_film_channel(after, *c),
                            sizeof(float) * 32 * 32);
    }
}

int main(void) { return unit_main(NULL, NULL); }
