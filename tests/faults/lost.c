/* In place of the image module: a library that ends the process while it is loaded, or waits for itself, in
 * the way that $FAULT_LOST names, as some of the image module's do when memory is lacking. */
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static void __attribute__((constructor)) lose(void) {
    const char *way = getenv("FAULT_LOST");
    if (!way) return;
    if (strcmp(way, "exit") == 0) exit(1);
    if (strcmp(way, "abort") == 0) abort();
    if (strcmp(way, "trap") == 0) raise(SIGTRAP);
    if (strcmp(way, "hang") == 0) {
        static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
        pthread_mutex_lock(&lock), pthread_mutex_lock(&lock);
    }
    if (strcmp(way, "fault") == 0) {
        volatile char *page = mmap(NULL, 4096, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        page[0] = 1;
    }
}
