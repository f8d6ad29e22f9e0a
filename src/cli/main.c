#include "cli/command.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Results that did not arrive are a failure: the disk is full, the device is gone. */
static fathom_status finish(fathom_status status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    fprintf(stderr, "fathom: standard output cannot be written: %s\n", strerror(errno));
    return status == FATHOM_OK ? FATHOM_OUT_OF_RESOURCES : status;
}

static fathom_status dispatch(int argc, char **argv) {
    if (argc < 2) {
        help_overview(stderr);
        return FATHOM_BAD_USAGE;
    }
    const char *name = argv[1];
    if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) {
        printf("fathom %s\n", fathom_version());
        return FATHOM_OK;
    }
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        help_overview(stdout);
        return FATHOM_OK;
    }
    args_problem problem;
    if (name[0] == '-') {
        args_wrong(&problem, "expected a command before \"%.60s\"", name);
        return say_usage(NULL, problem.text);
    }
    const command *c = command_find(name, &problem);
    if (!c) return say_usage(NULL, problem.text);
    return c->run(argc - 1, argv + 1);
}

/* All files are closed by now. exit() would go on to tear down the image module's 260 libraries, one by one,
 * and wait for it where it is still being loaded; the system takes all back at once. Sanitizers report in
 * exit(). */
static _Noreturn void leave(fathom_status status) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    exit((int)status);
#else
    fflush(NULL);
    _exit((int)status);
#endif
}

int main(int argc, char **argv) { leave(finish(dispatch(argc, argv))); }
