/* Signals that end a process: Ctrl-C, SIGTERM, a closed terminal (SIGHUP), a limit on processor time
 * (SIGXCPU). While there is nothing to save, the first one ends the process at once; later it sets a flag,
 * and the finished work is saved. A second Ctrl-C or SIGTERM ends the process at once. SIGUSR1 requests a
 * save. */
#pragma once

#include <fathom/render.h>

/* After this call, a signal ends the process with FATHOM_INTERRUPTED and one line on stderr. */
void interrupt_install(void);

/* After this call, a signal only sets the flag (true), or ends the process again (false). */
void interrupt_keep_work(bool keep);

/* Sets the line that a signal prints when it ends the process. The text must stay valid. */
void interrupt_say(const char *text);

bool interrupt_asked(void);
/* A fathom_progress_fn that shows nothing, and stops the render after a signal. */
bool interrupt_go_on(void *user, const fathom_progress *progress);

/* After this call, SIGUSR1 only requests a save. */
void interrupt_install_save(void);
/* True if it requested a save since the last call. */
bool interrupt_take_save(void);
