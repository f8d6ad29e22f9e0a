/* `fathom --version`. */
#ifndef CLI_VERSION_H
#define CLI_VERSION_H

#include <stdbool.h>

/* One line to stdout; verbose: also the commit, the compiler, the libraries with their versions, and what of
 * the processor is used. */
void version_print(bool verbose);

#endif
