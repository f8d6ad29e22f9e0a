#include "base/stall.h"

#include "base/clock.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LOOK_SECONDS 0.1

/* What follows `name` in /proc/self/task/…/status, or NULL. */
static const char *field(const char *text, const char *name) {
    const char *found = strstr(text, name);
    return found ? found + strlen(name) : NULL;
}

/* Whether the thread sleeps, in a way that signals may end (waiting for a disk is not), and how often it and
 * the scheduler have changed that. Takes no memory, which may be what the thread lacks. */
static bool sleeps(pid_t thread, unsigned long long *switches) {
    char path[64], text[4096];
    snprintf(path, sizeof path, "/proc/self/task/%d/status", (int)thread);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    ssize_t size = read(file, text, sizeof text - 1);
    close(file);
    if (size <= 0) return false;
    text[size] = '\0';
    const char *state = field(text, "\nState:\t"), *own = field(text, "\nvoluntary_ctxt_switches:\t"),
               *forced = field(text, "\nnonvoluntary_ctxt_switches:\t");
    if (!state || !own || !forced) return false;
    *switches = strtoull(own, NULL, 10) + strtoull(forced, NULL, 10);
    return *state == 'S';
}

bool stall_look(stall *s) {
    const unsigned enough = (unsigned)(STALL_SECONDS / LOOK_SECONDS);
    double now = clock_seconds();
    if (now - s->looked < LOOK_SECONDS) return s->idle > enough;
    s->looked = now;
    unsigned long long switches = 0;
    bool still = sleeps(s->thread, &switches) && (!s->idle || switches == s->switches);
    s->switches = switches;
    s->idle = still ? s->idle + 1 : 0;
    return s->idle > enough;
}
