#include "cli/command.h"
#include "cli/log.h"
#include "cli/machine.h"
#include "cli/provenance.h"
#include "cli/render/exhausted.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* By default, writing to a pipe without a reader, or to a file beyond its size limit, would end the process
 * and lose hours of rendering. With these signals ignored, write() fails instead. */
static void ignore_signals(void) {
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

/* Opens standard streams that are closed. Otherwise the next file that is opened, such as an image, would get
 * their number and their text. */
static void hold_streams(void) {
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
        if (fcntl(stream, F_GETFD) >= 0) continue;
        int held = open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
        if (held != stream) return; /* no /dev/null: nothing more can be done */
    }
}

/* Reports output that could not be written: the disk is full, or the device or the reader is gone. */
static fathom_status finish(fathom_status status) {
    bool failed = ferror(stdout);
    errno = 0;
    failed |= fflush(stdout) != 0;
    if (!failed) return status;
    log_say(LOG_ERROR, "standard output cannot be written%s%s", errno ? ": " : "",
            errno ? strerror(errno) : "");
    return status == FATHOM_OK ? FATHOM_OUT_OF_RESOURCES : status;
}

static bool is_either(const char *text, const char *name, const char *letter) {
    return strcmp(text, name) == 0 || strcmp(text, letter) == 0;
}

static fathom_status dispatch(int argc, char **argv) {
    args_problem problem;
    if (!log_take_option(&argc, argv, &problem)) return say_usage(NULL, problem.text);
    provenance_note(argc, argv);
    if (argc < 2 && log_is_json()) return say_usage(NULL, "expected a command");
    if (argc < 2) {
        help_overview(stderr);
        return FATHOM_BAD_USAGE;
    }
    const char *name = argv[1];
    if (is_either(name, "--version", "-V")) {
        const int verbose = argc > 2 && is_either(argv[2], "--verbose", "-v");
        if (argc > 2 + verbose) {
            args_wrong(&problem, "%s: expected nothing after it, found \"%.60s\"", name, argv[2 + verbose]);
            return say_usage(NULL, problem.text);
        }
        version_print(verbose);
        return FATHOM_OK;
    }
    if (is_either(name, "--help", "-h")) name = "help";
    if (name[0] == '-') {
        args_wrong(&problem, "expected a command before \"%.60s\"", name);
        return say_usage(NULL, problem.text);
    }
    const command *c = command_find(commands, name, &problem);
    if (!c) return say_usage(NULL, problem.text);
    return command_run(c, argc - 1, argv + 1);
}

/* Skips exit(): all files are closed by now, and the system frees all memory faster. Sanitizers and coverage
 * need exit() to report. */
static _Noreturn void leave(fathom_status status) {
#if defined(FATHOM_SANITIZED) || defined(FATHOM_COVERAGE)
    exit((int)status);
#else
    fflush(NULL);
    _exit((int)status);
#endif
}

/* Large enough for any help text. So only finish() writes, and it knows why writing failed. */
static void buffer_output(void) {
    static char buffer[1 << 16];
    if (!isatty(STDOUT_FILENO)) setvbuf(stdout, buffer, _IOFBF, sizeof buffer);
}

int main(int argc, char **argv) {
    exhausted_watch();
    ignore_signals();
    hold_streams();
    buffer_output();
    fathom_guard_files();
    leave(finish(dispatch(argc, argv)));
}
