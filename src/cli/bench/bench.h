/* `fathom bench WHAT`: what measures. */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include "cli/command.h"

extern const command command_bench_trace, command_bench_render, command_bench_error, command_bench_build,
    command_bench_growth, command_bench_secondary;

/* "error" for `fathom bench error`; NULL: none. */
const command *bench_find(const char *name);

#endif
