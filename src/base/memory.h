/* The machine's memory. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* The memory, in bytes, that is available on the machine without swapping, or what the container's limit
 * leaves if that is less; SIZE_MAX if unknown. malloc() does not tell: Linux grants more memory than exists.
 */
size_t memory_free(void);
/* True if this many bytes are free. Amounts of up to 256 MiB are not checked. */
bool memory_has(size_t bytes);

/* Bytes of the program and its libraries without a scene, and bytes of working memory per thread (0.55 MB
 * were measured). The image helper is a separate process of about 120 MB. */
#define MEMORY_PROGRAM 20000000u
#define MEMORY_THREAD 1000000u

/* Allocates zeroed memory. Up to 64 MiB, all pages are populated at once: page faults on first access would
 * cost 5 ms for a million pixels, and threads would wait for each other. NULL when out of memory. Release
 * with memory_return() and the same size. */
void *memory_take(size_t bytes);
void memory_return(void *data, size_t bytes);
/* The number of bytes, of `bytes`, that memory_take() makes resident at once. */
size_t memory_taken(size_t bytes);

/* Resident bytes of this process; 0 if unknown. */
size_t memory_resident(void);
/* Resident bytes that are not pages of files; memory_free() counts pages of files as free. 0 if unknown. */
size_t memory_private(void);
