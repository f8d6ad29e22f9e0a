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
/* Splits the name of a tracer, such as "Embree 3.13.5, AVX-512", into version and instruction set. False: the
 * tracer is not Embree. */
bool machine_embree(const char *tracer, char version[64], char isa[64]);

/* The commit of the source; NULL: unknown. */
const char *machine_commit(void);
