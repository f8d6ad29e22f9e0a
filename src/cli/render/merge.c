#include "cli/command.h"
#include "cli/interrupt.h"
#include "cli/outputs.h"
#include "cli/provenance.h"
#include "cli/render/brightness.h"
#include "cli/render/images.h"

#include "base/clock.h"

#include <stdlib.h>

static fathom_status check_outputs(fathom_context *context, render_options *o) {
    fathom_status status = standard_output_begin(context, &o->outputs, NULL, 0);
    for (size_t i = 0; i < o->parts.count && status == FATHOM_OK; ++i)
        status = outputs_check_distinct(context, o->outputs.items, o->outputs.count, o->parts.items[i]);
    for (size_t i = 0; i < o->outputs.count && status == FATHOM_OK; ++i)
        status = fathom_write_check(context, o->outputs.items[i], &o->write);
    return status;
}

static void tell(const render_options *o, const fathom_film *film, const fathom_stats *stats, double began) {
    uint32_t width, height;
    if (o->common.quiet) return;
    fathom_film_size(film, &width, &height);
    images_print(o);
    printf(": %ux%u, %.1f spp, of %zu parts", width, height,
           (double)stats->samples / ((double)width * height), o->parts.count);
    brightness_print(o);
    printf(", %.2f s\n", clock_seconds() - began);
}

static fathom_status merge(fathom_context *context, render_options *o) {
    const double began = clock_seconds();
    fathom_film *film = NULL;
    fathom_stats stats = {.size = sizeof stats};
    fathom_status status = check_outputs(context, o);
    if (status == FATHOM_OK && images_need_helper(o)) fathom_image_prefetch();
    if (status == FATHOM_OK)
        status = fathom_parts_merge(context, o->parts.items, o->parts.count, &stats, &film);
    say_status(&command_merge, context, status);
    if (status == FATHOM_OK) {
        if (o->exposure == EXPOSURE_USUAL && fathom_film_exposure(film, &o->write.exposure))
            o->exposure = EXPOSURE_KEPT;
        brightness_settle(NULL, NULL, standard_output_shown(&o->outputs, 0), film, o);
        status = images_write(context, film, o);
    }
    if (status == FATHOM_OK) tell(o, film, &stats, began);
    fathom_film_destroy(film);
    return status;
}

static fathom_status run(int argc, char **argv) {
    render_options options;
    fathom_status status;
    fathom_context *context;
    render_options_default(&options);
    args_problem problem = {"-o IMAGE is missing"};
    bool fine = command_parse(&command_merge, argc, argv, &options, &status);
    if (fine && !(options.outputs.count && render_options_check_images(&options, &problem))) {
        status = say_usage(&command_merge, problem.text);
        fine = false;
    }
    if (fine) status = command_context(&options.common, &context);
    if (fine && status == FATHOM_OK) {
        options.write.command = provenance_command();
        interrupt_install();
        status = merge(context, &options);
        standard_output_end();
        fathom_context_destroy(context);
    }
    free(options.parts.items);
    return status;
}

const command command_merge = {
    .name = "merge",
    .usage = "PART ... -o IMAGE [-o IMAGE2 ...] [options]",
    .summary = "Join the parts that fathom render --part wrote to one image.",
    .text = "The image has the same bits as a render on a single machine. Give every part of\n"
            "one render exactly once. All parts must be finished.\n",
    .examples = "  fathom merge p*.part -o final.exr -o final.png\n",
    .args = {merge_option_table, {{"PART", offsetof(render_options, parts)}}, .many = true},
    .run = run,
};
