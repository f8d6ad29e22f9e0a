#include "cli/machine.h"

#include "cli/json_text.h"

#include <fathom/image.h>
#include <gmp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

/* The processor's name from /proc/cpuinfo. */
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

static fathom_build build_info(void) {
    fathom_build build = {.size = sizeof build};
    fathom_build_info(&build);
    return build;
}

static json_t *machine_json(void) {
    const fathom_build build = build_info();
    char cpu[128];
    find_cpu(cpu);
    return json_of(JSON("cpu", cpu), JSON("processors", build.processors), JSON("kernels", build.isa),
                   JSON("compiler", build.compiler), JSON("flags", FATHOM_FLAGS));
}

bool machine_embree(const char *tracer, char version[64], char isa[64]) {
    return sscanf(tracer, "Embree %63[^,], %63[^\n]", version, isa) == 2;
}

const char *machine_commit(void) { return *fathom_commit() ? fathom_commit() : NULL; }

json_t *machine_head(void) {
    const time_t now = time(NULL);
    struct tm day;
    char date[16] = "";
    if (gmtime_r(&now, &day)) strftime(date, sizeof date, "%Y-%m-%d", &day);
    return json_of(JSON("fathom", fathom_version()), JSON("commit", machine_commit()), JSON("date", date),
                   JSON("machine", machine_json()));
}

/* Not an error without the helper: Fathom still writes PNG. */
static void print_image_module(void) {
    fathom_context *context;
    char libraries[256];
    if (fathom_context_create(&context) != FATHOM_OK) return;
    if (fathom_image_libraries(context, libraries, sizeof libraries) == FATHOM_OK)
        printf("images    %s\n", libraries);
    else
        printf("images    EXR and PNG alone: %s\n", fathom_context_message(context));
    fathom_context_destroy(context);
}

void version_print(bool verbose) {
    printf("fathom %s\n", fathom_version());
    if (!verbose) return;
    const fathom_build build = build_info();
    char cpu[128];
    find_cpu(cpu);
    printf("commit    %s\n", machine_commit() ? machine_commit() : "unknown");
    printf("compiler  %s, %s\n", build.compiler, FATHOM_FLAGS);
    printf("tracer    %s\n", build.embree);
    printf("shading   %s\n", build.isa);
    print_image_module();
    printf("libraries %s, GMP %s\n", build.libraries, gmp_version);
    printf("processor %s, %u threads\n", cpu, build.processors);
}
