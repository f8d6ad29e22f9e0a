/* Runs a command and kills it at a random moment: kill_at SEED MILLISECONDS FOLDER COMMAND...
 *
 * Two times of three it waits until a temporary file appears in FOLDER, and kills within a few milliseconds
 * then: while a file is written. Otherwise the moment is anywhere in the given time. Prints what it did, and
 * ends with the command's exit code where the command was faster, else with 137, and only once the command's
 * own processes have ended: an image helper whose parent was killed keeps its file locked until it notices.
 */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* About as long as a small file is in the writing. */
#define WRITING_MICROSECONDS 4000u

/* Marsaglia's xorshift. */
static uint32_t random_below(uint64_t *state, uint32_t end) {
    *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
    return (uint32_t)((*state >> 32) % end);
}

static void sleep_microseconds(uint32_t n) {
    struct timespec left = {n / 1000000, (long)(n % 1000000) * 1000};
    while (nanosleep(&left, &left) != 0 && errno == EINTR) continue;
}

static long milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* Whether one of the files that have just appeared is a temporary one. */
static bool has_temporary(int watch) {
    _Alignas(struct inotify_event) char events[4096];
    ssize_t bytes = read(watch, events, sizeof events);
    for (ssize_t at = 0; at < bytes;) {
        const struct inotify_event *event = (const void *)(events + at);
        if (event->len && strstr(event->name, ".fathom-tmp")) return true;
        at += (ssize_t)(sizeof *event + event->len);
    }
    return false;
}

static bool has_ended(pid_t child) {
    siginfo_t info = {.si_pid = 0};
    return waitid(P_PID, (id_t)child, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == child;
}

/* False once the command has ended, or after a second. */
static bool await_temporary(int watch, pid_t child) {
    const long until = milliseconds() + 1000;
    while (milliseconds() < until && !has_ended(child)) {
        struct pollfd wait = {.fd = watch, .events = POLLIN};
        if (poll(&wait, 1, 10) > 0 && has_temporary(watch)) return true;
    }
    return false;
}

int main(int argc, char **argv) {
    if (argc < 5) return 2;
    uint64_t state = strtoull(argv[1], NULL, 10) * 0x9e3779b97f4a7c15u + 1;
    uint32_t span = (uint32_t)strtoul(argv[2], NULL, 10);
    for (int i = 0; i < 8; ++i) random_below(&state, 2);
    int watch = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (watch < 0 || inotify_add_watch(watch, argv[3], IN_CREATE) < 0 || !span) return 2;
    bool writing = random_below(&state, 3) > 0;
    uint32_t moment = random_below(&state, span * 1000), later = random_below(&state, WRITING_MICROSECONDS);
    if (prctl(PR_SET_CHILD_SUBREAPER, 1) != 0) return 2;
    pid_t child = fork();
    if (child == 0) {
        execvp(argv[4], argv + 4);
        _exit(127);
    }
    sleep_microseconds(moment);
    if (writing) {
        while (has_temporary(watch)) continue; /* those of before */
        if (await_temporary(watch, child)) sleep_microseconds(later);
    }
    kill(child, SIGKILL);
    int status;
    waitpid(child, &status, 0);
    while (wait(NULL) > 0) continue;
    close(watch);
    printf("%s after %u us%s\n", WIFSIGNALED(status) ? "killed" : "ended", moment,
           writing ? ", writing" : "");
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}
