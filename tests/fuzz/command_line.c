/* The command line of `fathom render`, a word on each line: options and all their values, tracers among them;
 * and the readers of values that only other commands use. Nothing is run. */
#include "fuzz.h"

#include "cli/render/render_options.h"
#include "trace/spec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WORDS_MAX 64

typedef struct values {
    args_counts counts;
    args_size size;
    uint64_t count, number;
    uint32_t small;
    double real;
    float single;
    unsigned choice;
    args_list list;
} values;

static const args_option value_table[] = {
    {.help = "Values"},
    {"counts", 'c', "N,N", take_counts, offsetof(values, counts), 1, 1e15, "counts"},
    {"size", 's', "WxH", take_size, offsetof(values, size), 1, 65536, "size"},
    {"count", 'n', "N", take_u64, offsetof(values, count), 1, 1e15, "count"},
    {"number", 0, "N", take_u64, offsetof(values, number), 0, HUGE_VAL, "number"},
    {"small", 0, "N", take_u32, offsetof(values, small), 1, 1024, "small"},
    {"real", 'r', "X", take_f64, offsetof(values, real), -1e9, 1e9, "real"},
    {"single", 0, "X", take_f32, offsetof(values, single), -64, 64, "single"},
    {"choice", 0, "one|two|three", take_choice, offsetof(values, choice), 0, 0, "choice"},
    {"list", 'l', "TEXT", take_list, offsetof(values, list), 0, 0, "list"},
    {.help = NULL},
};

static void check_spec(const char *text) {
    trace_spec spec;
    fathom_status status = trace_spec_parse(fuzz_context(), text, &spec);
    if (status != FATHOM_OK && status != FATHOM_BAD_USAGE) fuzz_wrong("status %d", (int)status);
}

static void check_render(int argc, char **argv) {
    const args_spec spec = {.operands = {{"SCENE", offsetof(render_options, scene)}},
                            .table = render_option_table};
    render_options options;
    fathom_settings settings;
    args_problem problem;
    fathom_settings_default(&settings);
    render_options_default(&options);
    if (args_parse(&spec, argc, argv, &options, &problem) != ARGS_READY) return;
    if (!options.scene) fuzz_wrong("ready without a scene");
    if (render_options_finish(&options, &settings, &problem) && !options.outputs.count)
        fuzz_wrong("finished without an output");
}

static void check_values(int argc, char **argv) {
    const args_spec spec = {.options = value_table};
    values v = {.small = 1, .count = 1};
    args_problem problem;
    if (args_parse(&spec, argc, argv, &v, &problem) != ARGS_READY) return;
    bool fine = v.small >= 1 && v.small <= 1024 && v.count >= 1 && v.real >= -1e9 && v.real <= 1e9 &&
                v.single >= -64 && v.single <= 64 && v.choice < 3 && v.list.count <= ARGS_LIST_MAX &&
                v.counts.count <= ARGS_LIST_MAX && v.size.width <= 65536 && v.size.height <= 65536;
    for (size_t i = 0; i < v.counts.count; ++i) fine = fine && v.counts.items[i] >= 1;
    if (!fine) fuzz_wrong("a value out of its range was taken");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char *text = malloc(size + 1), *argv[WORDS_MAX + 1] = {"fathom"};
    int argc = 1;
    if (!text) abort();
    memcpy(text, data, size);
    text[size] = '\0';
    fuzz_begin(size, 16);
    for (char *word = text, *end; word < text + size && argc < WORDS_MAX; word = end + 1) {
        end = word + strcspn(word, "\n");
        *end = '\0';
        argv[argc++] = word;
    }
    for (int i = 1; i < argc && i < 4; ++i) check_spec(argv[i]);
    check_render(argc, argv);
    check_values(argc, argv);
    fuzz_end();
    free(text);
    return 0;
}
