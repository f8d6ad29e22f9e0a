#include "cli/bench/bench.h"

#include <string.h>

/* What can be measured, a command of two words each. */
static const command *const benches[] = {&command_bench_trace,
                                         &command_bench_render,
                                         &command_bench_error,
                                         &command_bench_build,
                                         &command_bench_growth,
                                         &command_bench_secondary,
                                         NULL};

const command *bench_find(const char *name) {
    for (size_t i = 0; benches[i]; ++i) {
        if (strcmp(benches[i]->name + strlen("bench "), name) == 0) return benches[i];
    }
    return NULL;
}

static fathom_status run(int argc, char **argv) {
    if (argc < 2) return say_usage(&command_bench, "bench: expected what to measure");
    const command *found = bench_find(argv[1]);
    if (found) return found->run(argc - 1, argv + 1);
    if (args_ask_help(argc, argv)) {
        help_command(&command_bench, stdout);
        return FATHOM_OK;
    }
    char text[128];
    snprintf(text, sizeof text, "bench: there is nothing called \"%.60s\" to measure", argv[1]);
    return say_usage(&command_bench, text);
}

const command command_bench = {
    .name = "bench",
    .usage = "WHAT SCENE [options]",
    .summary = "Measure speed, and error against time.",
    .text = "WHAT is one of\n"
            "  trace      rays a second of every tracer, and what they cost to build\n"
            "  render     the phases of a render, and its distance from Embree's ceiling\n"
            "  error      image error against run time\n"
            "  build      what the quality of Embree's build costs and saves\n"
            "  growth     reading, building and tracing by the number of triangles\n"
            "  secondary  mirrored, refracted and shadow rays by depth, against single rays\n"
            "fathom help bench WHAT tells more.\n",
    .run = run};
