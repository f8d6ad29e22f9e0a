/* How much memory there is. */
#ifndef BASE_MEMORY_H
#define BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes that can be used before the machine swaps or a container's limit ends the process; SIZE_MAX when the
 * system does not tell. Linux hands out more memory than there is and kills who uses it, so that malloc()
 * alone does not tell. */
size_t memory_free(void);
/* Whether so many bytes can be had without others being pushed out, or this process killed: the system grants
 * more than there is. Little is not asked about. */
bool memory_has(size_t bytes);

/* The program with its libraries, before it holds a scene, and what a thread has under way; 0.55 MB of that
 * were measured. The image helper is another process, of some 120 MB. */
#define MEMORY_PROGRAM 20000000u
#define MEMORY_THREAD 1000000u

/* Zeroes, whose pages are there before they are used, up to 64 MB: touched one by one, a million pixels take
 * 5 ms longer, and the threads that touch them wait for each other. NULL where there is no room. Release with
 * memory_return(), of the same size. */
void *memory_take(size_t bytes);
void memory_return(void *data, size_t bytes);
/* Of so many bytes, what memory_take() makes part of memory_resident() at once. */
size_t memory_taken(size_t bytes);

/* Bytes of this process that are in memory now; 0 when the system does not tell. */
size_t memory_resident(void);
/* Of these, what is no part of a file: the pages of files count as free in memory_free(). */
size_t memory_private(void);

#endif
