/* The memory under shared libraries. */
#ifndef IMAGE_REST_H
#define IMAGE_REST_H

#include <stddef.h>

/* How many are loaded. Later ones have higher numbers. */
size_t rest_library_count(void);

/* Lets go of the pages of libraries from `first` on that are the file's own, code and tables: what runs comes
 * back from the system's cache. Loading reads the symbols of a library, most of which is never read again. */
void rest_libraries(size_t first);

#endif
