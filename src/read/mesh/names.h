/* Names to numbers: the first name is 0, the next new one 1, … */
#ifndef READ_NAMES_H
#define READ_NAMES_H

#include "base/array.h"

#include <stdint.h>

typedef struct name_entry {
    const char *text; /* the caller's, not terminated */
    size_t length;
} name_entry;

typedef struct name_table {
    ARRAY(name_entry) entries;
    uint32_t *slots; /* open addressing; entry + 1, 0: free */
    size_t slot_count;
} name_table;

/* The number of a name, which is added when it is new; UINT32_MAX when out of memory. The text must outlive
 * the table. */
uint32_t names_add(name_table *table, const char *text, size_t length);
/* UINT32_MAX when there is none. */
uint32_t names_find(const name_table *table, const char *text, size_t length);
void names_free(name_table *table);

#endif
