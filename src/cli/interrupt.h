/* Signals that end a process: Ctrl-C, SIGTERM, a closed terminal (SIGHUP), a limit on processor time
 * (SIGXCPU). The first one ends it at once while there is nothing to save; later it sets a flag, and the
 * finished work is saved. A second Ctrl-C or SIGTERM ends it at once. SIGUSR1 saves. */
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include <stdbool.h>

/* From now on a signal ends the process with FATHOM_INTERRUPTED and one line on stderr. */
void interrupt_install(void);

/* From now on (true) a signal only sets the flag, or (false) it ends the process again. */
void interrupt_keep_work(bool keep);

bool interrupt_asked(void);

/* From now on SIGUSR1 only asks for a save. */
void interrupt_install_save(void);
/* True when it did since the last call. */
bool interrupt_take_save(void);

#endif
