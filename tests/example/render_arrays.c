/* Renders a golden pyramid on the ground from arrays in memory:
 * cc render_arrays.c $(pkg-config --cflags --libs fathom) -o render_arrays && ./render_arrays out.png */
#include <fathom/fathom.h>
#include <stdio.h>

static const float corners[] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, 1.5f, 0};
static const uint32_t faces[] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};

/* Each call has a status; the first failure ends the work. */
#define TRY(call)                                                                                            \
    if ((status = (call)) != FATHOM_OK) return status

static fathom_status build(fathom_scene *scene) {
    fathom_status status;
    fathom_material gold;
    fathom_mesh pyramid;
    fathom_plane ground = {.normal = {0, 1, 0}};
    fathom_light light;
    fathom_camera camera;
    fathom_material_default(&gold), gold.specular = FATHOM_SPECULAR_BLINN;
    gold.k_d[1] = gold.k_s[1] = 0.35f, gold.k_d[2] = gold.k_s[2] = 0.08f, gold.k_s[0] = 0.5f;
    fathom_mesh_default(&pyramid);
    pyramid.positions = corners, pyramid.vertex_count = 5;
    pyramid.indices = faces, pyramid.triangle_count = 4;
    TRY(fathom_scene_add_material(scene, "gold", &gold, &pyramid.material));
    TRY(fathom_scene_add_mesh(scene, FATHOM_ROOT, &pyramid, NULL));
    TRY(fathom_scene_add_plane(scene, FATHOM_ROOT, &ground, NULL));
    fathom_light_default(&light);
    light.position[0] = 3, light.position[1] = 5, light.position[2] = 4;
    light.intensity[0] = light.intensity[1] = light.intensity[2] = 60;
    TRY(fathom_scene_add_light(scene, &light, NULL));
    const double eye[] = {2, 3, 7}, target[] = {0, 0.4, 0}, up[] = {0, 1, 0};
    fathom_camera_look_at(eye, target, up, 0.7, &camera);
    return fathom_scene_set_camera(scene, &camera);
}

static bool on_progress(void *user, const fathom_progress *progress) {
    fprintf((FILE *)user, "%3.0f %%\n", 100 * progress->fraction);
    return true; /* false stops the render and keeps what is finished */
}

static fathom_status render(fathom_context *context, const fathom_scene *scene, const char *path) {
    fathom_status status;
    fathom_settings settings;
    fathom_write_options options;
    fathom_film *film;
    fathom_settings_default(&settings);
    settings.width = 640, settings.height = 360, settings.spp = 16;
    settings.target_error = 0; /* 16 samples of each pixel */
    fathom_write_options_default(&options);
    TRY(fathom_render(context, scene, &settings, on_progress, stderr, NULL, &film));
    printf("red in the middle: %g\n", (double)fathom_film_channel(film, "R")[180 * 640 + 320]);
    status = fathom_film_write(context, film, path, &options);
    fathom_film_destroy(film);
    return status;
}

int main(int argc, char **argv) {
    fathom_context *context;
    fathom_scene *scene;
    if (fathom_context_create(&context) != FATHOM_OK) return FATHOM_OUT_OF_RESOURCES;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status == FATHOM_OK) status = build(scene);
    if (status == FATHOM_OK) status = render(context, scene, argc > 1 ? argv[1] : "arrays.png");
    if (status != FATHOM_OK) fprintf(stderr, "%s\n", fathom_context_message(context));
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return (int)status;
}
