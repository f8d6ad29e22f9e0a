/* Telling a thread that waits for what never comes from one that is slow. */
#ifndef BASE_STALL_H
#define BASE_STALL_H

#include <stdbool.h>
#include <sys/types.h>

/* So long nothing may have happened on the thread. */
#define STALL_SECONDS 10

/* What looks at a thread have shown; {.thread = its number, as gettid() gives it}. */
typedef struct stall {
    pid_t thread;
    unsigned idle;               /* looks in a row that showed nothing new */
    double looked;               /* when the last one was */
    unsigned long long switches; /* how often the thread had gone to sleep by then, or made way */
} stall;

/* Looks at a thread of this process; to be called every tenth of a second or more often, which looks no more
 * often than that. True once the thread has slept through STALL_SECONDS of looks without waking once. One
 * that computes, that waits for a disk, that was stopped or that polls is not stalled, nor is one that the
 * system says nothing of, as where there is no /proc. Time in which nobody looks does not count: the process
 * may have been stopped. A file system in another process (FUSE) that answers nothing for so long does count.
 */
bool stall_look(stall *s);

#endif
