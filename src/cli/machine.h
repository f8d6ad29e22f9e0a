/* Describes the program and the machine, for `fathom --version` and for stored results. */
#pragma once

#include <jansson.h>
#include <stdbool.h>

/* Prints one line to stdout. verbose: also the commit, the compiler, the libraries with their versions, and
 * the processor features in use. */
void version_print(bool verbose);

/* {"cpu", "processors", "kernels", "compiler", "flags"} */
json_t *machine_json(void);
/* The commit of the source; NULL: unknown. */
const char *machine_commit(void);
/* Today's date as "2026-11-21", in UTC. */
void machine_date(char out[16]);
