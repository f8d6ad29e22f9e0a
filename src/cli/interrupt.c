#include "cli/interrupt.h"

#include "cli/log.h"

#include <fathom/file.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

static volatile sig_atomic_t asked, keep_work, save;
static struct timespec first;
static const char *volatile said = "interrupted; nothing was written";

/* timeout(1) and some shells send a signal to the process, and again to its group. The second one then comes
 * faster than a person could send it. */
#define SAME_SIGNAL_SECONDS 0.1

static bool is_echo(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - first.tv_sec) + 1e-9 * (double)(now.tv_nsec - first.tv_nsec) <
           SAME_SIGNAL_SECONDS;
}

/* A closed terminal sends SIGHUP twice: from its shell and from the system. SIGXCPU comes every second after
 * the limit. So a repetition of these does not mean that the process should end at once. */
static bool comes_again(int number) { return number == SIGHUP || number == SIGXCPU; }

/* Calls only async-signal-safe functions. */
static void on_signal(int number) {
    if (asked) {
        if (is_echo() || comes_again(number)) return;
        fathom_file_abandon_all();
        signal(number, SIG_DFL);
        raise(number);
        return;
    }
    clock_gettime(CLOCK_MONOTONIC, &first);
    asked = 1;
    if (keep_work) return;
    log_line(LOG_ERROR, said);
    fathom_file_abandon_all();
    _exit(FATHOM_INTERRUPTED);
}

static void on_save(int number) {
    (void)number;
    save = 1;
}

static const int ending[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};

static void install(int number, void (*handler)(int)) {
    struct sigaction old, action = {.sa_handler = handler, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof ending / sizeof *ending; ++i) sigaddset(&action.sa_mask, ending[i]);
    /* nohup, and shells that start background programs, ignore some signals; these stay ignored. */
    if (sigaction(number, NULL, &old) == 0 && old.sa_handler != SIG_IGN) sigaction(number, &action, NULL);
}

void interrupt_install(void) {
    for (size_t i = 0; i < sizeof ending / sizeof *ending; ++i) install(ending[i], on_signal);
}

void interrupt_install_save(void) { install(SIGUSR1, on_save); }

bool interrupt_take_save(void) {
    bool was = save;
    if (was) save = 0;
    return was;
}

void interrupt_keep_work(bool keep) { keep_work = keep; }

void interrupt_say(const char *text) { said = text; }

bool interrupt_asked(void) { return asked; }

bool interrupt_go_on(void *user, const fathom_progress *progress) {
    (void)user, (void)progress;
    return !asked;
}
