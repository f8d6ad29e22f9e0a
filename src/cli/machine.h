/* Describes the program and the machine, for `fathom --version` and for stored results. */
#pragma once

#include <jansson.h>
#include <stdbool.h>

/* Prints one line to stdout. verbose: also the commit, the compiler, the libraries with their versions, and
 * the processor features in use. */
void version_print(bool verbose);

/* Stored results begin with {"fathom", "commit", "date", "machine"}. The date is UTC; the machine is
 * {"cpu", "processors", "kernels", "compiler", "flags"}. */
json_t *machine_head(void);
/* The commit of the source; NULL: unknown. */
const char *machine_commit(void);
