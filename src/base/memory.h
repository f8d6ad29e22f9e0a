/* The machine's memory. */
#ifndef BASE_MEMORY_H
#define BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes free before the machine swaps or a container's limit ends the process; SIZE_MAX if unknown. Linux's
 * malloc() grants more memory than there is. */
size_t memory_free(void);
/* True if the bytes are free. Small amounts are not checked. */
bool memory_has(size_t bytes);

/* The program with its libraries before it holds a scene, and the working memory of a thread (0.55 MB were
 * measured). The image helper is another process of about 120 MB. */
#define MEMORY_PROGRAM 20000000u
#define MEMORY_THREAD 1000000u

/* Zeroed memory; up to 64 MB its pages are populated at once. Touching them one by one costs 5 ms for a
 * million pixels, and threads wait for each other. NULL without memory. Release with memory_return() and the
 * same size. */
void *memory_take(size_t bytes);
void memory_return(void *data, size_t bytes);
/* The part of so many bytes that memory_take() makes resident at once. */
size_t memory_taken(size_t bytes);

/* Bytes of this process that are in memory now; 0 if unknown. */
size_t memory_resident(void);
/* The part of them that belongs to no file: memory_free() counts pages of files as free. */
size_t memory_private(void);

#endif
