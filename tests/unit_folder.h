/* A folder of the test's own, and a context. A file left in it at the end makes the program fail.
 */
#pragma once

#include "unit.h"

#include <fathom/base.h>

#include <unistd.h>

static fathom_context *context;
static char folder[] = "/tmp/fathom-test-XXXXXX";

/* The path of a file in it; valid until the eighth call after. */
static inline const char *in_folder(const char *name) {
    static char paths[8][256];
    static unsigned next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

/* Set-up and tear-down of a group of tests. Views are those of no $OCIO. */
static inline int open_folder(void **state) {
    (void)state;
    unsetenv("OCIO");
    return mkdtemp(folder) && fathom_context_create(&context) == FATHOM_OK ? 0 : -1;
}

static inline int remove_folder(void **state) {
    (void)state;
    fathom_context_destroy(context);
    return rmdir(folder);
}
