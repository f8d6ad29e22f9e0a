#include "cli/machine.h"

#include "base/kernel.h"
#include "base/threads.h"
#include "cli/json_text.h"
#include "image/image.h"
#include "trace/trace.h"

#include <gmp.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <zlib.h>

/* The processor's name as the system has it. */
static void find_cpu(char out[128]) {
    snprintf(out, 128, "unknown");
    FILE *file = fopen("/proc/cpuinfo", "r");
    if (!file) return;
    char line[256];
    while (fgets(line, sizeof line, file)) {
        const char *value = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !value) continue;
        value += 1 + strspn(value + 1, " \t");
        snprintf(out, 128, "%.*s", (int)strcspn(value, "\n"), value);
        break;
    }
    fclose(file);
}

/* The instruction set of our own loops. Embree's is in its tracer's name. */
static const char *kernels_name(void) {
    static const char *const names[] = {"portable", "AVX2", "AVX-512"};
    return names[kernel_levels() - 1];
}

#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)

#if defined(__clang__)
#define COMPILER __VERSION__ /* which begins with its name */
#else
#define COMPILER "gcc " TEXT(__GNUC__) "." TEXT(__GNUC_MINOR__) "." TEXT(__GNUC_PATCHLEVEL__)
#endif

json_t *machine_json(void) {
    char cpu[128];
    find_cpu(cpu);
    return json_of(JSON("cpu", cpu), JSON("processors", processor_count()), JSON("kernels", kernels_name()),
                   JSON("compiler", COMPILER), JSON("flags", FATHOM_FLAGS));
}

const char *machine_commit(void) { return *fathom_commit() ? fathom_commit() : NULL; }

void machine_date(char out[16]) {
    time_t now = time(NULL);
    struct tm day;
    out[0] = '\0';
    if (gmtime_r(&now, &day)) strftime(out, 16, "%Y-%m-%d", &day);
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
    find_cpu(cpu);
    printf("commit    %s\n", machine_commit() ? machine_commit() : "unknown");
    printf("compiler  %s, %s\n", COMPILER, FATHOM_FLAGS);
    printf("tracer    %s\n", embree);
    printf("shading   %s\n", kernels_name());
    print_image_module();
    printf("libraries libpng %s, zlib %s, jansson %s, GMP %s\n", png_get_libpng_ver(NULL), ZLIB_VERSION,
           JANSSON_VERSION, gmp_version);
    printf("processor %s, %u threads\n", cpu, processor_count());
}
