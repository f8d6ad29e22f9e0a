#include "cli/bench_run.h"

#include "cli/interrupt.h"

fathom_status bench_run(const command *c, unsigned threads, bool outside, bench_measure measure,
                        const void *asked) {
    fathom_context *context;
    fathom_status status = command_context(threads, &context);
    if (status != FATHOM_OK) return status;
    fathom_context_allow_outside(context, outside);
    interrupt_install();
    status = say_status(c, context, measure(context, asked));
    fathom_context_destroy(context);
    return status;
}

fathom_status bench_open(fathom_context *context, const char *path, args_size size, bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    *out = (bench_stage){.scene = NULL};
    const fathom_read_options read = {.width = size.width, .height = size.height};
    fathom_status status = fathom_scene_read_with(context, path, &read, &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    settings.spp = 1;
    settings.target_error = settings.max_time = 0;
    if (size.width) settings.width = size.width, settings.height = size.height;
    return stage_open(context, scene, &settings, out);
}

fathom_status bench_sphere(fathom_context *context, uint64_t triangles, fathom_scene **out) {
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.triangles = triangles;
    *out = NULL;
    fathom_status status = fathom_scene_create(context, out);
    return status == FATHOM_OK ? fathom_scene_generate(*out, FATHOM_ROOT, &options) : status;
}
