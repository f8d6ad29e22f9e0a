/* Loads the module that knows MPI. */
#include "base/sized.h"
#include "image/helper/helper.h"
#include "job/ranks/mpi_module.h"

#include <dlfcn.h>

#define MODULE_FILE "fathom/fathom_mpi.so"

static const mpi_module *opened;

/* MPI loads plugins that need its symbols globally, hence RTLD_GLOBAL. */
static const mpi_module *load(fathom_context *context) {
    char path[PATH_MAX];
    if (!helper_find_file(MODULE_FILE, path)) {
        fail(context, FATHOM_OUT_OF_RESOURCES,
             "MPI: this Fathom was built without " MODULE_FILE
             "; expected a build on a machine that has Open MPI "
             "(Debian: libopenmpi-dev)");
        return NULL;
    }
    void *library = dlopen(path, RTLD_NOW | RTLD_GLOBAL);
    const mpi_module *module = library ? dlsym(library, MPI_MODULE_SYMBOL) : NULL;
    if (module && module->version == MPI_MODULE_VERSION) return module;
    const char *why = module ? "is of another build" : dlerror();
    fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "MPI: the module cannot be loaded: %s",
              why ? why : "?");
    return NULL;
}

fathom_status fathom_mpi_open(fathom_context *context, fathom_ranks *out) {
    fathom_ranks ranks;
    fathom_status status = sized_check(context, "ranks", out, sizeof *out);
    if (status != FATHOM_OK) return status;
    if (opened) return fail(context, FATHOM_BAD_USAGE, "MPI is open already");
    const mpi_module *module = load(context);
    if (!module) return FATHOM_OUT_OF_RESOURCES;
    fathom_ranks_default(&ranks);
    const char *why = module->open(&ranks);
    if (why) return fail(context, FATHOM_OUT_OF_RESOURCES, "MPI: %s", why);
    opened = module;
    sized_write(out, &ranks, sizeof ranks);
    return FATHOM_OK;
}

void fathom_mpi_close(bool finished) {
    if (opened && finished) opened->close();
    opened = NULL;
}
