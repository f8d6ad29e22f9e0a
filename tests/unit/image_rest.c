/* Libraries whose pages were let go still work. */
#include "base/memory.h"
#include "image/loader.h"
#include "image/rest.h"
#include "unit.h"

#include <fathom/fathom.h>
#include <unistd.h>

static void write_image(fathom_context *context, const char *extension) {
    char path[64];
    snprintf(path, sizeof path, "/tmp/fathom-rest-%ld.%s", (long)getpid(), extension);
    fathom_scene *scene;
    fathom_settings settings;
    fathom_film *film;
    fathom_write_options options;
    fathom_sphere sphere;
    fathom_sphere_default(&sphere);
    fathom_settings_default(&settings);
    fathom_write_options_default(&options);
    settings.width = settings.height = 32;
    assert_ok(context, fathom_scene_create(context, &scene));
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &sphere, NULL));
    assert_ok(context, fathom_render(context, scene, &settings, NULL, NULL, NULL, &film));
    assert_ok(context, fathom_film_write(context, film, path, &options));
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
    assert_int_equal(remove(path), 0);
}

/* OpenImageIO and what it needs are hundreds of megabytes of files; loading reads far more of them than half
 * of what is asked for here. Linux keeps up to 64 pages a thread out of the sums it tells. */
static void memory_is_let_go(void **state) {
    (void)state;
    fathom_context *context;
    const image_module *module;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    size_t before = rest_library_count();
    assert_ok(context, loader_module(context, &module));
    assert_true(rest_library_count() > before);
    size_t loaded = memory_resident();
    rest_libraries(before);
    assert_true(memory_resident() + ((size_t)8 << 20) < loaded);
    write_image(context, "exr");
    write_image(context, "png");
    rest_libraries(before);
    write_image(context, "jpg");
    fathom_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(memory_is_let_go)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
