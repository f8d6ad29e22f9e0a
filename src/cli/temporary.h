/* Files that are gone when the process is. */
#ifndef CLI_TEMPORARY_H
#define CLI_TEMPORARY_H

#include <fathom/base.h>

#define TEMPORARY_PATH 4096

/* An empty file in $TMPDIR, its name with this ending, to be removed with temporary_remove() or by a signal
 * that ends the process. */
fathom_status temporary_create(fathom_context *context, const char *ending, char path[TEMPORARY_PATH]);
void temporary_remove(char path[TEMPORARY_PATH]);

#endif
