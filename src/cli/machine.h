/* The program and the machine it runs on: `fathom --version`, and for results that are kept. */
#ifndef CLI_MACHINE_H
#define CLI_MACHINE_H

#include <jansson.h>
#include <stdbool.h>

/* One line to stdout; verbose: also the commit, the compiler, the libraries with their versions, and what of
 * the processor is used. */
void version_print(bool verbose);

/* {"cpu", "processors", "kernels", "compiler", "flags"} */
json_t *machine_json(void);
/* The commit of the source; NULL: unknown. */
const char *machine_commit(void);
/* Today, as 2026-11-21 in universal time. */
void machine_date(char out[16]);

#endif
