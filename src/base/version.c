#include "commit.h" /* by commit.cmake */

#include <fathom/base.h>

#define TEXT(x) #x
#define DOTTED(a, b, c) TEXT(a) "." TEXT(b) "." TEXT(c)

const char *fathom_version(void) {
    return DOTTED(FATHOM_VERSION_MAJOR, FATHOM_VERSION_MINOR, FATHOM_VERSION_PATCH);
}

const char *fathom_commit(void) { return FATHOM_COMMIT; }
