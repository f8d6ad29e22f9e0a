#include "cli/machine.h"

#include "base/kernel.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

void machine_cpu(char *out, size_t size) {
    snprintf(out, size, "unknown");
    FILE *file = fopen("/proc/cpuinfo", "r");
    if (!file) return;
    char line[256];
    while (fgets(line, sizeof line, file)) {
        const char *value = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !value) continue;
        value += 1 + strspn(value + 1, " \t");
        snprintf(out, size, "%.*s", (int)strcspn(value, "\n"), value);
        break;
    }
    fclose(file);
}

#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)

const char *machine_kernels(void) {
    static const char *const names[] = {"baseline", "AVX2", "AVX-512"};
    return names[kernel_levels() - 1];
}

const char *machine_compiler(void) {
#if defined(__clang__)
    return __VERSION__; /* which begins with its name */
#else
    return "gcc " TEXT(__GNUC__) "." TEXT(__GNUC_MINOR__) "." TEXT(__GNUC_PATCHLEVEL__);
#endif
}

const char *machine_flags(void) { return FATHOM_FLAGS; }

void machine_date(char out[16]) {
    time_t now = time(NULL);
    struct tm day;
    out[0] = '\0';
    if (gmtime_r(&now, &day)) strftime(out, 16, "%Y-%m-%d", &day);
}
