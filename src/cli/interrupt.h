/* Ctrl-C and SIGTERM.
 *
 * The first one stops at once while there is nothing to save; afterwards it sets a flag, and what is finished
 * gets saved. A second one ends the process on the spot. */
#ifndef CLI_INTERRUPT_H
#define CLI_INTERRUPT_H

#include <stdbool.h>

/* From now on a signal ends the process with FATHOM_INTERRUPTED and one line on stderr. */
void interrupt_install(void);

/* From now on (true) a signal only sets the flag, or (false) it ends the process again. */
void interrupt_keep_work(bool keep);

bool interrupt_asked(void);

#endif
