/* Runs work on a separate thread, while the calling thread handles progress and stopping. */
#pragma once

typedef struct watch_calls {
    void (*work)(void *user);
    void (*tick)(void *user); /* about ten times a second, and once more when the work has ended */
} watch_calls;

/* Returns when the work has ended. tick is called from the calling thread only. If no thread can be created,
 * the calling thread does the work, and ticks at the end. */
void watch_run(const watch_calls *calls, void *user);
