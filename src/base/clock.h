/* What time it took. */
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

/* Seconds since an arbitrary start, never going back. */
double clock_seconds(void);

/* Seconds of processor time: of the calling thread, and of all threads of the process together. */
double clock_thread_seconds(void);
double clock_process_seconds(void);

#endif
