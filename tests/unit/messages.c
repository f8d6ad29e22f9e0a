/* The context's message is that of a call that failed: calls that succeed leave none. */
#include "render.h"
#include "unit_folder.h"

/* Succeeds, and leaves the message of the context as it was: empty. */
#define assert_quiet(context, call)                                                                          \
    do {                                                                                                     \
        assert_ok(context, call);                                                                            \
        assert_string_equal(fathom_context_message(context), "");                                            \
    } while (0)

/* Every kind of shape, a material that mirrors and refracts, two lights. */
static stage full_stage(void) {
    stage s = stage_open(48, 40);
    fathom_material glass = default_material();
    for (int c = 0; c < 3; ++c) glass.k_r[c] = 0.2f, glass.k_t[c] = 0.8f;
    fathom_id id;
    assert_quiet(s.context, fathom_scene_add_material(s.scene, "glass", &glass, &id));
    stage_sphere(&s, -1, 0, -5, 1, id);
    stage_quad(&s, (double[3]){1, 0, -6}, (double[3]){1, 0, 0}, (double[3]){0, 1, 0}, 0);
    stage_plane(&s, (double[3]){0, -1, 0}, (double[3]){0, 1, 0}, 0);
    fathom_generate_options options = default_generate_options();
    options.triangles = 300;
    fathom_id group;
    fathom_instance instance = default_instance();
    assert_quiet(s.context, fathom_scene_add_group(s.scene, "mesh", &group));
    assert_quiet(s.context, fathom_scene_generate(s.scene, group, &options));
    instance.group = group, instance.transform[11] = -7;
    assert_quiet(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    stage_point_light(&s, 2, 5, 0, 30);
    assert_quiet(s.context, fathom_scene_complete(s.scene));
    assert_quiet(s.context, fathom_scene_check(s.scene));
    return s;
}

static void render_quietly(stage *s, const fathom_checkpoint *saving) {
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    fathom_session_options options = default_session_options();
    options.checkpoint = saving;
    assert_quiet(s->context, fathom_session_run(s->context, s->scene, &s->settings, &options, &stats, &film));
    fathom_film_destroy(film);
}

UNIT_TEST(a_render_that_succeeds_leaves_no_message) {
    static const char *const tracers[] = {NULL,         "embree:user", "embree:compact",
                                          "embree:low", "bvh",         "linear:f64"};
    stage s = full_stage();
    s.settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
    for (size_t i = 0; i < sizeof tracers / sizeof *tracers; ++i) {
        s.settings.tracer = tracers[i];
        render_quietly(&s, NULL);
    }
}

UNIT_TEST(every_way_to_sample_leaves_no_message) {
    stage s = full_stage();
    s.settings.spp = 16;
    render_quietly(&s, NULL);
    s.settings.pattern = FATHOM_PATTERN_SOBOL, s.settings.target_error = 0.1;
    render_quietly(&s, NULL);
    s.settings.max_time = 5;
    render_quietly(&s, NULL);
}

/* resume without a file there is warned of, and no failure. */
UNIT_TEST(a_checkpointed_render_leaves_no_message) {
    stage s = full_stage();
    fathom_checkpoint saving = default_checkpoint();
    saving.path = in_folder("a.part"), saving.resume = true, saving.every = 0;
    render_quietly(&s, &saving);
}

UNIT_TEST(writing_leaves_no_message) {
    static const char *const images[] = {"a.png", "a.exr", "a.jpg", "a.tif"};
    static const char *const meshes[] = {"a.ply", "a.glb", "a.obj"};
    stage s = full_stage();
    s.settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
    fathom_film *film = stage_render(&s);
    fathom_write_options options = default_write_options();
    fathom_image_prefetch();
    for (size_t i = 0; i < sizeof images / sizeof *images; ++i)
        assert_quiet(s.context, fathom_film_write(s.context, film, in_folder(images[i]), &options));
    assert_quiet(s.context, fathom_film_write_plain(s.context, film, in_folder("b.exr")));
    for (size_t i = 0; i < sizeof meshes / sizeof *meshes; ++i)
        assert_quiet(s.context, fathom_scene_write(s.scene, in_folder(meshes[i])));
}

UNIT_TEST(reading_leaves_no_message) {
    static const char *const files[] = {"scenes/example.json", "scenes/example.obj",
                                        "scenes/first-render.json"};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        fathom_scene *scene;
        const char *path = unit_text("%s/%s", SOURCE_DIR, files[i]);
        assert_quiet(context, fathom_scene_read(context, path, &scene));
        assert_quiet(context, fathom_scene_check_files(scene));
        fathom_scene_destroy(scene);
        assert_quiet(context, fathom_scene_read_to_render(context, path, &scene));
        fathom_scene_destroy(scene);
    }
}

UNIT_TEST(tracing_leaves_no_message) {
    stage s = full_stage();
    const char *const kinds[] = {"embree", "reference"};
    for (size_t i = 0; i < 2; ++i) {
        fathom_tracer *tracer;
        const fathom_ray ray = {.direction = {0, 0, -1}, .t_max = INFINITY};
        fathom_hit hit;
        bool any;
        assert_quiet(s.context, fathom_tracer_create(s.context, s.scene, kinds[i], &tracer));
        assert_quiet(s.context, fathom_tracer_closest(tracer, &ray, 1, &hit));
        assert_quiet(s.context, fathom_tracer_any(tracer, &ray, 1, &any));
        fathom_tracer_destroy(tracer);
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
