/* `fathom bench error`: image error against run time, by antialiasing pattern. */
#include "cli/bench/bench_error.h"

#include "base/status.h"
#include "cli/bench/bench.h"
#include "cli/bench/bench_run.h"
#include "cli/interrupt.h"
#include "cli/render/progress.h"
#include "image/compare/flip.h"

#include <math.h>

static bool on_progress(void *user, double fraction) {
    bench_progress_tell(user, fmin(fraction, 1));
    return !interrupt_asked();
}

static fathom_status open_stage(fathom_context *context, const bench_error_settings *asked,
                                bench_stage *stage) {
    fathom_status status = bench_open(context, asked->scene, asked->size, stage);
    /* As for a long render, as it is one. */
    return status == FATHOM_OK ? stage_build(context, stage, asked->tracer, 0) : status;
}

static fathom_status measure(fathom_context *context, const bench_error_settings *asked,
                             const bench_stage *stage, converge_result *result) {
    const converge_options options = {.rounds = asked->seeds,
                                      .max_spp = asked->max_spp,
                                      .half_spp = asked->half_spp,
                                      .seed = asked->seed,
                                      .ppd = asked->ppd,
                                      .progress = on_progress};
    interrupt_keep_work(true);
    fathom_status status = converge_measure(context, stage, &options, result);
    interrupt_keep_work(false);
    progress_clear_line();
    return status;
}

static fathom_status tell(fathom_context *context, const bench_error_settings *asked,
                          const bench_stage *stage, const converge_result *result, bool interrupted) {
    if (!asked->quiet) bench_error_print(asked, stage, result);
    json_t *root = bench_error_json(asked, stage, result);
    if (!root) return fail_memory(context, 4096);
    json_object_set_new(root, "interrupted", json_boolean(interrupted));
    fathom_status status = bench_output_write(context, &asked->output, root, bench_error_csv);
    json_decref(root);
    return status;
}

static fathom_status bench(fathom_context *context, const void *user) {
    const bench_error_settings *asked = user;
    bench_stage stage = {.scene = NULL};
    converge_result result = {.rounds = 0};
    trace_spec spec;
    fathom_status status = asked->tracer ? trace_spec_parse(context, asked->tracer, &spec) : FATHOM_OK;
    if (status == FATHOM_OK) status = bench_output_check(context, &asked->output, asked->scene);
    bench_progress_begin(asked->quiet);
    if (status == FATHOM_OK) status = open_stage(context, asked, &stage);
    if (status == FATHOM_OK) status = measure(context, asked, &stage, &result);
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    if (status == FATHOM_OK) status = tell(context, asked, &stage, &result, false);
    if (status == FATHOM_INTERRUPTED && result.runs.count) {
        status = tell(context, asked, &stage, &result, true);
        if (status == FATHOM_OK) {
            status = fail(context, FATHOM_INTERRUPTED,
                          "interrupted; what is told is of %u of %u seeds, to %u samples a pixel",
                          result.rounds, asked->seeds, 1u << (2 * (result.steps - 1)));
        }
    }
    converge_free(&result);
    stage_close(&stage);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_error_settings asked = {.seeds = 3, .max_spp = 1024, .ppd = FLIP_PPD};
    fathom_status status;
    if (!command_parse(&command_bench_error, argc, argv, &asked, &status)) return status;
    if (!asked.half_spp) asked.half_spp = asked.max_spp < 65536 / 4 ? 4 * asked.max_spp : 65536;
    return bench_run(&command_bench_error, asked.threads, asked.allow_outside, bench, &asked);
}

#define FIELD(name) offsetof(bench_error_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536, "pixels (the scene's, else 1280x720)"},
    {"seeds", 0, "N", take_u32, FIELD(seeds), 1, CONVERGE_SEEDS_MAX, "images of each pattern and spp (3)"},
    {"seed", 0, "N", take_u64, FIELD(seed), 0, 0, "of the first of them; the next have the next (0)"},
    {"max-spp", 0, "N", take_u32, FIELD(max_spp), 1, 65536,
     "the most samples a pixel: all of 1, 4, 16 and so on up to it (1024)"},
    {"reference-spp", 0, "N", take_u32, FIELD(half_spp), 1, 65536,
     "of each half of the reference (four times --max-spp)"},
    {"ppd", 0, "N", take_f64, FIELD(ppd), FLIP_PPD_LEAST, FLIP_PPD_MOST,
     "pixels that a degree of the eye holds, for FLIP (67: a 4K screen, 0.7 m wide and away)"},
    {"tracer", 0, "SPEC", take_text, FIELD(tracer), 0, 0, "what answers the rays (the scene's, else embree)"},
    {"threads", 0, "N", take_u32, FIELD(threads), 1, 1024, "1 to 1024 (one a processor)"},
    COMMAND_ALLOW_OUTSIDE(bench_error_settings),
    BENCH_OUTPUT_OPTIONS(bench_error_settings),
    {.help = NULL},
};
static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {FIELD(scene)};

const command command_bench_error = {
    .name = "bench error",
    .usage = "SCENE [options]",
    .summary = "Measure image error against run time.",
    .text = "Renders the scene by each antialiasing pattern (grid, stratified, sobol) with 1,\n"
            "4, 16, ... samples a pixel, and tells how far each image is from a reference:\n"
            "  RMSE    root of the mean squared difference of linear values\n"
            "  relMSE  mean of difference^2 / (reference^2 + 0.01)\n"
            "  FLIP    what is seen when flipping between the two, 0 to 1, after sRGB\n"
            "A pixel that is not finite is counted, makes the first two infinite and is the\n"
            "largest difference of the third. The reference is the mean of two independent\n"
            "halves; what is between them gives its own error, and images closer to it than\n"
            "they are to each other are marked and left out of slopes and tables.\n"
            "Times are of rendering alone: the scene is read and built once, before. A slope\n"
            "is a least-squares fit of ln error over ln seconds for each seed, and the mean\n"
            "of all, give or take Student's t s / sqrt(n); the grid has no seed, so that its\n"
            "interval is of times alone. Tables go by CPU time, of all threads together: on\n"
            "a shared machine it says more than the clock.\n"
            "Ctrl-C stops; seeds that are whole, or of the first the samples that all\n"
            "patterns have, are told and written, and the exit code is 5.\n",
    .examples = "  fathom bench error scenes/example.json --size 480x270 --report results\n"
                "  fathom bench error forest.glb --seeds 5 --max-spp 256 --csv forest.csv\n",
    .args = {options, operands, operand_offsets, 1},
    .run = run,
};
