/* Work on a thread of its own, while the calling thread stays free for progress and stopping. */
#ifndef JOB_WATCH_H
#define JOB_WATCH_H

typedef struct watch_calls {
    void (*work)(void *user);
    void (*tick)(void *user); /* about ten times a second, and once more when the work has ended */
} watch_calls;

/* Returns when the work has ended. tick is called from the calling thread alone. Where no thread can be had,
 * the calling thread works, and ticks at the end. */
void watch_run(const watch_calls *calls, void *user);

#endif
