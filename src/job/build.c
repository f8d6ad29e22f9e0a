/* How the library was built, and the features of this machine that it uses. */
#include "base/kernel.h"
#include "base/sized.h"
#include "base/threads.h"
#include "trace/trace.h"

#include <jansson.h>
#include <png.h>
#include <zlib.h>

#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)

#if defined(__clang__)
#define COMPILER __VERSION__ /* begins with the name of the compiler */
#else
#define COMPILER "gcc " TEXT(__GNUC__) "." TEXT(__GNUC_MINOR__) "." TEXT(__GNUC_PATCHLEVEL__)
#endif

fathom_status fathom_build_info(fathom_build *out) {
    static const char *const kernels[] = {"portable", "AVX2", "AVX-512"};
    fathom_build build = {.version = fathom_version(),
                          .commit = fathom_commit(),
                          .compiler = COMPILER,
                          .isa = kernels[kernel_levels() - 1],
                          .libraries = "libpng " PNG_LIBPNG_VER_STRING ", zlib " ZLIB_VERSION
                                       ", jansson " JANSSON_VERSION,
                          .processors = processor_count()};
    fathom_status status = sized_check(NULL, "out", out, sizeof build);
    if (status != FATHOM_OK) return status;
    trace_embree_name(build.embree, sizeof build.embree);
    sized_write(out, &build, sizeof build);
    return FATHOM_OK;
}
