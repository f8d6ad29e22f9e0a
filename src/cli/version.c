#include "cli/version.h"

#include "base/kernel.h"
#include "base/threads.h"
#include "cli/machine.h"
#include "image/image.h"
#include "trace/trace.h"

#include <gmp.h>
#include <jansson.h>
#include <png.h>
#include <stdio.h>
#include <zlib.h>

static const char *kernels_name(void) {
    static const char *const names[] = {"portable", "AVX2", "AVX-512"};
    return names[kernel_levels() - 1];
}

/* Without the helper Fathom still writes PNG, so its lack is no failure. */
static void print_image_module(void) {
    fathom_context *context;
    char libraries[256];
    if (fathom_context_create(&context) != FATHOM_OK) return;
    if (image_libraries(context, libraries) == FATHOM_OK)
        printf("images    %s\n", libraries);
    else
        printf("images    PNG alone: %s\n", fathom_context_message(context));
    fathom_context_destroy(context);
}

void version_print(bool verbose) {
    printf("fathom %s\n", fathom_version());
    if (!verbose) return;
    char embree[64], cpu[128];
    trace_embree_name(embree, sizeof embree);
    machine_cpu(cpu, sizeof cpu);
    printf("commit    %s\n", *fathom_commit() ? fathom_commit() : "unknown");
    printf("compiler  %s, %s\n", machine_compiler(), machine_flags());
    printf("tracer    %s\n", embree);
    printf("shading   %s\n", kernels_name());
    print_image_module();
    printf("libraries libpng %s, zlib %s, jansson %s, GMP %s\n", png_get_libpng_ver(NULL), ZLIB_VERSION,
           JANSSON_VERSION, gmp_version);
    printf("processor %s, %u threads\n", cpu, processor_count());
}
