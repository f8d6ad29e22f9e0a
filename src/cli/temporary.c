#include "cli/temporary.h"

#include "base/file.h"
#include "base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

fathom_status temporary_create(fathom_context *context, const char *ending, char path[TEMPORARY_PATH]) {
    const char *folder = getenv("TMPDIR");
    snprintf(path, TEMPORARY_PATH, "%s/fathom-XXXXXX%s", folder && *folder ? folder : "/tmp", ending);
    int file = mkstemps(path, (int)strlen(ending));
    if (file < 0) {
        fathom_status status =
            fail_file(context, FATHOM_OUT_OF_RESOURCES, path,
                      "cannot be written; expected a folder for temporary files in $TMPDIR");
        path[0] = '\0';
        return status;
    }
    file_abort_also(path);
    close(file);
    return FATHOM_OK;
}

void temporary_remove(char path[TEMPORARY_PATH]) {
    remove(path);
    file_abort_no_more(path);
}
