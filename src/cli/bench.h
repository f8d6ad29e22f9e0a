/* `fathom bench WHAT`: what measures. */
#ifndef CLI_BENCH_H
#define CLI_BENCH_H

#include "cli/command.h"

/* "error" for `fathom bench error`; NULL: none. */
const command *bench_find(const char *name);

#endif
